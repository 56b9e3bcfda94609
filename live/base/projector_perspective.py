"""Projector calibration: the camera for a projector's position and the floor corners in its picture.

Four points of a plane and their images define a homography (eight numbers). With the position of the eye it defines
the whole projection but its scale: for floor points (x, z) it is M [e_x | e_z | -eye], so M = H [e_x | e_z | -eye]^-1,
and M is the lens times the rotation, split by RQ (Hartley and Zisserman 2004, 4.1 and 6.2.4). The corners are met
exactly, with any keystone correction in between; what lens shift cannot explain becomes `stretch` and `skew`, which
are 1 and 0 where position and corners agree.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.base.floor_corners import check_corners, floor_corners
from live.base.stage_snapshot import Camera

FIELD_OF_VIEW_RANGE: Final = (5.0, 120.0)
"""Vertical angles of view that a camera can have [degrees]."""


def homography(begin: Float64, end: Float64) -> Float64:
    """Return the matrix (3, 3) that maps four points (x, y) to four others: `(x, y, 1)` to a multiple of `(u, v, 1)`.

    numpy.linalg.LinAlgError if three of the points lie on a line.
    """
    rows = []
    for (x, y), (u, v) in zip(begin, end, strict=True):
        rows.append([x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y])
        rows.append([0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y])
    return np.append(np.linalg.solve(np.array(rows), end.reshape(-1)), 1.0).reshape(3, 3)


def camera_from_corners(
    at: Sequence[float], corners: Sequence[Sequence[float]], stage: tuple[float, float], aspect: float
) -> Camera:
    """Return the camera at `at` (x, y, z) [m] whose picture has the floor's corners at `corners`.

    `corners` (4, 2): u to the right, v down, 0..1, in the order of `floor_corners.CORNERS`; `stage`: width, depth [m];
    `aspect`: the picture's width / height. PersonError for impossible input: corners that cross, an eye on the floor,
    or an eye from which no picture looks so.
    """
    check_corners(corners)
    eye = np.asarray(at, np.float64)
    if abs(eye[1]) < 1e-3:
        raise PersonError("the projector lies on the floor: from there it is a line", "its height is the second number")
    floor = floor_corners(*stage)
    device = np.asarray(corners, np.float64) * (2.0, -2.0) + (-1.0, 1.0)
    plane = np.array([[1.0, 0.0, -eye[0]], [0.0, 0.0, -eye[1]], [0.0, 1.0, -eye[2]]])
    whole = homography(floor, device) @ np.linalg.inv(plane)
    return _decompose(whole, eye, floor, aspect)


def _decompose(whole: Float64, eye: Float64, floor: Float64, aspect: float) -> Camera:
    """Split a projection without its position, (3, 3), into a camera's numbers."""
    ways = np.stack([floor[:, 0] - eye[0], np.full(4, -eye[1]), floor[:, 1] - eye[2]], axis=1)
    whole = whole / np.linalg.norm(whole[2])
    depth = ways @ whole[2]
    if depth.mean() < 0.0:
        whole, depth = -whole, -depth
    if depth.min() <= 0.0:
        raise PersonError("no projector there can see the floor so: a corner would lie behind it", "measure `at` again")
    forward = whole[2]
    across, high = whole[0] @ forward, whole[1] @ forward
    up = whole[1] - high * forward
    scale = float(np.linalg.norm(up))
    up /= scale
    skew = float(whole[0] @ up)
    right = whole[0] - across * forward - skew * up
    wide = float(np.linalg.norm(right))
    if np.linalg.det(whole) > 0.0:
        raise PersonError("no projector there can see the floor so: only a mirrored one", "measure `at` again")
    angle = float(np.rad2deg(2.0 * np.arctan(1.0 / scale)))
    if not FIELD_OF_VIEW_RANGE[0] <= angle <= FIELD_OF_VIEW_RANGE[1]:
        raise PersonError(
            f"from there the picture would have an angle of view of {angle:.1f} degrees; allowed are "
            f"{FIELD_OF_VIEW_RANGE[0]:g} to {FIELD_OF_VIEW_RANGE[1]:g}", "measure `at` and the corners again",
        )  # fmt: skip
    reach = float(depth.mean())
    level = np.cross(forward, (0.0, 1.0, 0.0) if abs(forward[1]) < 0.9999 else (0.0, 0.0, -1.0))
    level /= np.linalg.norm(level)
    right /= wide
    roll = float(np.rad2deg(np.arctan2(-right @ np.cross(level, forward), right @ level)))
    target = eye + reach * forward
    shift = (-0.5 * float(across), -0.5 * float(high))
    place = (float(eye[0]), float(eye[1]), float(eye[2]))
    return Camera(
        place, (float(target[0]), float(target[1]), float(target[2])), angle, roll, shift,
        stretch=wide * aspect / scale, skew=skew * aspect / scale,
    )  # fmt: skip
