"""Drift: the warp over the whole sequence, by which dancers are slowly ahead and behind, measure after measure (T056).

Cubic splines through random values, the phase accumulated.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.pose.drifting_kernels import drift_ahead
from live.show.dancers.rng import Purpose, chance_of

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

KNOT_LOW: Final = 0.125
KNOT_HIGH: Final = 0.5
"""Cycles per measure: dancers drift ahead and behind over two to eight measures."""
SPAN: Final = np.array([1.0, 11.0, 11.0, 1.0]) / 24.0
"""Weights of a uniform cubic B-spline's integral over one span."""


class Drift:
    """Where A dancers are in their drifting. To be asked in the order of the measures."""

    def __init__(self, count: int, seed: int) -> None:
        self._count, self._seed = count, seed
        self.phase: Float64 = np.zeros(count)
        """Phase of each dancer's warp when the present measure begins [rad], shape (A,)."""
        self._knots: Float64 = np.zeros((2, 4, count))
        self._amplitude_knots, self._frequency_knots = self._knots
        self._drawn: tuple[int | None, Float64] = None, np.zeros((2, count))
        self._knots_of: int | None = None
        self._passes: Float64 | None = None  # `_passed`, if it is worked out already

    def begin_measure(self, measure: int) -> None:
        """The measure `measure` (from 0) begins: the phase goes on, the splines move on."""
        self.phase += self._passed() if self._passes is None else self._passes
        first = 3 if self._knots_of == measure - 1 else 0
        if first:
            self._knots[:, :-1] = self._knots[:, 1:]
        self._knots_of = measure
        for n in range(first, 4):
            if self._drawn[0] != measure + n:
                self.foresee(measure + n)
            self._knots[:, n] = self._drawn[1]
        self._passes = None

    def foresee(self, measure: int) -> None:
        """Draw ahead what is needed in `measure` first: three measures before it."""
        drawn = chance_of(self._seed, Purpose.DRIFT, measure).uniform(0.0, 1.0, (2, self._count))
        drawn[1] = KNOT_LOW + (KNOT_HIGH - KNOT_LOW) * drawn[1]
        self._drawn = measure, drawn
        self._passes = self._passed()

    def _passed(self) -> Float64:
        """By how much the phase goes on in the present measure [rad], (A,)."""
        return np.asarray(2.0 * np.pi * (SPAN @ self._frequency_knots))

    def at(self, out: Float64, rows: Int64, fraction: float, most: Float64, liked: Int32, like: Int32) -> None:
        """How far the dancers `rows` (n,) are ahead (positive) or behind [share of a measure], `out` (n,).

        `most` (A,) is how far each may be; through the measure each goes over from the timing of `liked` (A,) to that
        of `like` (A,). A(x) sin φ(x): amplitude and frequency are uniform cubic B-splines, which stay between their
        random values, so |A'| + A φ' < 1 always holds and no clip runs backwards; φ is the integral of 2πf (T056 as
        corrected).
        """
        drift_ahead(out, rows, fraction, self.phase, self._knots, most, liked, like)
