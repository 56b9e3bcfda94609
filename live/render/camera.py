"""Camera matrices, the part of the picture that is drawn, and the projection of pixels onto the stage floor.

Matrices are float64 (4, 4) for column vectors: `clip = world_to_clip(...) @ (x, y, z, 1)`; right-handed world, OpenGL
clip space (x right, y up, -w <= z <= w).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.stage_snapshot import Camera

NEAR: Final = 0.1
"""Nearest distance drawn [m]."""
FAR: Final = 120.0
"""Farthest distance drawn [m]."""

Size = tuple[int, int]


@dataclass(frozen=True, slots=True)
class PicturePart:
    """A rectangle of the whole picture, drawn pixel by pixel as in the whole one: an off-centre part of its frustum."""

    whole: tuple[float, float]
    """Width and height of the whole picture [pixels]; it may be larger than any texture."""
    left: float
    bottom: float
    """Lower left corner of the part in the whole picture [pixels]."""
    size: Size
    """Width and height of the part [pixels]."""

    @staticmethod
    def of(size: "Size | PicturePart") -> "PicturePart":
        """Return a whole picture of this size, or the part as it is."""
        return size if isinstance(size, PicturePart) else PicturePart(size, 0, 0, size)

    @property
    def is_whole(self) -> bool:
        """Whether it is the whole picture."""
        return self.whole == self.size

    @property
    def share(self) -> tuple[float, float]:
        """Width and height as shares of the whole picture's."""
        return self.size[0] / self.whole[0], self.size[1] / self.whole[1]

    @property
    def corner(self) -> tuple[float, float]:
        """Its upper left corner in the whole picture, as shares of that, y down: as in an output's crop."""
        return self.left / self.whole[0], 1.0 - (self.bottom + self.size[1]) / self.whole[1]

    def scaled(self, size: Size) -> "PicturePart":
        """Return the same part of a larger or smaller picture, so that it has this size [pixels]."""
        x, y = size[0] / self.size[0], size[1] / self.size[1]
        whole = size if self.is_whole else (self.whole[0] * x, self.whole[1] * y)
        return PicturePart(whole, self.left * x, self.bottom * y, size)

    def clip_matrix(self) -> Float64:
        """Return the matrix (4, 4) from the clip space of the whole picture to that of the part."""
        matrix = np.eye(4)
        for axis, start in enumerate((self.left, self.bottom)):
            matrix[axis, axis] = self.whole[axis] / self.size[axis]
            matrix[axis, 3] = (self.whole[axis] - 2.0 * start) / self.size[axis] - 1.0
        return matrix


