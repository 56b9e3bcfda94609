"""Fallback window process: black windows under the show's, controlled by the supervisor and ended with it."""

import signal
import sys

from live.render.window.fallback_window import FallbackWindow, NoFallbackWindow
from live.render.window.monitors import UnknownMonitor, list_monitors, resolve_monitor
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import SupervisorLink

POLL_INTERVAL = 0.1


def main() -> None:
    """Carry out the supervisor's orders until it has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    lifeline = SupervisorLink.of_arguments(*sys.argv[1:3])
    try:
        guards = [FallbackWindow()]
    except NoFallbackWindow:
        sys.exit(0)
    while not lifeline.orphaned:
        lifeline.receive()
        if (order := lifeline.pop_request("screen")) is not None:
            _place_windows(guards, bool(order["fullscreen"]), [order["monitor"], *order.get("others", [])])
        lifeline.beat(0, Phase.RUNNING)
        guards[0].wait(POLL_INTERVAL)
        for guard in guards[1:]:
            guard.wait(0.0)
    for guard in guards:
        guard.close()


def _place_windows(guards: list[FallbackWindow], fullscreen: bool, names: list[str | None]) -> None:
    """Place a window under each full-screen window of the show."""
    while len(guards) < len(names):
        guards.append(FallbackWindow())
    for number, guard in enumerate(guards):
        needed = fullscreen and number < len(names)
        _place_window(guard, needed, names[number] if needed else None)


def _place_window(guard: FallbackWindow, fullscreen: bool, name: str | None) -> None:
    there = list_monitors()
    if not fullscreen or not there:
        guard.hide()
        return
    try:
        guard.cover(there[0] if name is None else resolve_monitor(name, there))
    except UnknownMonitor:  # it has just been unplugged
        guard.hide()


if __name__ == "__main__":
    main()
