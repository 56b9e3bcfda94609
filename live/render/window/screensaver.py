"""Screensaver inhibition: prevents screen saver and display sleep during a show, and restores them afterwards.

X11: XScreenSaverSuspend, which the server reverts when the process ends, even after a crash, and regular resets of the
idle time for desktops that measure it themselves. systemd, macOS and Windows: their own inhibition calls.
"""

import ctypes
import os
import shutil
import subprocess
import sys
from typing import Any, Final

RESET_PERIOD: Final = 20.0
"""Seconds between two resets of the idle time."""
_WHY: Final = "a show is on"
_INHIBIT_COMMANDS: Final = {
    "linux": (
        "systemd-inhibit", "--what=idle:sleep:handle-lid-switch", "--who=ChoreoGraphics Live", f"--why={_WHY}",
        "--mode=block", "cat",
    ),
    "darwin": ("caffeinate", "-d", "-i", "-m", "-w", str(os.getpid())),
}  # fmt: skip
_WINDOWS_AWAKE: Final = 0x80000000 | 0x00000001 | 0x00000002  # continuous, system and display required
_WINDOWS_USUAL: Final = 0x80000000


class ScreensaverInhibitor:
    """Inhibits display sleep from `start` to `stop`. Failures never affect a show. Thread: main thread only."""

    def __init__(self, x11_display: int | None = None) -> None:
        """`x11_display`: the address of Xlib's Display, from GLFW; None: there is no X server."""
        self._display = x11_display
        self._x11: Any = None
        self._saver: Any = None
        self._child: subprocess.Popen[bytes] | None = None
        self._next = 0.0
        self.methods: list[str] = []
        """Names of the inhibition methods in use."""

    def start(self) -> "ScreensaverInhibitor":
        """Start the inhibition."""
        if self._display is not None:
            self._suspend()
        self._start_child()
        if sys.platform == "win32":
            ctypes.windll.kernel32.SetThreadExecutionState(_WINDOWS_AWAKE)
            self.methods.append("SetThreadExecutionState")
        return self

    def _suspend(self) -> None:
        try:
            self._x11 = ctypes.CDLL("libX11.so.6")
        except OSError:
            return
        self._x11.XResetScreenSaver.argtypes = [ctypes.c_void_p]
        self._x11.XFlush.argtypes = [ctypes.c_void_p]
        self.methods.append("XResetScreenSaver")
        try:
            saver = ctypes.CDLL("libXss.so.1")
        except OSError:
            return
        saver.XScreenSaverSuspend.argtypes = [ctypes.c_void_p, ctypes.c_int]
        saver.XScreenSaverSuspend(self._display, 1)
        self._saver = saver
        self._x11.XFlush(self._display)
        self.methods.append("XScreenSaverSuspend")

    def _start_child(self) -> None:
        """Start a child that holds a system lock until its standard input ends, at the latest with this process."""
        command = _INHIBIT_COMMANDS.get(sys.platform, ())
        if not command or shutil.which(command[0]) is None:
            return
        quiet = subprocess.DEVNULL
        try:
            self._child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet)
        except OSError:
            return
        self.methods.append(command[0])

    def refresh(self, time: float) -> None:
        """Call once a frame, at `time` [s]; resets the idle time every `PERIOD`."""
        if self._x11 is not None and time >= self._next:
            self._next = time + RESET_PERIOD
            self._x11.XResetScreenSaver(self._display)
            self._x11.XFlush(self._display)

    def stop(self) -> None:
        """End the inhibition. Call it while the X server is still connected."""
        if self._saver is not None:
            self._saver.XScreenSaverSuspend(self._display, 0)
            self._x11.XFlush(self._display)
        self._x11 = self._saver = None
        if self._child is not None:
            if self._child.stdin is not None:
                self._child.stdin.close()
            self._child.terminate()
            self._child.wait()
            self._child = None
        if sys.platform == "win32":
            ctypes.windll.kernel32.SetThreadExecutionState(_WINDOWS_USUAL)
        self.methods.clear()


def x11_display() -> int | None:
    """Return the address of GLFW's connection to the X server, or None."""
    from live.render.window.monitors import start_glfw

    if not start_glfw() or sys.platform != "linux":
        return None
    import glfw

    any_glfw: Any = glfw
    if any_glfw.get_platform() != any_glfw.PLATFORM_X11:
        return None
    return ctypes.cast(any_glfw.get_x11_display(), ctypes.c_void_p).value
