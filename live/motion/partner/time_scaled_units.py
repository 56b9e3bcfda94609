"""Units time-scaled to every legal duration, in the layout for products with an input (H002, H005)."""

from dataclasses import dataclass

import numpy as np

from live.base.arrays import Complex128, Float64, Int64
from live.motion.partner.point_clouds import Cloud, time_scaled
from live.motion.partner.units import Units


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """The P legal cells (unit, duration), in the order of their durations, at the rate of the search."""

    units: Units
    rate: float
    """Frames per second of the search [Hz]."""
    unit: Int64
    """Unit of each cell, (P,)."""
    duration: Int64
    """Duration of each in frames, ascending, (P,): duration + 1 samples, since neighbours share the boundary sample."""
    groups: tuple[tuple[int, int, int], ...]
    """(duration, first cell, last cell + 1) of the cells of each duration."""
    real: tuple[Float64, ...]
    """For each group the conjugate of the centred control clouds, ((duration + 1) C, cells): real part, z."""
    imaginary: tuple[Float64, ...]
    """Their imaginary part, -x."""
    control_height: tuple[Float64, ...]
    """Their heights, not centred."""
    size: Float64
    """Sum of squares of each cell's centred cloud and of its heights [m²], (P,)."""
    head: Complex128
    """First sample of the target, relative to the middle of the control cloud, (P, B)."""
    head_height: Float64
    tail: Complex128
    """Last sample of the target, likewise, (P, B)."""
    tail_height: Float64
    middle: Complex128
    """Middle of each cell's control cloud, (P,)."""

    @property
    def count(self) -> int:
        """Number of cells P."""
        return len(self.unit)


def legal_durations(seconds: float, rate: float, stretch: float) -> range:
    """Return the durations [frames] within `stretch` [s] of a unit's, or the nearest one; at least one frame."""
    first = int(np.ceil((seconds - stretch) * rate - 1e-9))
    last = int(np.floor((seconds + stretch) * rate + 1e-9))
    if last < first:
        first = last = round(seconds * rate)
    return range(max(first, 1), max(last, 1) + 1)


def make_stretches(units: Units, rate: float, stretch: float) -> Stretches:
    """Return all cells of `units` at `rate` [Hz], each unit up to `stretch` [s] shorter or longer."""
    cells = sorted(
        (duration, unit)
        for unit in range(units.count)
        for duration in legal_durations(float(units.seconds[unit]), rate, stretch)
    )
    duration, unit = (np.array(column, np.int64) for column in zip(*cells, strict=True))
    groups, heights, sizes, middles = [], [], [], []
    real: list[Float64] = []
    imaginary: list[Float64] = []
    heads: list[list[Cloud]] = []
    for frames in np.unique(duration).tolist():
        first, last = np.searchsorted(duration, [frames, frames + 1]).tolist()
        pairs = [_cell(units, int(one), frames) for one in unit[first:last]]
        floor = np.array([a.floor.ravel() for a, _ in pairs])
        height = np.array([a.height.ravel() for a, _ in pairs])
        middle = floor.mean(axis=1)
        floor -= middle[:, None]
        groups.append((frames, first, last))
        real.append(np.ascontiguousarray(floor.real.T))
        imaginary.append(np.ascontiguousarray(-floor.imag.T))
        heights.append(np.ascontiguousarray(height.T))
        sizes.append((np.abs(floor) ** 2).sum(axis=1) + (height**2).sum(axis=1))
        middles.append(middle)
        heads += [[b] for _, b in pairs]
    middle = np.concatenate(middles)
    ends = [np.array([getattr(b[0], part)[at] for b in heads]) for part in ("floor", "height") for at in (0, -1)]
    return Stretches(
        units, rate, unit, duration, tuple(groups), tuple(real), tuple(imaginary), tuple(heights),
        np.concatenate(sizes), ends[0] - middle[:, None], ends[2], ends[1] - middle[:, None], ends[3], middle,
    )  # fmt: skip


def _cell(units: Units, unit: int, frames: int) -> tuple[Cloud, Cloud]:
    """Return control and target of a unit in `frames` steps."""
    of = units.examples[int(units.example[unit])]
    start, length = float(units.start[unit]), float(units.length[unit])
    return time_scaled(of.control, start, length, frames), time_scaled(of.target, start, length, frames)
