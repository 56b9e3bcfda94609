"""Look-ahead announcement of beats: each beat is reported once, shortly before it falls, and corrected if it moves."""

import math
from typing import Final

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.beat_estimate import BeatEstimate

LEAD: Final = 0.08
"""A beat is announced when it is this near [s]."""

MOVED: Final = 0.008
"""A beat that is still ahead is announced again if its estimated time has moved this far [s]."""

LATEST: Final = 0.045
"""A beat that was missed (the grid jumped) is still announced until it is this long past [s]."""

APART: Final = 0.5
"""Minimum distance of two beats in periods."""

BIAS: Final = -0.005
"""Correction of every beat's time [s]: instruments are detected this long after the note that is the beat.

It was set after the open excerpts had read 9 ms late, so their bias is no independent figure; synthetic music then
reads 3 to 4 ms early.
"""


class Announcer:
    """Turns a bar pointer's grid into beats. All times are seconds of audio."""

    def __init__(self) -> None:
        self._last = -math.inf

    def beat(
        self, pointer: BarPointer, moment: float, heard: float, hop: float, confidence: float
    ) -> BeatEstimate | None:
        """Return the beat to be announced now, if any.

        moment: the time that the pointer's last frame describes; heard: seconds of audio fed; hop: seconds per frame.
        """
        period = pointer.interval * hop
        if period <= 0.0:
            return None
        ahead = moment + pointer.to_next * hop + BIAS
        past = ahead - period
        if past - self._last > APART * period and heard - past <= LATEST:
            return self._named(pointer, past, period, heard, confidence, pointer.beat, math.nan)
        coming = (pointer.beat + 1) % pointer.metre
        if ahead - heard > LEAD:
            return None
        if ahead - self._last > APART * period:
            return self._named(pointer, ahead, period, heard, confidence, coming, math.nan)
        if self._last > heard and abs(ahead - self._last) > MOVED and ahead > heard:
            return self._named(pointer, ahead, period, heard, confidence, coming, self._last)
        return None

    def _named(
        self,
        pointer: BarPointer,
        position: float,
        period: float,
        heard: float,
        confidence: float,
        beat: int,
        replaces: float,
    ) -> BeatEstimate:
        self._last = position
        return BeatEstimate(
            position=position,
            period=pointer.period / pointer.interval * period,
            confidence=confidence,
            heard=heard,
            beat=beat,
            beats_per_measure=pointer.metre,
            replaces=replaces,
        )
