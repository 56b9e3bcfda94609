"""Which ways of the system a show uses: those of Linux, or those that work on every system.

Linux passes descriptors to other processes, forks, has sockets of packets and reads /proc. The ways for every system
are loopback TCP with a token, files in memory by name, and psutil. They are also taken on Linux if `LIVE_PORTABLE` is
set, which is how they are tested.
"""

import contextlib
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Literal

LINUX: Final = sys.platform == "linux" and not os.environ.get("LIVE_PORTABLE")
"""Whether the ways of Linux are used."""

OFFSCREEN_GL: Final[Mapping[str, Any]] = {"backend": "egl"} if sys.platform == "linux" else {}
"""Arguments of `moderngl.create_context` with which it needs no screen."""


_CAPTURE: Final = {"linux": ("v4l2", "/dev/video{}"), "darwin": ("avfoundation", "{}:none"), "win32": ("dshow", "")}
"""Format of capture devices in FFmpeg, and the name of a numbered one, by system."""
_VIDEO_CLASS: Final = Path("/sys/class/video4linux")


def capture_device(name: str) -> tuple[str, str]:
    """Return FFmpeg's format and name of a capture device, which a person gives by number or by name."""
    form, numbered = _CAPTURE.get(sys.platform, _CAPTURE["linux"])
    name = numbered.format(name) if name.isdigit() and numbered else name
    return form, f"video={name}" if form == "dshow" and not name.startswith("video=") else name


def video_devices() -> list[tuple[str, str]] | None:
    """Return path and name of each camera of this machine, in order; None where the system does not tell."""
    if sys.platform != "linux":
        return None
    found = []
    with contextlib.suppress(OSError):
        for each in sorted(_VIDEO_CLASS.iterdir(), key=lambda path: (len(path.name), path.name)):
            with contextlib.suppress(OSError):
                if (each / "index").read_text().strip() == "0":  # further ones of a camera carry no pictures
                    found.append((f"/dev/{each.name}", (each / "name").read_text().strip()))
    return found


def has_desktop() -> bool:
    """Whether a window may be tried: X11 or Wayland is announced, or the system always has windows."""
    return sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def window_system() -> Literal["x11", "wayland"] | None:
    """Return which of them is used: X11 if it is announced, since it alone lets windows choose their monitors; None
    where neither is, or the system has its own."""
    if sys.platform != "linux" or not has_desktop():
        return None
    return "x11" if os.environ.get("DISPLAY") else "wayland"
