"""Where a camera stands: its focal length and its pose against the stage floor, found from marks on the floor.

A pinhole camera without lens distortion whose axis meets the middle of the picture. Its axes are x to the picture's
right, y down, z away from the camera.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.errors import PersonError

ASSUMED_FIELD_OF_VIEW: Final = np.radians(66.0)
"""Field of view [rad] over the longer side of the picture of a camera that nobody calibrated: between laptops' cameras
(60 to 70 degrees) and phones' main cameras (65 to 70)."""
ASSUMED_DISTANCE: Final = 3.5
"""Distance [m] from the stage's centre, towards the audience, of a camera that nobody calibrated."""
ASSUMED_HEIGHT: Final = 1.2
"""Its height over the floor [m]."""
MAX_MISS: Final = 0.01
"""Largest distance of a mark's place in the picture from where the solved camera sees it, in heights of the picture."""
_FOCAL_PRIOR: Final = 0.5
"""Standard deviation of the logarithm of the focal length about the assumed one, for marks that hardly tell it."""
_CLICK_ERROR: Final = 0.002
"""Standard deviation of a click, in heights of the picture (2 pixels of 1080)."""
_FLAT: Final = 0.02
"""Three marks are on a line if their triangle's area is less than this share of the squared extent of all marks."""
_LEAST_EYE: Final = 0.05
"""A camera must be at least this high over the floor [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraView:
    """A camera's focal length and pose on the stage."""

    focal: float
    """Focal length in heights of the picture: 0.5 / tan(half the vertical field of view)."""
    aspect: float
    """Width of the picture over its height."""
    rotation: Float64
    """Matrix (3, 3) that turns directions from stage axes to the camera's."""
    position: Float64
    """The camera's place on the stage (3,) [m]; y is its height over the floor."""
    calibrated: bool
    """Whether the pose was measured; otherwise it is assumed, and the floor's height is estimated from the feet."""

    def rays(self, picture: npt.ArrayLike) -> Float64:
        """Return directions (n, 3) in the camera's axes, z = 1, of places (n, 2) in the picture (fractions)."""
        place = np.asarray(picture, np.float64)
        rays = np.ones((len(place), 3))
        rays[:, 0] = (place[:, 0] - 0.5) * (self.aspect / self.focal)
        rays[:, 1] = (place[:, 1] - 0.5) / self.focal
        return rays

    def to_stage(self, points: Float64) -> Float64:
        """Return points (n, 3) [m] in stage axes of points in the camera's axes, from the camera."""
        return points @ self.rotation + self.position

    def to_camera(self, points: npt.ArrayLike) -> Float64:
        """Return points (n, 3) [m] in the camera's axes of points in stage axes."""
        return np.asarray((np.asarray(points, np.float64) - self.position) @ self.rotation.T)

    def project(self, points: npt.ArrayLike) -> Float64:
        """Return the places (n, 2) in the picture of `points` (n, 3) [m] of the stage; NaN for those behind it."""
        seen = self.to_camera(points)
        depth = np.where(seen[:, 2] > 1e-6, seen[:, 2], np.nan)
        place = seen[:, :2] / depth[:, None] * self.focal
        return np.asarray(place / (self.aspect, 1.0) + 0.5)

    def on_floor(self, picture: npt.ArrayLike, height: float = 0.0) -> Float64:
        """Return where the rays of places (n, 2) in the picture meet the plane at `height` [m], (n, 3) in stage axes.

        Rays that do not go down to it give NaN.
        """
        rays = self.rays(picture) @ self.rotation
        down = np.where(rays[:, 1] < -1e-6, rays[:, 1], np.nan)
        away = (height - self.position[1]) / down
        return np.asarray(self.position + np.where(away > 0.0, away, np.nan)[:, None] * rays)


def assumed_focal(aspect: float) -> float:
    """Return the focal length, in heights of the picture, of a camera with the assumed field of view."""
    return float(0.5 * max(aspect, 1.0) / np.tan(0.5 * ASSUMED_FIELD_OF_VIEW))


