"""ClickTrack: a click on every beat of a Timeline, placed to the sample in blocks of sound."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.timeline import Timeline, phase

Float32 = npt.NDArray[np.float32]

LATE: Final = 0.040
"""A beat that has come to lie this long [s] before a block is still clicked, at its beginning; an older one is not."""

LOST: Final = 1.5
"""When the next beat is farther from the Timeline's [beats] it is another Timeline, and counting begins anew."""


class ClickTrack:
    """Fills blocks of one channel. Each beat clicks once, whatever the Timeline does: it never goes back.

    While somebody counts in, the accents lie on the measures that are counted, and the click is heard even if it is
    off. Thread: `fill` in the callback, which allocates nothing; `show` and `on` in one other.
    """

    def __init__(self, accent: Float32, beat: Float32, *, on: bool = True) -> None:
        """`accent` and `beat`: the sounds of a measure's first beat and of all others, one channel, full scale 1."""
        self.voices = (accent, beat)
        """Accent and beat; they change only while nothing is played."""
        self._shown: tuple[Timeline, float] | None = None
        self._sounding: Float32 = beat
        self._played = len(beat)
        self._next: int | None = None
        self.on = on
        """False: heard only while somebody counts in."""
        self.clicks = 0
        """Clicks since the start."""
        self.missed = 0
        """Beats that were known too late to be clicked."""

    def show(self, timeline: Timeline, one: float = -math.inf) -> None:
        """How the show runs; `one`: the beat that is counted down to, if somebody counts in."""
        self._shown = (timeline, one)

    def fill(self, out: Float32, begin: float, seconds: float) -> None:
        """Fill a block, shape (n,), that is heard from `begin` on [s of the show] and lasts `seconds`."""
        out[:] = 0.0
        self._go_on(out, 0)
        shown = self._shown
        if shown is None:
            return
        timeline, one = shown
        first = timeline.beat_at(begin)
        if self._next is None or abs(self._next - first) > LOST:
            self._next = math.ceil(first)
        end = timeline.beat_at(begin + seconds)
        while self._next < end:
            number, self._next = self._next, self._next + 1
            late = begin - timeline.time_at(number)
            if late > LATE:
                self.missed += 1
            elif self.on or number <= one:
                self._strike(out, number, timeline, one, max(-late, 0.0) / seconds)

    def _strike(self, out: Float32, number: int, timeline: Timeline, one: float, share: float) -> None:
        """A click `share` of the block after its beginning."""
        origin = one if number <= one else timeline.measure_origin
        accented = phase(number - origin, timeline.beats_per_measure) == 0.0
        self._sounding, self._played = self.voices[0 if accented else 1], 0
        self.clicks += 1
        self._go_on(out, min(round(share * out.shape[0]), out.shape[0] - 1))

    def _go_on(self, out: Float32, start: int) -> None:
        """The click that is sounding goes on in the block from frame `start`."""
        count = min(out.shape[0] - start, len(self._sounding) - self._played)
        if count > 0:
            part = out[start : start + count]
            np.add(part, self._sounding[self._played : self._played + count], out=part)
            self._played += count
