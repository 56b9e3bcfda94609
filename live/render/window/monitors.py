"""Connected monitors, and their selection by number, name or position ("right of primary", "below 2").

GLFW is loaded and started here on first use, so headless machines never load it. On Linux, X11 is preferred if an X
server (or XWayland) answers, because under Wayland a program can neither place a window on a chosen monitor nor find
out its position (GLFW issue 2903).
"""

import os
import re
import subprocess
import sys
from collections import deque
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

from live.base.system.features import has_desktop, window_system

WAYLAND_TIMEOUT: Final = 10.0
"""Seconds for GLFW to start in a process that tries it."""

_messages: deque[str] = deque(maxlen=64)
_changes = 0
_problem = ""
_started = False


class UnknownMonitor(ValueError):
    """No monitor has this number or name; the message lists the connected ones."""


@dataclass(frozen=True, slots=True)
class Monitor:
    """One connected monitor: number from 1, name, position and size in screen coordinates, refresh rate [Hz]."""

    index: int
    name: str
    position: tuple[int, int]
    """Upper left corner on the desktop, x to the right, y down."""
    size: tuple[int, int]
    refresh_hz: float
    """0 if the display does not report it."""

    def __str__(self) -> str:
        (x, y), (width, height) = self.position, self.size
        rate = f" {self.refresh_hz:g} Hz" if self.refresh_hz else ""
        return f"{self.index} {self.name} ({width}x{height} at {x},{y}{rate})"


def _on_error(code: int, description: bytes | str) -> None:
    text = description.decode("utf-8", "replace") if isinstance(description, bytes) else description
    message = f"{text} (GLFW 0x{code:x})"
    if not _messages or _messages[-1] != message:  # the same message may come sixty times a second
        _messages.append(message)


def _on_monitor(_monitor: Any, _event: int) -> None:
    global _changes
    _changes += 1


def load_glfw() -> None:
    """Load GLFW without starting it; ImportError if it is not installed."""
    if (system := window_system()) is not None:
        # the wheel holds one library for X11 and another for Wayland and chooses by the kind of the session
        os.environ.setdefault("PYGLFW_LIBRARY_VARIANT", system)
    import glfw  # noqa: F401


@cache
def _wayland_starts() -> bool:
    """Whether GLFW starts here, tried in another process: with a compositor that has no seat it crashes."""
    program = "import glfw, sys; sys.exit(not glfw.init())"
    command = [sys.executable, "-c", program]
    try:
        return subprocess.run(command, capture_output=True, timeout=WAYLAND_TIMEOUT, check=False).returncode == 0
    except subprocess.TimeoutExpired:  # a slow machine, no crash
        return True
    except OSError:
        return False


def start_glfw() -> bool:
    """Load and start GLFW if it is not running; return False if there is no screen (see `screen_problem`).

    Thread: main thread only, like all of GLFW.
    """
    global _problem, _started
    if _started:
        return True
    try:
        load_glfw()
        import glfw
    except ImportError as error:
        _problem = f"GLFW cannot be loaded ({error}); install it with: pip install glfw"
        return False
    if window_system() == "wayland" and not _wayland_starts():
        _problem = (
            f"GLFW cannot start with the Wayland compositor at {os.environ['WAYLAND_DISPLAY']}; "
            "with XWayland (which sets DISPLAY) a window opens"
        )
        return False
    glfw.set_error_callback(_on_error)
    if window_system() == "x11" and glfw.platform_supported(glfw.PLATFORM_X11):
        glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_X11)
    _messages.clear()
    if not glfw.init():
        _problem = _messages.popleft() if _messages else "GLFW cannot be started"
        if not has_desktop():
            _problem = "no screen: neither DISPLAY nor WAYLAND_DISPLAY is set"
        return False
    _started, _problem = True, ""
    glfw.set_monitor_callback(_on_monitor)
    return True


def stop_glfw() -> None:
    """Close all windows and stop GLFW if it is running; it starts again on next use."""
    global _started
    if _started:
        import glfw

        _started = False
        glfw.terminate()


def screen_problem() -> str:
    """Return why there is no screen; empty if there is one."""
    return "" if start_glfw() else _problem


def monitor_changes() -> int:
    """Return how often a monitor was connected or disconnected since the start; counted while events are polled."""
    return _changes


def pop_messages() -> list[str]:
    """Return GLFW's error messages since the last call, without repetitions; none are printed."""
    taken = list(_messages)
    _messages.clear()
    return taken


