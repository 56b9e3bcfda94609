"""Regression through the last beats, for a tempo finer than whole frames, and the grid's position in the measure."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32
from live.clock.bar_pointer.metre import FIRST_SLOT, METRES, NEXT, PREVIOUS, SLOTS, USED, slot_metre

Floats = npt.NDArray[np.float64]

MAX_BEATS: Final = 24
"""Number of beats kept."""

LINE_LENGTHS: Final = (24, 16, 12, 8, 6, 4)
"""Lengths of the line in beats: the longest with a good fit is used."""

MIN_BEATS: Final = LINE_LENGTHS[-1]

FALLBACK_LENGTH: Final = 12
"""Length if none fits: an unsteady tempo tends to return to its mean."""

MAX_SCATTER: Final = 0.9
"""A line fits if beats scatter about it by no more than this [frames], and ..."""

MAX_END_ERROR: Final = 0.5
"""... the mean error of the last three is no more than this: the tempo is not changing."""

PERIOD_TOLERANCE: Final = 0.02
"""If the present interval differs from the line's by more than this ratio, the tempo is changing."""

FADE_OUT_FRAMES: Final = 43
"""Frames (half a second) before the end of music whose beats are ignored, because of a possible fade-out."""


class BeatRegression:
    """Records beats that have passed, with their positions in the measure; `interval` is used in silence."""

    def __init__(self) -> None:
        self._time = np.zeros(MAX_BEATS)
        self._number = np.zeros(MAX_BEATS)
        self._slots = np.zeros((MAX_BEATS, SLOTS))
        self._slot = np.zeros(MAX_BEATS, np.int64)
        self._count = 0
        self._frame = 0
        self._ahead = True
        self._slope = 0.0
        self._previous_grid: tuple[Floats, Floats, Floats, npt.NDArray[np.int64], int, int] | None = None
        self.interval = 0.0
        """Frames from beat to beat by the line; by the newest value while there are too few beats."""

    def step(self, since: float, interval: float, slot: int, slots: Floats, *, restarted: bool) -> None:
        """Process one frame: the present beat's window places the beat `since` frames ago (negative: ahead).

        slot, slots (SLOTS,): its position in the measure, and the shares of all. anew: the grid has been replaced.
        """
        self._frame += 1
        if restarted:
            if self._count >= MIN_BEATS:
                kept = self._time.copy(), self._number.copy(), self._slots.copy(), self._slot.copy()
                self._previous_grid = (*kept, self._count, self._frame)
            self._count, self._slope = 0, 0.0
            self._ahead = since < 0.0
        elif self._ahead and since >= 0.0 and self._frame - since - float(self._time[-1]) > 0.5 * interval:
            number = self._number[-1] + max(round((self._frame - since - float(self._time[-1])) / interval), 1)
            self._pass(self._frame - since, number, slot, slots)
        self._ahead = since < 0.0
        near = self._slope > 0.0 and abs(self._slope / interval - 1.0) < PERIOD_TOLERANCE
        self.interval = self._slope if near else interval

    def skip_frame(self) -> None:
        """Process one frame of silence."""
        self._frame += 1

    def grid_before(self, age: float) -> tuple[float, float, int, Floats] | None:
        """Return the grid of the music that ended `age` frames ago, unaffected by its end.

        (frames since one of its beats, frames from beat to beat, the slot of that beat, the shares of all slots then);
        None if there are too few beats.
        """
        end = self._frame - age - FADE_OUT_FRAMES
        if self._previous_grid is not None and self._previous_grid[5] > end:
            self._time, self._number, self._slots, self._slot, self._count, _ = self._previous_grid
        while self._count and float(self._time[-1]) > end:
            for row in (self._time, self._number, self._slots, self._slot):
                row[1:] = row[:-1].copy()
            self._count -= 1
        if self._count < MIN_BEATS:
            return None
        slope, last = self._line()
        self._slope = self.interval = slope
        return self._frame - last, slope, int(self._slot[-1]), self._slots[-1].copy()

    def _pass(self, time: float, number: float, slot: int, slots: Floats) -> None:
        for row in (self._time, self._number, self._slots, self._slot):
            row[:-1] = row[1:]
        self._time[-1], self._number[-1], self._slots[-1], self._slot[-1] = time, number, slots, slot
        self._count = min(self._count + 1, MAX_BEATS)
        self._slope = self._line()[0] if self._count >= MIN_BEATS else 0.0

    def _line(self) -> tuple[float, float]:
        """Return (frames from beat to beat, the line's time of the last beat [frame]), from at least `MIN_BEATS`
        beats."""
        for count in (*LINE_LENGTHS, min(FALLBACK_LENGTH, self._count)):
            if count > self._count:
                continue
            known, number = self._time[MAX_BEATS - count :], self._number[MAX_BEATS - count :]
            middle = float(number.mean())
            off = number - middle
            slope = float(off @ known) / float(off @ off)
            error = known - known.mean() - slope * off
            if np.sqrt(np.mean(error**2)) <= MAX_SCATTER and abs(error[-3:].mean()) <= MAX_END_ERROR:
                break
        last = float(known.mean()) + slope * (float(number[-1]) - middle)
        return slope, last + float(error[-MIN_BEATS:].mean())


