"""One property of one node over time: the keys of a glTF animation channel, read at other times (specification, C)."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.motion import quaternion

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]
Interpolation = Literal["LINEAR", "STEP", "CUBICSPLINE"]

ON_KEY: Final = 0.01
"""Part of the way between two keys that is none: times are float32, in the tenth minute good to 0.06 ms."""
SHORTEST_GAP: Final = 1e-3
"""Keys nearer to each other [s] than this are one."""
LONGEST_GAP: Final = 1.0
"""Keys further apart [s] say nothing about frames."""
OFF_GRID: Final = 0.05
"""Part of a frame by which a key may lie beside it."""
LOWEST_RATE: Final = 20.0
IRREGULAR_RATE: Final = 60.0
"""Frames per second where the keys give none."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """K keys of a value of W numbers; a rotation is a unit quaternion (w, x, y, z)."""

    times: Float64
    """Ascending [s], shape (K,)."""
    values: Float64
    """At the keys, shape (K, W)."""
    interpolation: Interpolation
    is_rotation: bool
    tangents: tuple[Float64, Float64] | None = None
    """Of CUBICSPLINE: incoming and outgoing [per second], (K, W) each."""

    def at(self, times: Float64) -> Float:
        """The value at each of `times` (T,) [s], shape (T, W); before the first and after the last key it rests."""
        if len(self.times) == 1:
            return np.broadcast_to(self.values[0], (len(times), self.values.shape[1]))
        after = np.clip(np.searchsorted(self.times, times, side="right"), 1, len(self.times) - 1)
        before = after - 1
        span = self.times[after] - self.times[before]
        part = np.clip((times - self.times[before]) / np.maximum(span, 1e-9), 0.0, 1.0)
        part = np.where(part < ON_KEY, 0.0, np.where(part > 1.0 - ON_KEY, 1.0, part))
        if self.interpolation == "STEP":
            return np.asarray(self.values[np.where(part < 1.0, before, after)])
        if self.tangents is not None:
            value = self._spline(before, after, part[:, None], span[:, None])
            return quaternion.unit(value) if self.is_rotation else value
        if self.is_rotation:
            return quaternion.slerp(self.values[before], self.values[after], part)
        return np.asarray(self.values[before] * (1.0 - part[:, None]) + self.values[after] * part[:, None])

    def _spline(
        self, before: npt.NDArray[np.int64], after: npt.NDArray[np.int64], t: Float64, span: Float64
    ) -> Float64:
        """Cubic Hermite spline: (2t³ - 3t² + 1) v_k + d (t³ - 2t² + t) b_k + (3t² - 2t³) v_k+1 + d (t³ - t²) a_k+1."""
        incoming, outgoing = self.tangents or (self.values, self.values)
        square, cube = t * t, t * t * t
        return np.asarray(
            (2.0 * cube - 3.0 * square + 1.0) * self.values[before]
            + span * (cube - 2.0 * square + t) * outgoing[before]
            + (3.0 * square - 2.0 * cube) * self.values[after]
            + span * (cube - square) * incoming[after]
        )


def key_rate(times: Float64) -> float:
    """Frames per second of the grid on which all keys (K,) [s] lie; 60 where they lie on none.

    Exporters write a key per frame, or leave out some of them; rates below 20 are doubled (tripled ...), so that what
    bends between the keys is kept.
    """
    gaps = np.diff(times)
    long = gaps[gaps > SHORTEST_GAP]
    if not long.size:
        return IRREGULAR_RATE
    blur = float(np.spacing(np.float32(np.abs(times).max())))
    for gap in (float(np.median(long)), float(long.min())):
        gap = float(times[-1] - times[0]) / float(np.round(gaps / gap).sum())  # one gap alone is blurred
        places = (times - times[0]) / gap
        off = float(np.abs(places - np.round(places)).max())
        if off < OFF_GRID + blur / gap and gap <= LONGEST_GAP:
            rate = 1.0 / gap
            if abs(rate - round(rate)) < 1e-4 * rate:
                rate = float(round(rate))
            return rate * float(np.ceil(LOWEST_RATE / rate - 1e-9)) if rate < LOWEST_RATE else rate
    return IRREGULAR_RATE
