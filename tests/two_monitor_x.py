"""A private X server with two monitors, for tests that look at a real screen (Xorg with its dummy driver)."""

import ctypes
import os
import select
import shutil
import subprocess
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from time import monotonic

import numpy as np
import numpy.typing as npt
from PIL import Image

FIRST = (640, 360)
SECOND = (800, 600)

CONFIG = f"""
Section "ServerFlags"
  Option "AutoAddDevices" "false"
  Option "AutoEnableDevices" "false"
  Option "AutoAddGPU" "false"
  Option "DontVTSwitch" "true"
EndSection
Section "Device"
  Identifier "card"
  Driver "dummy"
  VideoRam 32000
EndSection
Section "Monitor"
  Identifier "any"
  HorizSync 5.0-1000.0
  VertRefresh 5.0-200.0
  Modeline "{FIRST[0]}x{FIRST[1]}" 18.00 640 656 720 800 360 361 364 375 +hsync +vsync
  Modeline "{SECOND[0]}x{SECOND[1]}" 40.00 800 840 968 1056 600 601 605 628 +hsync +vsync
EndSection
Section "Screen"
  Identifier "screen"
  Device "card"
  Monitor "any"
  DefaultDepth 24
  SubSection "Display"
    Depth 24
    Modes "{FIRST[0]}x{FIRST[1]}" "{SECOND[0]}x{SECOND[1]}"
    Virtual 2048 1024
  EndSubSection
EndSection
"""

TOOLS = ("Xorg", "xrandr", "xdotool", "import")


class _ClientMessage(ctypes.Structure):
    """Xlib's XClientMessageEvent, filled up to the size of an XEvent."""

    _fields_ = (
        ("type", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("message_type", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 5),
        ("rest", ctypes.c_long * 12),
    )


class NoX(Exception):
    """The server cannot run on this machine; the text says why."""


@dataclass(frozen=True, slots=True)
class TwoMonitorX:
    """A running server: DUMMY0 of 640x360 at 0,0 and DUMMY1 of 800x600 right of it."""

    display: str

    def run(self, *command: str) -> bytes:
        """Run a program on this display and return what it wrote."""
        environment = {**os.environ, "DISPLAY": self.display}
        return subprocess.run(command, env=environment, check=True, capture_output=True, timeout=20).stdout

    def plug_both(self) -> None:
        """Both monitors on, side by side."""
        self.run("xrandr", "--output", "DUMMY0", "--mode", "640x360", "--pos", "0x0", "--primary")
        self.run("xrandr", "--output", "DUMMY1", "--mode", "800x600", "--pos", "640x0")
        self.run("xrandr", "-q")  # probes again: without it GLFW does not see the second monitor

    def unplug_second(self) -> None:
        """The cable of the second monitor is pulled."""
        self.run("xrandr", "--output", "DUMMY1", "--off")

    def ask_to_close(self, title: str) -> None:
        """What a desktop does when somebody clicks on a window's cross: the message WM_DELETE_WINDOW."""
        window = int(self.run("xdotool", "search", "--name", f"^{title}$").split()[0])
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype = ctypes.c_void_p
        x11.XInternAtom.restype = ctypes.c_ulong
        display = ctypes.c_void_p(x11.XOpenDisplay(self.display.encode()))
        event = _ClientMessage(type=33, send_event=1, window=window, format=32)
        event.message_type = x11.XInternAtom(display, b"WM_PROTOCOLS", 0)
        event.data[0] = x11.XInternAtom(display, b"WM_DELETE_WINDOW", 0)
        x11.XSendEvent(display, ctypes.c_ulong(window), 0, ctypes.c_long(0), ctypes.byref(event))
        x11.XCloseDisplay(display)

    def screenshot(self) -> npt.NDArray[np.uint8]:
        """What the whole desktop shows, RGB, shape (height, width, 3)."""
        plain = self.run("import", "-window", "root", "-depth", "8", "ppm:-")  # to pack it takes ten times as long
        return np.asarray(Image.open(BytesIO(plain)).convert("RGB"))


def start(directory: Path) -> tuple[TwoMonitorX, subprocess.Popen[bytes]]:
    """Start the server on a free display, its files in `directory`; raises `NoX`."""
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if missing:
        raise NoX(f"not installed: {', '.join(missing)}")
    (directory / "xorg.conf").write_text(CONFIG)
    log = directory / "xorg.log"
    reading, writing = os.pipe()
    command = ["Xorg", "-displayfd", str(writing), "-config", str(directory / "xorg.conf"), "-logfile", str(log)]
    command += ["-noreset", "-nolisten", "tcp"]
    if setpriv := shutil.which("setpriv"):  # the server ends with the tests, however they end
        command = [setpriv, "--pdeathsig", "TERM", *command]
    with (directory / "xorg.out").open("wb") as out:
        server = subprocess.Popen(command, pass_fds=(writing,), stdout=out, stderr=out, stdin=subprocess.DEVNULL)
    os.close(writing)
    try:
        number = _read_line(reading, seconds=15.0)
        if not number:
            reason = next((line for line in _lines(log) if "(EE)" in line), "it gave no reason")
            raise NoX(f"Xorg with the dummy driver does not start here: {reason}")
        there = TwoMonitorX(f":{number}")
        there.run("xrandr", "--addmode", "DUMMY1", "800x600")
        there.plug_both()
    except BaseException as error:
        stop(server)
        if isinstance(error, subprocess.SubprocessError):
            raise NoX(f"xrandr cannot set up two monitors: {error}") from error
        raise
    finally:
        os.close(reading)
    return there, server


def stop(server: subprocess.Popen[bytes]) -> None:
    """End the server, by force if it must be."""
    server.terminate()
    try:
        server.wait(5.0)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait(5.0)


def _read_line(descriptor: int, *, seconds: float) -> str:
    """The line that comes on a pipe within so many seconds; empty when it closes or stays silent."""
    text, deadline = b"", monotonic() + seconds
    while not text.endswith(b"\n"):
        ready, _, _ = select.select([descriptor], [], [], max(0.0, deadline - monotonic()))
        piece = os.read(descriptor, 64) if ready else b""
        if not piece:
            return ""
        text += piece
    return text.decode().strip()


def _lines(log: Path) -> list[str]:
    return log.read_text(errors="replace").splitlines() if log.exists() else []
