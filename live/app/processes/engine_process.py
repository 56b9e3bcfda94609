"""An engine as a process of its own: it begins a show, or waits until it goes on with one. See `live.alive`."""

import sys
from typing import TYPE_CHECKING, Final

from rich.console import Console

from live.app.exit_codes import EXIT_INTERRUPTED, EXIT_PERSON_ERROR, end_cleanly, show_person_error
from live.app.played import Played
from live.base.errors import PersonError
from live.base.native_stderr import outlive_terminals
from live.supervisor.cpu_priority import ENGINE_NICE, come_forward
from live.supervisor.lifeline import Lifeline

BEGINNERS: Final = ("engine", "standby")
"""Who begins something, and does not go on with it."""

if TYPE_CHECKING:
    from live.show.core import Show
    from live.show.load import LoadedShow


def play(lifeline: Lifeline, loaded: "LoadedShow | None" = None, show: "Show | None" = None) -> None:
    """Do what the supervisor says first. `loaded`, `show`: what this process was born with, if it was."""
    brief = lifeline.brief()
    played = Played.unpacked(brief.show)
    console = Console(stderr=True, highlight=False)
    if brief.role == "nursery":
        from live.app.processes.born import be_born

        here, loaded, show = be_born(played, lifeline, console)
        if here is not None:
            end_cleanly()
            play(here, loaded, show)
        return
    try:
        _play(brief.role, played, lifeline, loaded, show, console)
    except PersonError:
        if brief.role in BEGINNERS:  # what this machine was asked for cannot be; it is no fault of a running show
            lifeline.tell_end(EXIT_PERSON_ERROR)
        raise
    lifeline.tell_end(0)


def _play(
    role: str, played: Played, lifeline: Lifeline, loaded: "LoadedShow | None", show: "Show | None", console: Console
) -> None:
    if role == "engine":
        from live.app.stage import play_show

        come_forward(ENGINE_NICE)
        play_show(
            played.wish,
            monitor=played.monitor,
            fullscreen=played.fullscreen,
            headless=played.headless,
            lifeline=lifeline,
        )
    elif role == "standby":
        from live.app.processes.remote_standby import stand_by

        stand_by(played, lifeline, console)
    else:
        from live.app.processes.heir import take_over

        take_over(played, lifeline, loaded, show, waits=role == "spare", console=console)


def main() -> None:
    """Run until the show is over; the exit codes are those of `live`."""
    end_cleanly()
    outlive_terminals()
    try:
        play(Lifeline.inherited(int(sys.argv[1]), int(sys.argv[2])))
    except PersonError as error:
        show_person_error(error)
        sys.exit(EXIT_PERSON_ERROR)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)


if __name__ == "__main__":
    main()