def assumed_view(aspect: float) -> CameraView:
    """Return a level camera in the audience that looks at the stage's centre, for one that nobody calibrated."""
    if not 0.1 < aspect < 10.0:
        raise ValueError(f"a picture's width over its height is {aspect}, between 0.1 and 10 expected")
    axes = np.diag((1.0, -1.0, -1.0))
    return CameraView(assumed_focal(aspect), aspect, axes, np.array((0.0, ASSUMED_HEIGHT, ASSUMED_DISTANCE)), False)


def calibrate(stage: npt.ArrayLike, picture: npt.ArrayLike, aspect: float) -> CameraView:
    """Return the camera that sees marks on the floor at `stage` (n, 2) (x, z) [m] at `picture` (n, 2) (fractions).

    Four marks or more, the corners of a convex shape in order. The homography of the floor gives the focal length and
    the pose (Zhang 2000, "A flexible new technique for camera calibration": two constraints on the focal length from
    one plane), least squares over the errors in the picture refine them. Marks that do not tell the focal length (a
    camera that looks straight down) leave the assumed one. Raises PersonError where the marks give no camera.
    """
    floor, places = np.asarray(stage, np.float64), np.asarray(picture, np.float64)
    _check_marks(floor, places)
    centred = (places - 0.5) * (aspect, 1.0)
    guess = assumed_focal(aspect)
    found = _homography(floor, centred)
    tried = [_solve(floor, centred, start, found, guess) for start in (_focal_of(found), guess, 2.0 * guess)]
    _, view = min(tried, key=lambda each: each[0])
    view = CameraView(view.focal, aspect, view.rotation, view.position, True)
    three = np.column_stack((floor[:, 0], np.zeros(len(floor)), floor[:, 1]))
    if view.position[1] < _LEAST_EYE or not (view.to_camera(three)[:, 2] > 0.0).all():
        raise PersonError(
            "the marks would put the camera under the floor or in front of them",
            "click them in the same order as their positions are listed, and check x and z",
        )
    miss = np.linalg.norm((view.project(three) - places) * (aspect, 1.0), axis=1)
    if miss.max() > MAX_MISS:
        raise PersonError(
            f"the marks do not fit together: mark {int(miss.argmax()) + 1} is off by {100.0 * miss.max():.1f} % of the "
            f"picture's height, {100.0 * MAX_MISS:.0f} % allowed",
            "measure the marks' positions on the stage again, and click where they touch the floor",
        )
    return view


def _check_marks(floor: Float64, places: Float64) -> None:
    """Raise PersonError unless the marks are the corners of a convex shape, in the same order in both."""
    if floor.ndim != 2 or floor.shape[1:] != (2,) or floor.shape != places.shape or len(floor) < 4:
        raise PersonError(
            f"{len(floor)} positions on the stage and {len(places)} places in the picture, at least four of each with "
            "two numbers expected",
            "mark the corners of a rectangle on the floor",
        )
    if not (np.isfinite(floor).all() and np.isfinite(places).all()):
        raise PersonError("a mark's position is not a finite number", "give x and z in metres")
    if np.abs(floor).max() > 1000.0 or np.abs(places - 0.5).max() > 2.0:
        raise PersonError("a mark is over 1000 m from the stage's centre, or far out of the picture", "check the marks")
    if check_shape(floor, "on the stage") != check_shape(places, "in the picture"):
        raise PersonError(
            "the marks run clockwise in one list and anticlockwise in the other",
            "click them in the same order as their positions are listed; +x is the audience's right, +z towards it",
        )


def check_shape(points: Float64, where: str) -> bool:
    """Return whether marks at `points` (n, 2) turn from the first axis to the second one.

    PersonError, which says `where`, unless they are the corners of a convex shape, one after the other.
    """
    size = float(np.ptp(points, axis=0).max()) ** 2
    count = len(points)
    for i in range(count):
        for j in range(i + 1, count):
            for k in range(j + 1, count):
                if abs(_area(points[i], points[j], points[k])) <= _FLAT * size:
                    raise PersonError(
                        f"the marks {i + 1}, {j + 1} and {k + 1} are on a line {where}",
                        "mark the corners of a rectangle that is as large as the dance floor",
                    )
    corners = [_area(points[n], points[(n + 1) % count], points[(n + 2) % count]) for n in range(count)]
    if min(corners) < 0.0 < max(corners):
        raise PersonError(
            f"the marks are not the corners of a convex shape {where}, one after the other",
            "list and click them in the order in which one walks around them",
        )
    return corners[0] > 0.0


