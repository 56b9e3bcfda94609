"""Place: where in the measure a grid is: how far in the present beat, and which beat of which metre that is."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.model import FIRST_SLOT, METRES, SLOTS, Float32, slot_metre

_OF: Final = tuple(slot_metre(slot) for slot in range(SLOTS - 1))
_NEXT: Final = tuple(first + (b + 1) % n for n, first in zip(METRES, FIRST_SLOT, strict=True) for b in range(n))
_PREVIOUS: Final = tuple(first + (b - 1) % n for n, first in zip(METRES, FIRST_SLOT, strict=True) for b in range(n))
_BEFORE, _AFTER = np.array(_PREVIOUS), np.array(_NEXT)


class Place:
    """Moves along the beats; the shares of all slots move with it."""

    def __init__(self) -> None:
        self.into = 0.0
        """How far the window of the present beat is past, 0 to 1 beat."""
        self.slot = FIRST_SLOT[METRES.index(4)]
        """Which beat of which metre is believed."""
        self.shares: npt.NDArray[np.float64] = np.zeros(SLOTS)
        """What the grid's states say of that, shape (SLOTS,)."""

    @property
    def metre(self) -> int:
        """Beats of a measure."""
        return _OF[self.slot][0]

    def beat(self, past: bool) -> int:
        """Which beat of its measure the present one is, from 0; that before it, where it is not yet `past`."""
        return _OF[self.slot if past else _PREVIOUS[self.slot]][1]

    def since(self, interval: float, centre: float) -> float:
        """Frames since the present beat (negative: ahead), which lies `centre` frames into its window."""
        return self.into * interval - centre

    def move(self, beats: float) -> None:
        """Go on, or back, by less than a beat."""
        self.into += beats
        if self.into >= 1.0:
            self.into -= 1.0
            self.slot = _NEXT[self.slot]
            self.shares[:-1] = self.shares[_BEFORE]
        elif self.into < 0.0:
            self.into += 1.0
            self.slot = _PREVIOUS[self.slot]
            self.shares[:-1] = self.shares[_AFTER]

    def begin(self, slot: int, shares: npt.NDArray[np.float64], beats: float) -> None:
        """`beats` after the window of the beat `slot` began, of which the states said `shares`."""
        self.into, self.slot = 0.0, slot
        self.shares[:] = shares
        for _ in range(int(beats)):
            self.move(1.0)
        self.move(beats - int(beats))

    def kept(self) -> Float32:
        """What the states say of metre and beat, shape (SLOTS,), sum 1; what is believed, where they say nothing."""
        share = np.asarray(self.shares, np.float32)
        total = float(share.sum())
        if total <= 0.0:
            share = np.zeros(SLOTS, np.float32)
            share[self.slot] = total = 1.0
        return share / np.float32(total)