def view_matrix(camera: Camera) -> Float64:
    """Return the matrix from world to eye axes (x right, y up, looking along -z).

    A camera that looks straight up or down keeps the stage's depth (-z) as its up direction. Raises ValueError if
    eye and target are the same point.
    """
    eye, target = np.array(camera.eye, np.float64), np.array(camera.target, np.float64)
    forward = target - eye
    length = float(np.linalg.norm(forward))
    if length < 1e-6:
        raise ValueError(f"camera: eye and target are the same point {camera.eye}; move one of them")
    forward /= length
    up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.9999 else np.array([0.0, 0.0, -1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    if camera.roll_deg:
        cos, sin = np.cos(np.deg2rad(camera.roll_deg)), np.sin(np.deg2rad(camera.roll_deg))
        right, up = cos * right - sin * up, cos * up + sin * right
    matrix = np.eye(4)
    matrix[0, :3], matrix[1, :3], matrix[2, :3] = right, up, -forward
    matrix[:3, 3] = -matrix[:3, :3] @ eye
    return matrix


def projection(camera: Camera, aspect: float) -> Float64:
    """Return the perspective matrix for a picture with `aspect` = width / height; the field of view is vertical.

    With a lens shift the frustum is not symmetric (Hartley and Zisserman 2004, 6.1: the principal point).
    Raises ValueError if the field of view is not between 1 and 170 degrees or the aspect is not positive.
    """
    if not 1.0 <= camera.field_of_view_deg <= 170.0:
        raise ValueError(f"camera: field_of_view_deg {camera.field_of_view_deg}: 1 to 170 degrees")
    if not aspect > 0.0:
        raise ValueError(f"camera: aspect {aspect}: must be positive")
    scale = 1.0 / np.tan(0.5 * np.deg2rad(camera.field_of_view_deg))
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[0, 1] = scale * camera.stretch / aspect, scale * camera.skew / aspect
    matrix[1, 1] = scale
    matrix[0, 2], matrix[1, 2] = (
        2.0 * camera.shift[0],
        2.0 * camera.shift[1],
    )  # eye z is negative in front of the camera
    matrix[2, 2] = -(FAR + NEAR) / (FAR - NEAR)
    matrix[2, 3] = -2.0 * FAR * NEAR / (FAR - NEAR)
    matrix[3, 2] = -1.0
    return matrix


def view_rays(camera: Camera, size: Size | PicturePart) -> tuple[Float64, Float64, Float64]:
    """Return the ray from the eye through the lower left corner of a picture of `size` pixels or of a part, and the
    differences to its right and upper edges; each (3,), scaled to a depth of one metre.

    The point at depth d [m] and (u, v) of 0..1 in the picture is eye + d (corner + u right + v up).
    """
    part = PicturePart.of(size)
    frame = part.clip_matrix() @ projection(camera, part.whole[0] / part.whole[1])
    back = np.linalg.inv(np.array([frame[0, :3], frame[1, :3], [0.0, 0.0, -1.0]]))
    corner, right, up = (back @ np.array(at) for at in ((-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (-1.0, 1.0, 1.0)))
    axes = view_matrix(camera)[:3, :3].T
    return axes @ corner, axes @ (right - corner), axes @ (up - corner)


def world_to_clip(camera: Camera, size: Size | PicturePart) -> Float64:
    """Return the matrix from world to clip space for a picture of `size` (width, height) pixels, or for a part."""
    part = PicturePart.of(size)
    return part.clip_matrix() @ (projection(camera, part.whole[0] / part.whole[1]) @ view_matrix(camera))


def pixels_per_metre(camera: Camera, size: Size | PicturePart) -> float:
    """Return how many pixels high a metre is at a distance of one metre along the camera's axis."""
    whole = PicturePart.of(size).whole
    upwards = projection(camera, whole[0] / whole[1]) @ view_matrix(camera)
    return float(np.linalg.norm(upwards[1, :3])) * 0.5 * whole[1]


def project_points(camera: Camera, size: tuple[int, int], points: npt.ArrayLike) -> Float64:
    """Return the pixels (N, 2) of world points (N, 3) [m] in front of the camera: x right, y down, from upper left."""
    world = np.atleast_2d(np.asarray(points, np.float64))
    clip = np.concatenate([world, np.ones((len(world), 1))], axis=1) @ world_to_clip(camera, size).T
    device = clip[:, :2] / clip[:, 3:4]
    return np.stack([(device[:, 0] + 1.0) * 0.5 * size[0], (1.0 - device[:, 1]) * 0.5 * size[1]], axis=1)


_CORNERS: Final = np.indices((2, 2, 2)).reshape(3, 8).T.astype(np.bool_)


def screen_bounds(matrix: Float64, size: tuple[int, int], low: Float64, high: Float64) -> tuple[int, int, int, int]:
    """Return the pixels (x, y, width, height; y up) that a box from `low` to `high` [m] may cover; all if too near."""
    clip = np.where(_CORNERS, high, low) @ matrix[:, :3].T + matrix[:, 3]
    if clip[:, 3].min() < NEAR:
        return 0, 0, size[0], size[1]
    device = clip[:, :2] / clip[:, 3:4]
    start = np.clip(np.floor((device.min(axis=0) + 1.0) * 0.5 * size), 0, size).astype(int)
    stop = np.clip(np.ceil((device.max(axis=0) + 1.0) * 0.5 * size), 0, size).astype(int)
    return int(start[0]), int(start[1]), int(stop[0] - start[0]), int(stop[1] - start[1])


def floor_point(camera: Camera, size: tuple[int, int], pixel_xy: tuple[float, float]) -> tuple[float, float] | None:
    """Return the point (x, z) [m] of the stage floor under a pixel (y down), or None where no floor is visible."""
    device = np.array([2.0 * pixel_xy[0] / size[0] - 1.0, 1.0 - 2.0 * pixel_xy[1] / size[1]])
    back = np.linalg.inv(world_to_clip(camera, size))
    near = back @ np.array([device[0], device[1], -1.0, 1.0])
    far = back @ np.array([device[0], device[1], 1.0, 1.0])
    start, stop = near[:3] / near[3], far[:3] / far[3]
    fall = stop[1] - start[1]
    if abs(fall) < 1e-12:
        return None
    part = -start[1] / fall
    if not 0.0 <= part <= 1.0:
        return None
    point = start + part * (stop - start)
    return float(point[0]), float(point[2])
