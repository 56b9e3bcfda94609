"""Feet: how they slide while they are in contact, and how often they skate.

Contact is never found in the motion that is judged: it is what the source clips say, carried through blends, so that a
foot that floats or flies is not excused.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.editing.feet import ANKLES, BALLS
from live.motion.foot_contact import TOES_OVER_SOLE

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

SKATING_RATE: Final = 20.0
SKATING_HEIGHT: Final = 0.05
SKATING_SPEED: Final = 0.5
"""Frames per second, metres and m/s of the skating ratio (GMD)."""
SKATING_FRAMES: Final = 5
"""Frames over which the speed is averaged besides."""


def slide_speeds(position: Float, rate: float) -> Float64:
    """Speed over the floor [m/s] of each foot, of heel and ball the stiller, (T - 1, ..., 2) from (T, ..., J, 3)."""
    feet = np.stack((position[..., ANKLES, :], position[..., BALLS, :]), axis=-2).astype(np.float64)
    moved = np.diff(feet, axis=0)[..., (0, 2)]
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]).min(axis=-1) * rate, np.float64)


def slides(position: Float, contact: Bool, rate: float) -> Float64:
    """Those speeds between samples in which the foot is in contact, (n,); `contact` is (T, ..., 2)."""
    return np.asarray(slide_speeds(position, rate)[contact[1:] & contact[:-1]], np.float64)


def skates(position: Float, rate: float) -> Bool:
    """Frames at 20 a second in which a ball skates, (F, ...) from joints (T, ..., J, 3); see `skating_balls`."""
    count = int((len(position) - 1) * SKATING_RATE / rate + 1e-6) + 1
    at = np.minimum(np.arange(count) * rate / SKATING_RATE, len(position) - 1.0)
    low = at.astype(np.int64)
    part = (at - low).reshape(-1, *(1,) * (position.ndim - 1))
    balls = position[..., BALLS, :].astype(np.float64)
    return skating_balls((1.0 - part) * balls[low] + part * balls[np.minimum(low + 1, len(balls) - 1)])


def skating_balls(balls: Float) -> Bool:
    """Whether a ball skates, (F - 1, ...) from the balls of both feet at 20 frames a second, (F, ..., 2, 3) [m].

    Lower than 5 cm over its place on the floor in two adjacent frames, and faster than 0.5 m/s now and in the mean of
    five frames; either foot.
    """
    if len(balls) < 2:
        return np.zeros((0, *balls.shape[1:-2]), np.bool_)
    moved = np.diff(balls, axis=0)
    speed = np.hypot(moved[..., 0], moved[..., 2]) * SKATING_RATE
    on_floor = balls[..., 1] - TOES_OVER_SOLE < SKATING_HEIGHT
    reach = SKATING_FRAMES // 2
    padded = np.pad(speed, ((reach, reach), *((0, 0),) * (speed.ndim - 1)))
    mean = np.lib.stride_tricks.sliding_window_view(padded, SKATING_FRAMES, axis=0).mean(axis=-1)
    found = on_floor[1:] & on_floor[:-1] & (speed > SKATING_SPEED) & (mean > SKATING_SPEED)
    return np.asarray(found.any(axis=-1), np.bool_)
