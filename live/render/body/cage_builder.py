"""Builder of cages: closed meshes of polygons with skin weights, from rings of corners, a half and its mirror image."""

from dataclasses import dataclass

import numpy as np

from live.base.arrays import Float64, Int64
from live.render.body.drawn_joints import DRAWN_COUNT, DRAWN_MIRROR, DRAWN_NAMES

Point = tuple[float, float, float]
JointWeights = dict[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Cage:
    """A closed mesh of polygons, counter-clockwise seen from outside (V corners, F faces, J drawn joints)."""

    points: Float64
    """Corners [m], shape (V, 3)."""
    weights: Float64
    """Skin weights of each corner, rows sum to 1, shape (V, J)."""
    faces: Int64
    """Corner indices, shape (F, N); a face with fewer corners ends with -1."""


class HalfBuilder:
    """Builder of the left half; rings are lists of corners, ordered around the direction of extrusion."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.weights: list[Float64] = []
        self.faces: list[tuple[int, ...]] = []

    def ring(self, points: list[Point], weights: JointWeights | list[JointWeights]) -> list[int]:
        bonds = weights if isinstance(weights, list) else [weights] * len(points)
        first = len(self.points)
        self.points += points
        self.weights += [weights_of(one) for one in bonds]
        return list(range(first, first + len(points)))

    def bridge(self, a: list[int], b: list[int], skip: tuple[int, ...] = (), *, open_: bool = False) -> None:
        """Faces between two rings; `open_` leaves the seam at x = 0, `skip` leaves holes for a limb."""
        count = len(a)
        for i in range(count - 1 if open_ else count):
            if i not in skip:
                j = (i + 1) % count
                self.faces.append((a[i], a[j], b[j], b[i]))

    def cap(self, ring: list[int]) -> None:
        self.faces.append(tuple(ring))


def weights_of(bond: JointWeights) -> Float64:
    row = np.zeros(DRAWN_COUNT)
    for name, weight in bond.items():
        row[DRAWN_NAMES.index(name)] = weight
    return np.asarray(row / row.sum())


def mirrored(half: HalfBuilder) -> Cage:
    """Return the half and its mirror image in the plane x = 0, whose corners both share."""
    points = np.array(half.points)
    weights = np.array(half.weights)
    most = max(map(len, half.faces))
    faces = np.array([(*face, *(-1,) * (most - len(face))) for face in half.faces], np.int64)
    # reversed, and turned so that a face and its mirror image start at the same corner
    reverse = np.array([(face[0], *face[:0:-1], *(-1,) * (most - len(face))) for face in half.faces], np.int64)
    middle = points[:, 0] == 0.0
    other = np.arange(len(points))
    other[~middle] = len(points) + np.arange(int((~middle).sum()))
    swapped = weights[:, list(DRAWN_MIRROR)]
    weights[middle] = 0.5 * (weights[middle] + swapped[middle])
    reflected = points[~middle] * np.array([-1.0, 1.0, 1.0])
    return Cage(
        np.concatenate([points, reflected]),
        np.concatenate([weights, swapped[~middle]]),
        np.concatenate([faces, np.where(reverse < 0, -1, other[reverse])]),
    )
