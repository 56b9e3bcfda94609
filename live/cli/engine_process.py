"""An engine as a process of its own: it begins a show, or waits until it goes on with one. See `live.alive`."""

import sys
from typing import TYPE_CHECKING

from rich.console import Console

from live.alive.lifeline import Lifeline
from live.alive.priority import ENGINE_NICE, come_forward
from live.base.errors import PersonError
from live.cli.main import EXIT_INTERRUPTED, EXIT_PERSON_ERROR, end_cleanly, show_person_error
from live.cli.played import Played

if TYPE_CHECKING:
    from live.show.core import Show
    from live.show.load import LoadedShow


def play(lifeline: Lifeline, loaded: "LoadedShow | None" = None, show: "Show | None" = None) -> None:
    """Do what the supervisor says first. `loaded`, `show`: what this process was born with, if it was."""
    brief = lifeline.brief()
    played = Played.unpacked(brief.show)
    if brief.role == "engine":
        from live.cli.stage import play_show

        come_forward(ENGINE_NICE)
        play_show(
            played.wish,
            monitor=played.monitor,
            fullscreen=played.fullscreen,
            headless=played.headless,
            lifeline=lifeline,
        )
        return
    console = Console(stderr=True, highlight=False)
    if brief.role == "nursery":
        from live.cli.born import be_born

        here, loaded, show = be_born(played, lifeline, console)
        if here is not None:
            end_cleanly()
            play(here, loaded, show)
        return
    if brief.role == "standby":
        from live.cli.standby import stand_by

        stand_by(played, lifeline, console)
        return
    from live.cli.heir import take_over

    take_over(played, lifeline, loaded, show, waits=brief.role == "spare", console=console)


def main() -> None:
    """Run until the show is over; the exit codes are those of `live`."""
    end_cleanly()
    try:
        play(Lifeline.inherited(int(sys.argv[1]), int(sys.argv[2])))
    except PersonError as error:
        show_person_error(error)
        sys.exit(EXIT_PERSON_ERROR)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)


if __name__ == "__main__":
    main()
