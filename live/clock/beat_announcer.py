"""Look-ahead announcement of beats: each beat is reported once, shortly before it falls, and corrected if it moves."""

import math
from typing import Final

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.beat_estimate import BeatEstimate

LOOK_AHEAD: Final = 0.08
"""A beat is announced when it is this near [s]."""

CORRECTION_THRESHOLD: Final = 0.008
"""A beat that is still ahead is announced again if its estimated time has moved this far [s]."""

MAX_LATENESS: Final = 0.045
"""A beat that was missed (the grid jumped) is still announced until it is this long past [s]."""

MIN_SPACING: Final = 0.5
"""Minimum distance of two beats in periods."""

BIAS: Final = -0.005
"""Correction of every beat's time [s]: instruments are detected this long after the note that is the beat.

It was set after the open excerpts had read 9 ms late, so their bias is no independent figure; synthetic music then
reads 3 to 4 ms early.
"""


class BeatAnnouncer:
    """Turns a bar pointer's grid into beats. All times are seconds of audio."""

    def __init__(self) -> None:
        self._last = -math.inf

    def beat(
        self, pointer: BarPointer, moment: float, fed: float, hop: float, confidence: float
    ) -> BeatEstimate | None:
        """Return the beat to be announced now, if any.

        moment: the time that the pointer's last frame describes; heard: seconds of audio fed; hop: seconds per frame.
        """
        period = pointer.interval * hop
        if period <= 0.0:
            return None
        ahead = moment + pointer.to_next * hop + BIAS
        past = ahead - period
        if past - self._last > MIN_SPACING * period and fed - past <= MAX_LATENESS:
            return self._announce(pointer, past, period, fed, confidence, pointer.beat, math.nan)
        coming = (pointer.beat + 1) % pointer.metre
        if ahead - fed > LOOK_AHEAD:
            return None
        if ahead - self._last > MIN_SPACING * period:
            return self._announce(pointer, ahead, period, fed, confidence, coming, math.nan)
        if self._last > fed and abs(ahead - self._last) > CORRECTION_THRESHOLD and ahead > fed:
            return self._announce(pointer, ahead, period, fed, confidence, coming, self._last)
        return None

    def _announce(
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
        runner_up, share = pointer.line_evidence.runner_up
        return BeatEstimate(
            position=position,
            period=pointer.period / pointer.interval * period,
            confidence=confidence,
            fed=heard,
            beat=beat,
            beats_per_measure=pointer.metre,
            runner_up=runner_up,
            runner_up_share=share,
            replaces=replaces,
        )
