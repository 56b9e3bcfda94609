"""The process with the black window under the show's; it does what the supervisor says, and ends with it."""

import signal
import sys

from live.alive.heartbeat import Phase
from live.alive.lifeline import Lifeline
from live.render.guard_window import GuardWindow, NoGuard
from live.render.monitors import UnknownMonitor, find_monitor, list_monitors

ROUND = 0.1


def main() -> None:
    """Wait for orders until the supervisor has gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    lifeline = Lifeline.inherited(int(sys.argv[1]), int(sys.argv[2]))
    try:
        guard = GuardWindow()
    except NoGuard:
        sys.exit(0)
    while not lifeline.alone:
        lifeline.listen()
        if (order := lifeline.order("screen")) is not None:
            _obey(guard, bool(order["fullscreen"]), order["monitor"])
        lifeline.beat(0, Phase.RUNNING)
        guard.wait(ROUND)
    guard.close()


def _obey(guard: GuardWindow, fullscreen: bool, name: str | None) -> None:
    there = list_monitors()
    if not fullscreen or not there:
        guard.hide()
        return
    try:
        guard.cover(there[0] if name is None else find_monitor(name, there))
    except UnknownMonitor:  # it has just been unplugged
        guard.hide()


if __name__ == "__main__":
    main()
