"""The part of a live show that is in an Ableton Link session."""

from typing import Final, cast

from rich.console import Console

from live.base.inbox import Inbox
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.link.link_session import LinkSession, LinkUnavailable, Mode
from live.show.core import Show
from live.show.sound.on_link import OnLink

OFF: Final = "off"


def make_link(
    wanted: str | None, show: Show, inbox: Inbox[ControlEvent], clock: Clock, console: Console
) -> OnLink | None:
    """What `--link` or the patch asks for, to be started; None if nothing, or (with a note) if Link is not there."""
    section = show.patch.link
    mode = wanted or section.mode
    if mode == OFF:
        return None
    try:
        session = LinkSession(
            inbox,
            clock,
            tempo=show.follower.tempo,
            beats_per_measure=show.timeline.beats_per_measure,
            mode=cast(Mode, mode),
            start_stop=section.start_stop,
        )
    except LinkUnavailable as error:
        console.print(f"note: {error}; the show goes on without it", style="yellow", soft_wrap=True, markup=False)
        return None
    return OnLink(show, session)
