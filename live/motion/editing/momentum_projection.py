"""Projection of changed angles of the upper body so that a body keeps its momentum at every moment.

Kept are the centre of mass and the angular momentum about it: the null space of the centroidal momentum (Orin, Goswami
and Lee 2013, "Centroidal dynamics of a humanoid robot"). The correction is the smallest smooth one, by Gauss-Newton
steps with the Jacobian of the step itself. All variations of a step share one factorised band matrix: moments are
coupled to their neighbours only, and the circle of moments is folded (0, T - 1, 1, T - 2 ...) to stay banded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.editing.band_kernels import factor_band, solve_band
from live.motion.editing.body_mass import CENTRE_LEVER, MOMENT_MATRIX, angular_momentum, rotation_row
from live.motion.editing.upper_body_angles import COLUMNS, HEAVY_ANGLES, TURNED_BY, UpperBodyAngles
from live.motion.skeleton import SKELETON

STEPS: Final = 4
"""Gauss-Newton steps; each leaves about a fifth of the deviation."""
TOLERANCES: Final = (1e-5, 1e-4)
"""Deviations of the centre of mass [m] and of the angular momentum per mass [m²/s] that cost as much as one spread."""
STEADY_HZ: Final = 2.0
"""Corrections quicker than this cost more than steady ones, by the fourth power of their frequency."""


@dataclass(frozen=True, slots=True, eq=False)
class MomentumProjection:
    """Corrects periodic angles of the upper body so that a body keeps its momentum."""

    body: UpperBodyAngles
    """T + 1 poses; the last has the angles of the first."""
    rate: float
    """Poses a second."""
    centre: Float64
    """Centre of mass relative to the hips [m], shape (T + 1, 3)."""
    momentum: Float64
    """Angular momentum about it per mass, between poses [m²/s], shape (T, 3)."""
    jacobian: "_Jacobian"
    factor: Float64
    """Of the normal matrix, as `factor_band` makes it."""

    @classmethod
    def of(cls, body: UpperBodyAngles, rate: float) -> "MomentumProjection":
        """Return the projection of `body`, `rate` poses a second."""
        row = rotation_row(body.matrix)
        jacobian = _Jacobian.of(body, row, rate)
        band = _banded(jacobian.normal_blocks(rate))
        factor_band(band)
        return cls(body, rate, row @ CENTRE_LEVER, angular_momentum(row, rate), jacobian, band)

    def project(self, angles: Float64) -> tuple[Float64, Float64, Float64]:
        """Return `angles` (n, T, D) corrected, and the largest strays that are left: of the centre [m], and of the
        momentum as a share of its range, (n,) each.

        Only heavy angles are corrected, the H first. Of all iterates each variation gets the nearest: where arms hang
        straight, whatever moves them raises the centre, and no small correction takes that back wholly.
        """
        order = _folded_order(angles.shape[1])
        best, least = angles, np.full(len(angles), np.inf)
        strays = np.zeros((2, len(angles)))
        reach = max(float(np.ptp(self.momentum, axis=0).max()), TOLERANCES[1])
        for step in range(STEPS + 1):
            row = rotation_row(self.body.turned(np.concatenate([angles, angles[:, :1]], axis=1)))
            centre, momentum = row @ CENTRE_LEVER - self.centre, angular_momentum(row, self.rate) - self.momentum
            size = ((centre / TOLERANCES[0]) ** 2).sum(axis=(1, 2)) + ((momentum / TOLERANCES[1]) ** 2).sum(axis=(1, 2))
            now = np.linalg.norm(centre, axis=-1).max(axis=1), np.abs(momentum).max(axis=(1, 2)) / reach
            best = np.where((size < least)[:, None, None], angles, best)
            strays = np.where(size < least, now, strays)
            least = np.minimum(size, least)
            if step < STEPS:
                slope = self.jacobian.slope(centre, momentum)[:, order]
                change = np.ascontiguousarray(slope.reshape(len(angles), -1))
                solve_band(self.factor, change)
                angles = angles.copy()
                angles[:, order, :HEAVY_ANGLES] -= change.reshape(slope.shape)
        return best, strays[0], strays[1]


@dataclass(frozen=True, slots=True, eq=False)
class _Jacobian:
    """Derivatives of centre of mass and angular momentum by the angles, in tolerances."""

    centre: Float64
    """Of the centre at each of T + 1 poses by the angles there, (T + 1, 3, H)."""
    before: Float64
    """Of the momentum between a pose and the next by the angles of the first, (T, 3, H) ..."""
    after: Float64
    """... and of the second."""

    @classmethod
    def of(cls, body: UpperBodyAngles, row: Float64, rate: float) -> "_Jacobian":
        """Return the derivatives at the poses of `body`, with rotations `row` (T + 1, 3, 3J)."""
        joints, count = SKELETON.joint_count, len(row)
        matrix = body.matrix
        levers = (matrix @ CENTRE_LEVER.reshape(joints, 3, 1))[..., 0]
        ahead = matrix[:-1] @ (MOMENT_MATRIX @ row[1:].swapaxes(1, 2)).reshape(-1, joints, 3, 3)
        back = (row[:-1] @ MOMENT_MATRIX).reshape(-1, 3, joints, 3).swapaxes(1, 2) @ matrix[1:].swapaxes(2, 3)
        found = cls(*(np.empty((size, 3, HEAVY_ANGLES)) for size in (count, count - 1, count - 1)))
        for joint, turned in TURNED_BY.items():
            axes, own = body.world_axes(joint), COLUMNS[joint]
            found.centre[..., own] = np.cross(axes, levers[:, turned].sum(axis=1)[..., None], axis=1)
            # the axial vector of [a] M is (M - tr M) a, that of -P [a] is (tr P - Pᵀ) a
            one, other = ahead[:, turned].sum(axis=1), back[:, turned].sum(axis=1)
            found.before[..., own] = (one - _trace(one)) @ axes[:-1]
            found.after[..., own] = (_trace(other) - other.swapaxes(1, 2)) @ axes[1:]
        return cls(
            found.centre / TOLERANCES[0],
            found.before * (rate / TOLERANCES[1]),
            found.after * (rate / TOLERANCES[1]),
        )

    def slope(self, centre: Float64, momentum: Float64) -> Float64:
        """Return half the gradient of the squared deviations `centre` (n, T + 1, 3) [m] and `momentum` (n, T, 3)
        [m²/s] by the angles, (n, T, H)."""
        by_centre = _applied(self.centre, centre / TOLERANCES[0])
        momentum = momentum / TOLERANCES[1]
        found = by_centre[:, :-1] + _applied(self.before, momentum)
        found += np.roll(_applied(self.after, momentum), 1, axis=1)
        found[:, 0] += by_centre[:, -1]
        return found

    def normal_blocks(self, rate: float) -> tuple[Float64, Float64, Float64]:
        """Return the blocks (T, H, H) of the normal matrix: of each moment, with the next, and with the one after it.

        Besides the deviations, the size of a change counts, and its second differences.
        """
        stiff = (rate / (2.0 * np.pi * STEADY_HZ)) ** 4
        by_centre = self.centre.swapaxes(1, 2) @ self.centre
        own = by_centre[:-1] + self.before.swapaxes(1, 2) @ self.before
        own += np.roll(self.after.swapaxes(1, 2) @ self.after, 1, axis=0)
        own[0] += by_centre[-1]
        own += (1.0 + 6.0 * stiff) * np.eye(HEAVY_ANGLES)
        following = self.before.swapaxes(1, 2) @ self.after - 4.0 * stiff * np.eye(HEAVY_ANGLES)
        return own, following, np.broadcast_to(stiff * np.eye(HEAVY_ANGLES), own.shape)


def _applied(jacobian: Float64, deviation: Float64) -> Float64:
    """Return Jᵀ d for J (T, 3, H) and d (n, T, 3), (n, T, H)."""
    return np.asarray((deviation[..., None, :] @ jacobian)[..., 0, :])


def _trace(matrix: Float64) -> Float64:
    """Return the trace of matrices (T, 3, 3) times the unit matrix."""
    return np.asarray(np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(3))


def _folded_order(count: int) -> Int64:
    """Return the moments of a circle in an order in which neighbours are near: 0, T - 1, 1, T - 2 and so on."""
    order = np.arange(count) // 2
    order[1::2] = count - 1 - order[1::2]
    return order


def _banded(blocks: Sequence[Float64]) -> Float64:
    """Return a symmetric matrix of blocks (T, H, H), with the moments folded, in the form of `factor_band`."""
    count = len(blocks[0])
    band = np.zeros((count * HEAVY_ANGLES, 5 * HEAVY_ANGLES))
    for place, values in zip(_band_places(count), blocks, strict=True):
        band.reshape(-1)[place] = values  # of a block on the diagonal both halves, which are equal
    return band


@cache
def _band_places(count: int) -> tuple[Int64, ...]:
    """Return the places in the flat band of blocks (T, H, H): of each moment, with the next, with the one after it."""
    moment, angle = np.arange(count), np.arange(HEAVY_ANGLES)
    begin = np.argsort(_folded_order(count)) * HEAVY_ANGLES
    places = []
    for apart in range(3):
        row = begin[moment][:, None, None] + angle[:, None]
        column = begin[(moment + apart) % count][:, None, None] + angle
        low, high = np.minimum(row, column), np.maximum(row, column)
        places.append(low * (5 * HEAVY_ANGLES) + high - low)
    return tuple(places)
