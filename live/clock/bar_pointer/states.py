"""States: the shares of all (interval, position, metre, beat), in rings, one for each interval."""

from typing import Final

import numpy as np

from live.clock.bar_pointer.model import METRES, REACH, SLOTS, Float32, Model

BINS: Final = 24
"""Phase bins of a beat, as in kernels.py."""

TEMPO_WIDTH: Final = 0.01
PLACE_WIDTH: Final = 2.0
"""How far states lie from a grid that was kept (standard deviations: natural logarithm, frames)."""


class States:
    """The arrays that the kernels work on.

    `share` (N, 16) float32: interval k has length[k] rows from offset[k] on, a ring whose position 0 is at head[k].
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.length = model.intervals
        """Frames from beat to beat, shape (K,)."""
        self.count = int(self.length.size)
        self.offset = (np.cumsum(self.length) - self.length).astype(np.int32)
        self.head = np.zeros(self.count, np.int32)
        self.share = np.zeros((int(self.length.sum()), SLOTS), np.float32)
        self.flat = self.share.reshape(-1)
        """The same numbers in one row."""
        self.leaving = np.zeros((self.count, SLOTS), np.float32)
        self.entering = np.zeros((self.count, SLOTS), np.float32)
        self.histogram = np.zeros((self.count, BINS), np.float32)
        """Share of each interval and phase bin, shape (K, 24)."""
        self.boxes = np.zeros((self.count + 1, BINS))
        self.slot_share = model.slot_share()
        self.still = np.zeros((self.count, 2 * REACH + 1), np.float32)
        """Transitions of a tempo that cannot change."""
        self.still[:, REACH] = 1.0
        self.same_metre = np.eye(len(METRES), dtype=np.float32)
        self.near = self._near(model.near_tempo)
        self.partner = self._partners()
        self.interval_of = np.repeat(self.length, self.length)
        """The interval of each row, shape (N,)."""

    def fill(self) -> None:
        """As before anything was heard: tempi by preference, all phases and beats alike."""
        self.head[:] = 0
        tempo = self.model.tempo_share() / self.length
        self.share[:] = np.repeat(tempo, self.length)[:, None] * self.slot_share[None, :]

    def gather(self, interval: float, place: float, slots: Float32, doubt: float) -> None:
        """All states near one grid, but for a share `doubt`, which is as before anything was heard.

        interval [frames], place [beats since the beat's window began], slots (SLOTS,): shares of each slot.
        """
        off_tempo = np.log(self.interval_of / interval) / TEMPO_WIDTH
        off = self.positions() / self.interval_of - place
        off = (off - np.round(off)) * interval / PLACE_WIDTH
        near = np.exp(-0.5 * (off_tempo**2 + off**2))
        tempo = self.model.tempo_share() / self.length
        total = float(near.sum())
        self.share[:] = ((1.0 - doubt) / max(total, 1e-30) * near)[:, None] * slots[None, :]
        self.share += np.float32(doubt) * np.repeat(tempo, self.length)[:, None] * self.slot_share[None, :]

    def positions(self) -> Float32:
        """Position of each row at this moment [frames], shape (N,)."""
        at = np.arange(self.share.shape[0]) - np.repeat(self.offset + self.head, self.length)
        return np.mod(at, self.interval_of).astype(np.float32)

    def settle(self) -> None:
        """Bring the shares to the sum 1 again, none below what the kernels keep."""
        self.share[:, SLOTS - 1] = 0.0
        total = float(self.share.sum(dtype=np.float64))
        if total > 0.0:
            self.share *= np.float32(1.0 / total)
        else:
            self.fill()

    def _near(self, width: float) -> "np.typing.NDArray[np.int32]":
        lengths = self.length.astype(np.float64)
        low = np.searchsorted(lengths, lengths * (1.0 - width))
        high = np.searchsorted(lengths, lengths * (1.0 + width), side="right")
        return np.ascontiguousarray(np.stack([low, high], axis=1), np.int32)

    def _partners(self) -> "np.typing.NDArray[np.int32]":
        """Interval of half and of double the tempo for each k, shape (2 K,), -1 where there is none."""
        partner = np.full((self.count, 2), -1, np.int32)
        for k, length in enumerate(self.length.tolist()):
            for way, wanted in enumerate((2.0 * length, 0.5 * length)):
                nearest = int(np.argmin(np.abs(self.length - wanted)))
                if abs(self.length[nearest] - wanted) <= 1.0:
                    partner[k, way] = nearest
        return partner.reshape(-1)