def monitor_handles() -> list[tuple[Monitor, Any]]:
    """Return every connected monitor with its GLFW handle; empty if there is no screen.

    A handle is valid until events are polled again, because disconnecting frees it.
    """
    if not start_glfw():
        return []
    import glfw

    found: list[tuple[Monitor, Any]] = []
    for handle in glfw.get_monitors() or []:
        try:
            mode = glfw.get_video_mode(handle)
        except ValueError:  # disconnected meanwhile: the binding gets a null pointer
            continue
        name: Any = glfw.get_monitor_name(handle)  # bytes, unlike the binding's stub states
        text = name.decode("utf-8", "replace") if isinstance(name, bytes) else name or "unnamed"
        x, y = glfw.get_monitor_pos(handle)
        size = (int(mode.size.width), int(mode.size.height))
        found.append((Monitor(len(found) + 1, text, (int(x), int(y)), size, float(mode.refresh_rate)), handle))
    return found


def list_monitors() -> list[Monitor]:
    """Return the connected monitors, the primary one first; empty if there is no screen (see `screen_problem`)."""
    return [monitor for monitor, _ in monitor_handles()]


def find_monitor(text: str, monitors: list[Monitor] | None = None) -> Monitor:
    """Return the monitor with a number (from 1), a name, or an unambiguous beginning of a name.

    Case is ignored. `monitors`: the candidates (default: the connected ones). Raises `UnknownMonitor`.
    """
    there = list_monitors() if monitors is None else monitors
    wanted = text.strip().casefold()
    if wanted.isdecimal() and 1 <= int(wanted) <= len(there):
        return there[int(wanted) - 1]
    exact = [monitor for monitor in there if monitor.name.casefold() == wanted]
    begins = [monitor for monitor in there if wanted and monitor.name.casefold().startswith(wanted)]
    for matches in (exact, begins):
        if len(matches) == 1:
            return matches[0]
    what = "means several monitors" if exact or begins else "is not a monitor"
    if not there:
        problem = screen_problem() if monitors is None else ""
        raise UnknownMonitor(f"{text!r} {what}: there is none" + (f" ({problem})" if problem else ""))
    listing = "".join(f"\n  {monitor}" for monitor in there)
    raise UnknownMonitor(f"{text!r} {what}; choose by number or name:{listing}")


def match_monitor(wanted: Monitor, there: list[Monitor]) -> Monitor | None:
    """Return the monitor of `there` that is `wanted` after reconnection: same name, the nearest one if several."""
    named = [monitor for monitor in there if monitor.name == wanted.name]
    if not named:
        return None
    x, y = wanted.position
    return min(named, key=lambda monitor: abs(monitor.position[0] - x) + abs(monitor.position[1] - y))


_PLACE = re.compile(r"\s*(left of|right of|above|below)\s+(.+?)\s*", re.IGNORECASE)


def resolve_monitor(text: str, monitors: list[Monitor] | None = None) -> Monitor:
    """Return the monitor given by `primary`, a position relative to another (the nearest there), a number or a name.

    `monitors`: the candidates (default: the connected ones), the primary one first. Raises `UnknownMonitor`.
    """
    there = list_monitors() if monitors is None else monitors
    if text.strip().casefold() == "primary" and there:
        return there[0]
    match = _PLACE.fullmatch(text)
    if match is None:
        return find_monitor(text, monitors)
    side, other = match[1].casefold(), resolve_monitor(match[2], there)
    beside = [(far, each) for each in there if (far := _distance(side, other, each)) is not None]
    if not beside:
        listing = "".join(f"\n  {monitor}" for monitor in there)
        raise UnknownMonitor(f"there is no monitor {side} {other.name}; there is:{listing}")
    return min(beside, key=lambda found: found[0])[1]


def _distance(side: str, other: Monitor, each: Monitor) -> float | None:
    """Return the distance of a monitor on that side of another one, centre to centre; None if it is not there."""
    (x, y), (across, down) = _middle(each), _middle(other)
    right, below = x - across, y - down
    ahead = {"left of": -right, "right of": right, "above": -below, "below": below}[side]
    aside = abs(below if side.endswith("of") else right)
    return ahead + 2.0 * aside if ahead > 0.0 and aside <= 2.0 * ahead else None


def _middle(monitor: Monitor) -> tuple[float, float]:
    return monitor.position[0] + 0.5 * monitor.size[0], monitor.position[1] + 0.5 * monitor.size[1]
