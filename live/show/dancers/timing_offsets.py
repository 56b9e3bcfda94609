"""Timing offsets between dancers: slow random drift (T056) and ripples that run over a group (T051).

Drift is a time warp over the whole sequence, made of cubic splines through random values. A ripple delays dancers from
one side of the stage to the other, or outward from a point.
"""

import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int32, Int64
from live.base.errors import PersonError
from live.motion.pose.pipeline_kernels import drift_leads
from live.show.dancers.rng import Purpose, generator_for

MIN_DRIFT_FREQUENCY: Final = 0.125
MAX_DRIFT_FREQUENCY: Final = 0.5
"""Range of drift frequencies [cycles per measure]: one cycle takes two to eight measures."""
SPLINE_WEIGHTS: Final = np.array([1.0, 11.0, 11.0, 1.0]) / 24.0
"""Weights of a uniform cubic B-spline's integral over one span."""


class Drift:
    """Drift of A dancers. Measures must be begun in order."""

    def __init__(self, count: int, seed: int) -> None:
        self._count, self._seed = count, seed
        self.phase: Float64 = np.zeros(count)
        """Phase of each dancer's warp at the beginning of the present measure [rad], shape (A,)."""
        self._knots: Float64 = np.zeros((2, 4, count))
        self._amplitude_knots, self._frequency_knots = self._knots
        self._drawn: tuple[int | None, Float64] = None, np.zeros((2, count))
        self._knots_of: int | None = None
        self._passes: Float64 | None = None  # cached result of `_phase_advance`

    def begin_measure(self, measure: int) -> None:
        """Begin the measure `measure` (from 0): advance the phase and the spline knots."""
        self.phase += self._phase_advance() if self._passes is None else self._passes
        first = 3 if self._knots_of == measure - 1 else 0
        if first:
            self._knots[:, :-1] = self._knots[:, 1:]
        self._knots_of = measure
        for n in range(first, 4):
            if self._drawn[0] != measure + n:
                self.draw_knots(measure + n)
            self._knots[:, n] = self._drawn[1]
        self._passes = None

    def draw_knots(self, measure: int) -> None:
        """Draw the knots of `measure`, up to three measures ahead of it."""
        drawn = generator_for(self._seed, Purpose.DRIFT, measure).uniform(0.0, 1.0, (2, self._count))
        drawn[1] = MIN_DRIFT_FREQUENCY + (MAX_DRIFT_FREQUENCY - MIN_DRIFT_FREQUENCY) * drawn[1]
        self._drawn = measure, drawn
        self._passes = self._phase_advance()

    def _phase_advance(self) -> Float64:
        """Return the change of the phase over the present measure [rad], (A,)."""
        return np.asarray(2.0 * np.pi * (SPLINE_WEIGHTS @ self._frequency_knots))

    def at(
        self,
        out: Float64,
        rows: Int64,
        fraction: float,
        most: Float64,
        previous_timing_source: Int32,
        timing_source: Int32,
    ) -> None:
        """Write the drift of the dancers `rows` (n,), positive ahead [share of a measure], to `out` (n,).

        `most` (A,) is the largest drift of each dancer. Over the measure each dancer changes from the timing of dancer
        `previous_timing_source` (A,) to that of `timing_source` (A,). The drift is A(x) sin φ(x), where φ is the
        integral of 2πf (T056 as corrected). A and f are uniform cubic B-splines, which stay between their random
        values, so |A'| + A φ' < 1 always holds and no clip runs backwards.
        """
        drift_leads(out, rows, fraction, self.phase, self._knots, most, previous_timing_source, timing_source)


SIDES: Final = {"left": (1.0, 0.0), "right": (-1.0, 0.0), "back": (0.0, 1.0), "front": (0.0, -1.0)}
"""Sides at which a ripple may begin, as the audience sees them, and the direction (x, z) in which it runs."""
MIN_EXTENT: Final = 0.5
"""Least extent of a group [m]: narrower groups count as this wide, so that delays do not flicker on one spot."""
DELAY_STEP: Final = 1.0 / 16.0
"""Delays are multiples of this [beats]."""
_NUMBER: Final = r"[+-]?[0-9]{1,3}(?:\.[0-9]{1,6})?"
_POINT: Final = re.compile(rf"({_NUMBER})[ ,]+({_NUMBER})")


@dataclass(frozen=True, slots=True)
class Ripple:
    """A delay that grows over a group, from an origin to the dancer farthest from it."""

    beats: float = 0.0
    """Delay of the last dancer behind the first [beats]; 0 for no ripple."""
    side: str = "left"
    """The side where it begins, "centre" for the group's middle, or "" for a point."""
    point: tuple[float, float] = (0.0, 0.0)
    """That point (x, z) [m]."""

    def delays(self, place: Float64) -> Float64:
        """Return the delays of dancers at `place` (n, 2) [m] [beats], shape (n,)."""
        if self.beats == 0.0 or len(place) < 2:
            return np.zeros(len(place))
        if self.side in SIDES:
            way = place @ np.array(SIDES[self.side])
        else:
            origin = place.mean(axis=0) if self.side == "centre" else np.array(self.point)
            way = np.hypot(*(place - origin).T)
        way = way - way.min()
        return np.asarray(np.round(self.beats / DELAY_STEP * way / max(float(way.max()), MIN_EXTENT)) * DELAY_STEP)


def parse_ripple(words: str, beats: float) -> Ripple:
    """Return the ripple of `beats` that begins at the place in `words`. Raises PersonError if they name no place."""
    said = " ".join(words.casefold().split())
    if said in SIDES or said == "centre":
        return Ripple(beats, said)
    if match := _POINT.fullmatch(said):
        return Ripple(beats, "", (float(match[1]), float(match[2])))
    raise PersonError(
        f"a ripple cannot begin at {words[:60]!r}",
        "use left, right, front, back, centre, or x z in metres as in '0 -2'",
    )
