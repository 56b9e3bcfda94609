"""SupportTurns: rotation insertion (T048-T050) in closed form, at any fraction of a measure and for any angle.

On the stage plane a point is the complex number z + i x, so that turning by `yaw` is multiplying by exp(i yaw). While
a foot carries, the turn is about its ball; what was turned before has moved that ball along, so the motion that turns
a clip's point p into exp(i angle share) p + D is a sum over the supports, each with an integral that has a closed form.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

MAX_SEGMENTS: Final = 8
"""Segments kept for each measure; of more supports the longest are."""


@dataclass(frozen=True, slots=True, eq=False)
class SupportTurns:
    """Where in a measure a dancer may turn and about which point; every array has shape (..., 8).

    Leading axes are measures or dancers. Unused segments come last and have start = stop = 1 and weight 0; a measure
    in which nothing may turn does not exist (see `support_turns`), so the weights of each measure sum to 1.
    """

    start: Float64
    """Fraction of the measure at which the segment begins, in [0, 1]."""
    stop: Float64
    """Fraction at which it ends; segments are in order and do not overlap."""
    weight: Float64
    """Share of the whole angle that is turned in the segment."""
    point: Float64
    """Where the ball of the carrying foot stands when the segment begins, x and z [m] in the clip's own axes;
    shape (..., 8, 2)."""
    point_stop: Float64
    """Where it stands when the segment ends, likewise: recorded feet creep, and roll from heel to toe."""
    softness: Float64
    """Share of the segment over which the turn speeds up, and again slows down: 0 (uniform, T049) to 0.5."""

    def take(self, rows: npt.NDArray[np.integer]) -> "SupportTurns":
        """The rows of the first axis that `rows` (A,) names: from the nodes of a library to the dancers."""
        return SupportTurns(*(getattr(self, name)[rows] for name in self.__slots__))

    def rows(self) -> Float64:
        """One row for each segment, (..., 8, 8): start, stop, weight, x, z at its start and at its stop, softness."""
        single = (self.start, self.stop, self.weight, self.softness)
        start, stop, weight, softness = (array[..., None] for array in single)
        return np.concatenate((start, stop, weight, self.point, self.point_stop, softness), axis=-1)

    @property
    def quickest(self) -> Float64:
        """How fast it turns at most, in whole angles a measure, (...): a turn in one short support is a snap."""
        span = np.maximum(self.stop - self.start, 1e-12)
        return np.asarray(np.max(self.weight / span / (1.0 - self.softness), axis=-1))

    def share(self, fraction: npt.ArrayLike) -> Float64:
        """Share of the angle that is turned when `fraction` (...) of the measure has passed: 0 to 1, never falling."""
        return np.asarray(np.sum(self.weight * self._progress(fraction), axis=-1))

    def displacement(self, fraction: npt.ArrayLike, angle: npt.ArrayLike) -> Float64:
        """What is added to the turned clip so that the carrying foot holds: x, z [m] in the clip's own axes, (..., 2).

        With yaw = `angle` · share(`fraction`) a point of the clip goes to turned(point, yaw) + displacement, and the
        body's heading grows by yaw. For a clip that is placed on the stage with a yaw of its own, turn the
        displacement by that yaw and add yaw to both the path's and the body's. `fraction` and `angle` [rad]
        broadcast against the leading axes.
        """
        progress = self._progress(fraction)
        whole = np.asarray(angle, np.float64)[..., None] * self.weight
        before = np.cumsum(whole * progress, axis=-1) - whole * progress  # turned in earlier segments; all of it
        turn = whole * progress
        start = self.point[..., 1] + 1j * self.point[..., 0]
        way = self.point_stop[..., 1] + 1j * self.point_stop[..., 0] - start
        mean = np.exp(0.5j * turn) * np.sinc(turn / (2.0 * np.pi))  # of exp(i φ) for φ from 0 to turn
        moved = start - np.exp(1j * turn) * (start + way * progress) + way * progress * mean
        total = np.sum(np.exp(1j * before) * moved, axis=-1)
        return np.stack((total.imag, total.real), axis=-1)

    def _progress(self, fraction: npt.ArrayLike) -> Float64:
        """How far the turn of each segment is, 0 to 1, shape (..., 8)."""
        span = np.maximum(self.stop - self.start, 1e-12)
        passed = np.clip((np.asarray(fraction, np.float64)[..., None] - self.start) / span, 0.0, 1.0)
        return soft_progress(passed, self.softness)


def soft_progress(passed: npt.ArrayLike, softness: npt.ArrayLike) -> Float64:
    """From 0 to 1 as `passed` goes from 0 to 1: linear for softness 0, else with the speed rising and falling linearly.

    `softness` is the share of the way that each of the two takes, at most 0.5.
    """
    passed, softness = np.broadcast_arrays(np.asarray(passed, np.float64), np.asarray(softness, np.float64))
    safe = np.maximum(softness, 1e-9)
    edge = np.minimum(np.minimum(passed, 1.0 - passed), safe)  # distance from the nearer end, while in its ramp
    ramp = 0.5 * edge * edge / safe
    inner = np.clip(passed, safe, 1.0 - safe)
    risen = (inner - safe + np.where(passed < 0.5, ramp, safe - ramp)) / (1.0 - safe)
    return np.asarray(np.where(softness > 1e-9, risen, passed))


def stack_turns(turns: Sequence[SupportTurns]) -> SupportTurns:
    """N measures in one, arrays of shape (N, 8): what a library holds, one row for each node."""
    return SupportTurns(*(np.stack([getattr(one, name) for one in turns]) for name in SupportTurns.__slots__))
