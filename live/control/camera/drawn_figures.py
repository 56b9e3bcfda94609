"""Virtual dancers that a camera sees on the screen: what was drawn is not taken for people.

The show tells where it drew whom. A figure whose landmarks lie where a drawn dancer's joints lie, in the camera's
picture of the screen, is that dancer. A real person before the screen moves otherwise, or stands elsewhere.
"""

from collections import deque
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.control.camera.pose_models import ModelPose

KEPT_S: Final = 0.5
"""For this long [s] drawn figures are remembered: projector and camera delay what is seen."""
_SAME: Final = 0.1
"""Mean distance of joints, over the figure's height, below which a figure is the drawn one."""
COMPARED: Final = (11, 12, 13, 14, 15, 16, 23, 24, 25, 26, 27, 28)
"""Landmarks of shoulders, elbows, wrists, hips, knees, ankles: those of `camera_plan.DRAWN_JOINTS`."""


class DrawnFigures:
    """Figures on the screen as one camera sees them. Thread: one."""

    def __init__(self, screen: Float64) -> None:
        """`screen` (4, 2): the projected picture's upper left, upper right, lower right and lower left corner in the
        camera's picture (fractions)."""
        self._matrix = square_to_quad(screen)
        self._drawn: deque[tuple[float, Float64]] = deque()

    def draw(self, time: float, joints: Float64) -> None:
        """Remember figures drawn at `time` [s]: `joints` (D, 12, 2), fractions of the projected picture."""
        flat = joints.reshape(-1, 2)
        homogeneous = np.column_stack((flat, np.ones(len(flat)))) @ self._matrix.T
        seen = homogeneous[:, :2] / homogeneous[:, 2:]
        self._drawn.append((time, seen.reshape(joints.shape)))
        while self._drawn and self._drawn[0][0] < time - KEPT_S:
            self._drawn.popleft()

    def shows(self, pose: ModelPose, width: int, height: int) -> bool:
        """Whether a pose in a picture of this size [pixels] is that of a drawn figure."""
        scale = np.array((width, height), np.float64)
        seen = pose.picture[list(COMPARED)]
        tall = max(float(np.ptp(pose.picture[:, 1])), 8.0)
        for _, figures in self._drawn:
            if len(figures):
                there = figures * scale
                # a figure seen from behind has left and right exchanged
                for order in (there, there.reshape(-1, 6, 2, 2)[:, :, ::-1].reshape(there.shape)):
                    if float(np.linalg.norm(order - seen, axis=2).mean(axis=1).min()) < _SAME * tall:
                        return True
        return False


def square_to_quad(corners: Float64) -> Float64:
    """Return the homography (3, 3) from the unit square, y down, to a quadrilateral with the `corners` (4, 2): upper
    left, upper right, lower right, lower left; ValueError if they are no convex shape."""
    square = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    rows = []
    for (x, y), (u, v) in zip(square, corners, strict=True):
        rows.append((x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y))
        rows.append((0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y))
    edges = np.roll(corners, -1, axis=0) - corners
    following = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
    if not (turns > 1e-6).all():
        raise ValueError(
            "the corners are no convex shape in the order upper left, upper right, lower right, lower left"
        )
    found = np.linalg.solve(np.array(rows), np.asarray(corners, np.float64).reshape(-1))
    return np.append(found, 1.0).reshape(3, 3)
