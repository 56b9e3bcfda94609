"""Practice mode: loops some measures of the score, optionally at a slower tempo."""

from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.control.events.events import ControlEvent, Practice
from live.show.loader import LoadedShow
from live.show.show import Show

SLOWEST = 20.0
FASTEST = 400.0
"""Tempi [bpm] that a show may have."""


def practice_tempo(options: LaunchOptions, loaded: LoadedShow) -> float | None:
    """Return the practice tempo [bpm]: that of `--bpm`, the patch's music or its clock, times `--tempo-share`."""
    patch = loaded.patch
    tempo = (options.bpm or patch.music.bpm or patch.clock.bpm) * (options.tempo_share or 1.0)
    if not SLOWEST <= tempo <= FASTEST:
        raise PersonError(f"--tempo-share: it gives {tempo:g} bpm; {SLOWEST:g} to {FASTEST:g} bpm are possible")
    return tempo


def practice_events(options: LaunchOptions, show: Show) -> list[ControlEvent]:
    """Return the events that start practice; raise PersonError for measures that the score does not have."""
    if options.measures is None:
        return []
    first, last = options.measures
    try:
        show.playhead.place_of_written(first - 1), show.playhead.place_of_written(last - 1)
    except ValueError as error:
        raise PersonError(f"--measures {first}-{last}: {error}", "live score shows them") from None
    return [Practice(time=0.0, source="practice", first=first, last=last)]