_OF: Final = tuple(slot_metre(slot) for slot in range(USED))
_NEXT, _PREVIOUS = tuple(NEXT.tolist()), tuple(PREVIOUS.tolist())


class MeasurePosition:
    """The grid's position in beat and measure; the shares of all slots move with it."""

    def __init__(self) -> None:
        self.phase = 0.0
        """Position in the present beat's window, 0 to 1 beat."""
        self.slot = FIRST_SLOT[METRES.index(4)]
        """Present slot: beat and metre."""
        self.shares: npt.NDArray[np.float64] = np.zeros(SLOTS)
        """Shares of the slots among the grid's states, shape (SLOTS,)."""

    @property
    def metre(self) -> int:
        """Beats in a measure."""
        return _OF[self.slot][0]

    def beat(self, past: bool) -> int:
        """Return the position of the present beat in its measure, from 0; of the one before it, if it is not yet
        `past`."""
        return _OF[self.slot if past else _PREVIOUS[self.slot]][1]

    @property
    def metre_share(self) -> float:
        """Share of the present metre among the slots, 0 to 1."""
        first = self.slot - _OF[self.slot][1]
        return float(self.shares[first : first + self.metre].sum() / max(float(self.shares.sum()), 1e-30))

    @property
    def window_beat(self) -> int:
        """The beat of the measure, from 0, in whose window the position is or last was."""
        return _OF[self.slot][1]

    def since(self, interval: float, centre: float) -> float:
        """Return the frames since the present beat (negative: ahead), which lies `centre` frames into its window."""
        return self.phase * interval - centre

    def move(self, beats: float) -> None:
        """Move forward or back by less than a beat."""
        self.phase += beats
        if self.phase >= 1.0:
            self.phase -= 1.0
            self.slot = _NEXT[self.slot]
            self.shares[:] = self.shares[PREVIOUS]
        elif self.phase < 0.0:
            self.phase += 1.0
            self.slot = _PREVIOUS[self.slot]
            self.shares[:] = self.shares[NEXT]

    def reset(self, slot: int, shares: npt.NDArray[np.float64], beats: float) -> None:
        """Set the position to `beats` after the start of the window of beat `slot`, with the slots' `shares` at that
        time."""
        self.phase, self.slot = 0.0, slot
        self.shares[:] = shares
        for _ in range(int(beats)):
            self.move(1.0)
        self.move(beats - int(beats))

    def slot_distribution(self) -> Float32:
        """Return the shares of metre and beat, shape (SLOTS,), sum 1; the present slot alone if there are none."""
        share = np.asarray(self.shares, np.float32)
        total = float(share.sum())
        if total <= 0.0:
            share = np.zeros(SLOTS, np.float32)
            share[self.slot] = total = 1.0
        return share / np.float32(total)
