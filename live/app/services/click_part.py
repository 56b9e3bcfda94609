"""The part of a live show that clicks for the players."""

from live.base.errors import PersonError, named
from live.clock.time_source import Clock
from live.show.core import Show
from live.show.sound.on_click import OnClick
from live.show.venue.venue import Venue


def make_click(
    device: str | None, channels: str | None, venue: Venue | None, show: Show, clock: Clock
) -> OnClick | None:
    """What `--click` or the venue asks for, to be started; None if nothing. PersonError that lists what there is."""
    audio = None if venue is None else venue.audio
    wanted = device or (None if audio is None else audio.click)
    if wanted is None:
        if channels is not None:
            raise PersonError("--click-channels without --click", "--click DEVICE, see `live devices`")
        return None
    from live.control.audio.channel_mixer import Channels
    from live.control.audio.click_output import ClickOutput
    from live.control.audio.sound_devices import SoundUnavailable, UnknownDevice
    from live.show.sound.tap_voices import click_voices

    own = "1,2" if audio is None or audio.click_channels is None else ",".join(map(str, audio.click_channels))
    with named("--click-channels"):
        chosen = Channels.of(channels or own)
    later = 0.0 if venue is None else venue.latency.click_ms / 1000.0
    try:
        output = ClickOutput(wanted, clock, click_voices, channels=chosen, later=later)
    except (UnknownDevice, SoundUnavailable) as error:
        raise PersonError(f"--click {wanted!r}: {error}") from None
    return OnClick(show, output)