def _area(a: Float64, b: Float64, c: Float64) -> float:
    """Return the signed area of a triangle in the plane."""
    return float(0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])))


def _homography(floor: Float64, centred: Float64) -> Float64:
    """Return the matrix (3, 3) that takes (x, z, 1) to places in the picture, by the direct linear transform."""
    middle, size = floor.mean(axis=0), float(np.abs(floor - floor.mean(axis=0)).max())
    x, z = ((floor - middle) / size).T
    u, v = centred.T
    one, none = np.ones_like(x), np.zeros_like(x)
    rows = np.concatenate(
        (
            np.stack((x, z, one, none, none, none, -u * x, -u * z, -u), axis=1),
            np.stack((none, none, none, x, z, one, -v * x, -v * z, -v), axis=1),
        )
    )
    matrix = np.linalg.svd(rows)[2][-1].reshape(3, 3)
    scaling = np.array(((1.0 / size, 0.0, -middle[0] / size), (0.0, 1.0 / size, -middle[1] / size), (0.0, 0.0, 1.0)))
    matrix = matrix @ scaling
    ahead = matrix[2] @ np.append(middle, 1.0)
    return np.asarray(matrix * np.sign(ahead) if ahead != 0.0 else matrix)


def _focal_of(matrix: Float64) -> float:
    """Return the focal length for which the homography's axes are orthogonal and of one length; 1 where none is."""
    first, second = matrix[:, 0], matrix[:, 1]
    flat = np.array((first[:2] @ second[:2], first[:2] @ first[:2] - second[:2] @ second[:2]))
    deep = np.array((first[2] * second[2], first[2] ** 2 - second[2] ** 2))
    inverse_square = -(flat @ deep) / max(float(flat @ flat), 1e-18)
    return float(np.clip(1.0 / np.sqrt(inverse_square), 0.2, 10.0)) if inverse_square > 1e-4 else 1.0


def _solve(floor: Float64, centred: Float64, focal: float, matrix: Float64, guess: float) -> tuple[float, CameraView]:
    """Return the cost and the camera that least squares find from the homography and a `focal` length to start at."""
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    columns = matrix / np.array((focal, focal, 1.0))[:, None]
    columns = columns / np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    x, z = columns[:, 0], columns[:, 1]
    left, _, right = np.linalg.svd(np.stack((x, np.cross(z, x), z), axis=1))
    turned = left @ np.diag((1.0, 1.0, np.linalg.det(left @ right))) @ right
    start = np.concatenate(([np.log(focal)], Rotation.from_matrix(turned).as_rotvec(), columns[:, 2]))
    points = np.column_stack((floor[:, 0], np.zeros(len(floor)), floor[:, 1]))

    def residuals(values: Float64) -> Float64:
        seen = Rotation.from_rotvec(values[1:4]).apply(points) + values[4:7]
        place = np.exp(np.clip(values[0], -3.0, 4.0)) * seen[:, :2] / np.maximum(seen[:, 2:], 1e-3)
        return np.append((place - centred).ravel() / _CLICK_ERROR, (values[0] - np.log(guess)) / _FOCAL_PRIOR)

    found = least_squares(residuals, start, x_scale=np.array((0.1, 0.1, 0.1, 0.1, 1.0, 1.0, 1.0)), max_nfev=200)
    rotation = Rotation.from_rotvec(found.x[1:4]).as_matrix()
    focal = float(np.exp(np.clip(found.x[0], -3.0, 4.0)))
    return float(found.cost), CameraView(focal, 1.0, rotation, np.asarray(-rotation.T @ found.x[4:7]), True)
