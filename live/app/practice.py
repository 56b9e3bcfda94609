"""Practice: some measures of the score again and again, and slower."""

from live.app.launch_options import Wish
from live.base.errors import PersonError
from live.control.events.events import ControlEvent, Practice
from live.show.loader import LoadedShow
from live.show.show import Show

SLOWEST = 20.0
FASTEST = 400.0
"""Tempi [bpm] that a show may have."""


def practice_tempo(wish: Wish, loaded: LoadedShow) -> float | None:
    """The tempo [bpm] of practice: that of the patch's music, clock or `--bpm`, times the share that is asked for."""
    patch = loaded.patch
    tempo = (wish.bpm or patch.music.bpm or patch.clock.bpm) * (wish.tempo_share or 1.0)
    if not SLOWEST <= tempo <= FASTEST:
        raise PersonError(f"--tempo-share: that makes {tempo:g} bpm; {SLOWEST:g} to {FASTEST:g} can be danced")
    return tempo


def practice_events(wish: Wish, show: Show) -> list[ControlEvent]:
    """What the show is told at its start; PersonError for measures that its score does not have."""
    if wish.measures is None:
        return []
    first, last = wish.measures
    try:
        show.playhead.of_written(first - 1), show.playhead.of_written(last - 1)
    except ValueError as error:
        raise PersonError(f"--measures {first}-{last}: {error}", "live score shows them") from None
    return [Practice(time=0.0, source="practice", first=first, last=last)]
