"""Services for the musicians' click track and for an Ableton Link session."""

from typing import Final, cast

from rich.console import Console

from live.base.errors import PersonError, error_context
from live.base.event_queue import EventQueue
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.link.link_session import LinkSession, LinkUnavailable, Mode
from live.show.show import Show
from live.show.sound.click_link import ClickConnection, LinkConnection
from live.show.venue.venue import Venue


def make_click(
    device: str | None, channels: str | None, venue: Venue | None, show: Show, clock: Clock
) -> ClickConnection | None:
    """Return the click service for `--click` or the venue, not started; None if there is to be none.

    Raise PersonError, which lists the devices, if there is no such device.
    """
    audio = None if venue is None else venue.audio
    wanted = device or (None if audio is None else audio.click)
    if wanted is None:
        if channels is not None:
            raise PersonError("--click-channels without --click", "--click DEVICE, see `live devices`")
        return None
    from live.control.audio.channel_mixer import Channels
    from live.control.audio.click_output import ClickOutput
    from live.control.audio.devices import SoundUnavailable, UnknownDevice
    from live.show.sound.soundtrack import click_voices

    own = "1,2" if audio is None or audio.click_channels is None else ",".join(map(str, audio.click_channels))
    with error_context("--click-channels"):
        chosen = Channels.parse(channels or own)
    later = 0.0 if venue is None else venue.latency.click_ms / 1000.0
    try:
        output = ClickOutput(wanted, clock, click_voices, channels=chosen, extra_delay=later)
    except (UnknownDevice, SoundUnavailable) as error:
        raise PersonError(f"--click {wanted!r}: {error}") from None
    return ClickConnection(show, output)


OFF: Final = "off"


def make_link(
    wanted: str | None, show: Show, inbox: EventQueue[ControlEvent], clock: Clock, console: Console
) -> LinkConnection | None:
    """Return the Link service for `--link` or the patch, not started; None if there is to be none.

    If Link is not available, print a note and return None.
    """
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
        console.print(f"note: {error}; the show runs without it", style="yellow", soft_wrap=True, markup=False)
        return None
    return LinkConnection(show, session)
