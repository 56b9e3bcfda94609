"""What a later decision would be worth: the offline search's units as they are known some time after their middle."""

import numpy as np
import numpy.typing as npt

from live.motion.partner.decoder import Reading
from live.motion.partner.partner_synthesis import SearchSettings, boundary_costs
from live.motion.partner.point_clouds import Cloud
from live.motion.partner.units import Units
from live.motion.partner_live.live_partner import LIVE_RATE
from live.motion.partner_live.online_decoder import OnlineDecoder

Bool = npt.NDArray[np.bool_]


class _Recalled(OnlineDecoder):
    """A reader that keeps what ended at each boundary, so that the best way can be gone back."""

    def __init__(self, units: Units, **how: float) -> None:
        super().__init__(units, path_count=128, **how)
        self.ended: dict[int, tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]] = {}

    def process_frame(self, *given: object, **more: object) -> None:
        super().process_frame(*given, **more)  # type: ignore[arg-type]
        slot = self.frame_index % self._ring
        if self._cell[slot, 0] >= 0:
            self.ended[self.frame_index] = self._cell[slot].copy(), self._before[slot].copy()

    def best_way(self) -> list[tuple[int, int]]:
        """(begin, unit) of what is danced by all that is seen by now, the latest first."""
        guess = self.best_hypothesis()
        if guess is None:
            return []
        found, begin = [(guess.begin, guess.unit)], guess.begin
        slot = begin % self._ring
        place = guess.turn * self._head[guess.unit] + guess.shift
        head = np.stack((place.real, place.imag, self._head_height[guess.unit]), axis=1).ravel()
        worth = self._score[slot] + self.k * ((self._end[slot] - head) ** 2).sum(axis=1)
        way = int(np.argmin(np.where(np.isfinite(worth), worth, np.inf)))
        while begin in self.ended and way >= 0:
            cell, before = self.ended[begin]
            begin -= int(self._stretches.duration[cell[way]])
            found.append((begin, int(self._stretches.unit[cell[way]])))
            way = int(before[way])
        return found


def agreement_by_lag(
    x: Cloud, units: Units, search: SearchSettings, offline: Reading, lags: tuple[float, ...], alike: Bool
) -> npt.NDArray[np.float64]:
    """For each lag [units after the middle of each unit] how many of `offline`'s units are known by then: the very
    same ones, and those `alike`, (n, 2)."""
    thin = x.resampled(LIVE_RATE)
    toll = boundary_costs(search, thin)
    assert toll is not None  # beats are known
    length = float(np.median(units.seconds)) * LIVE_RATE
    middles = [int((start + 0.5 * frames) / offline.rate * LIVE_RATE)
               for start, frames in zip(offline.start, offline.duration, strict=True)]  # fmt: skip
    reader = _Recalled(units, rate=LIVE_RATE, stretch=search.stretch, k=search.k * LIVE_RATE / search.rate)
    asked: dict[int, list[tuple[int, int]]] = {}
    for row, lag in enumerate(lags):
        for n, middle in enumerate(middles):
            asked.setdefault(min(middle + round(lag * length), thin.count - 1), []).append((row, n))
    found = np.zeros((len(lags), 2))
    for at in range(thin.count):
        reader.process_frame(thin.floor[at], thin.height[at], boundary=bool(toll[at] == 0.0), unit_frames=length)
        way = reader.best_way() if at in asked else []
        for row, n in asked.get(at, []):
            unit = next((one for begin, one in way if begin <= middles[n]), -1)
            found[row] += unit == offline.unit[n], unit >= 0 and alike[unit, offline.unit[n]]
    return found / offline.count
