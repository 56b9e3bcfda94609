"""Announcer: names each beat once, shortly before it comes, and corrects the name while the beat is still ahead."""

import math
from typing import Final

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.beat_estimate import BeatEstimate

LEAD: Final = 0.08
"""A beat is named when it is this near [s]."""

MOVED: Final = 0.008
"""A beat that is still ahead is named again when it is believed to lie this far [s] from where it was said."""

LATEST: Final = 0.045
"""A beat that was overlooked (the grid jumped) is still named until it is this long past [s]."""

APART: Final = 0.5
"""Two beats are at least this far apart, in periods."""

BIAS: Final = -0.005
"""What is added to every beat's time [s]: instruments are heard this much after the note that is the beat.

Set after the open excerpts had read 9 ms late, so their bias is no independent figure; made music then reads 3 to 4 ms
early.
"""


class Announcer:
    """Turns a bar pointer's grid into beats. All times are seconds of sound."""

    def __init__(self) -> None:
        self._last = -math.inf

    def beat(
        self, pointer: BarPointer, moment: float, heard: float, hop: float, confidence: float
    ) -> BeatEstimate | None:
        """The beat that is to be named now, if any.

        moment: what the pointer's last frame spoke of; heard: how much sound has been fed; hop: seconds a frame.
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
