"""Fallback window process: black windows under the show's, controlled by the supervisor and ended with it."""

import signal
import sys

from live.render.window.fallback_window import GuardWindow, NoGuard
from live.render.window.monitors import UnknownMonitor, find_place, list_monitors
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import Lifeline

ROUND = 0.1


def main() -> None:
    """Carry out the supervisor's orders until it has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    lifeline = Lifeline.inherited(int(sys.argv[1]), int(sys.argv[2]))
    try:
        guards = [GuardWindow()]
    except NoGuard:
        sys.exit(0)
    while not lifeline.alone:
        lifeline.listen()
        if (order := lifeline.order("screen")) is not None:
            _obey(guards, bool(order["fullscreen"]), [order["monitor"], *order.get("others", [])])
        lifeline.beat(0, Phase.RUNNING)
        guards[0].wait(ROUND)
        for guard in guards[1:]:
            guard.wait(0.0)
    for guard in guards:
        guard.close()


def _obey(guards: list[GuardWindow], fullscreen: bool, names: list[str | None]) -> None:
    """Place a window under each full-screen window of the show."""
    while len(guards) < len(names):
        guards.append(GuardWindow())
    for number, guard in enumerate(guards):
        needed = fullscreen and number < len(names)
        _place(guard, needed, names[number] if needed else None)


def _place(guard: GuardWindow, fullscreen: bool, name: str | None) -> None:
    there = list_monitors()
    if not fullscreen or not there:
        guard.hide()
        return
    try:
        guard.cover(there[0] if name is None else find_place(name, there))
    except UnknownMonitor:  # it has just been unplugged
        guard.hide()


if __name__ == "__main__":
    main()
