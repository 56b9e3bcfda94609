"""Guides: what the show intends for each dancer, as strokes for the operator's picture (why she goes where she goes).

On the floor at the dancer's feet: a cross where her agent is, and a line to it; a ring where she is to stand when the
measure ends (the predicted agent), joined to her by a line, from green to red by how far her measure will really end
from there; under each foot a square while it is held.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import GUIDE_CAPACITY, StageView
from live.motion.pose.foot_lock_kernels import HELD
from live.motion.skeleton import SKELETON
from live.show.show import Show

Float32 = npt.NDArray[np.float32]

RING: Final = 10
"""Strokes of a ring."""
RING_M: Final = 0.16
CROSS_M: Final = 0.10
FOOT_M: Final = 0.07
RED_M: Final = 0.25
"""A measure that ends so far from where it should [m] is drawn red."""
OVER_FLOOR: Final = 0.012
AGENT: Final = (0.35, 0.75, 1.0, 0.9)
STANDS: Final = (1.0, 0.95, 0.3, 0.9)
FEET: Final = (SKELETON.index("leftFoot"), SKELETON.index("rightFoot"))


def draw_guides(show: Show, view: StageView) -> None:
    """Write the strokes of all dancers on the stage into the view, as many as it holds."""
    there = np.flatnonzero(view.present)
    hips = view.joint_position[there, 0][:, (0, 2)].astype(np.float64)
    agent = show.state.position[there].astype(np.float64)
    count = _strokes(view, 0, hips, agent, AGENT)
    for way in ((CROSS_M, 0.0), (0.0, CROSS_M)):
        count = _strokes(view, count, agent - way, agent + way, AGENT)
    held = (show.dancers.lock.state[there, :, HELD] > 0.0).T
    for side, joint in enumerate(FEET):
        foot = view.joint_position[there[held[side]], joint][:, (0, 2)].astype(np.float64)
        count = _outline(view, count, foot, FOOT_M, 4, STANDS)
    target = show.scheduler.last_target
    if target is None:
        view.guide_count = count
        return
    aim = target[there]
    danced = show.dancers.coming if show.dancers.decided else show.dancers.present
    off = np.clip(np.hypot(*(aim - danced.end_position()[there]).T) / RED_M, 0.0, 1.0)
    colour = np.column_stack([0.25 + 0.75 * off, 0.9 - 0.7 * off, np.full(len(off), 0.25), np.full(len(off), 0.9)])
    count = _strokes(view, count, hips, aim, colour)
    view.guide_count = _outline(view, count, aim, RING_M, RING, colour)


def _outline(
    view: StageView, count: int, middle: npt.NDArray[np.float64], radius: float, corners: int, colour: npt.ArrayLike
) -> int:
    """A regular polygon about each of `middle` (n, 2) [m]."""
    angle = np.linspace(0.0, 2.0 * np.pi, corners + 1) + np.pi / 4.0
    around = radius * np.column_stack([np.sin(angle), np.cos(angle)])
    for k in range(corners):
        count = _strokes(view, count, middle + around[k], middle + around[k + 1], colour)
    return count


def _strokes(
    view: StageView, count: int, begin: npt.NDArray[np.float64], end: npt.NDArray[np.float64], colour: npt.ArrayLike
) -> int:
    """Strokes on the floor from `begin` (n, 2) to `end` (n, 2) [m], after `count`; returns how many there are."""
    most = min(len(begin), GUIDE_CAPACITY - count)
    rows = view.guide[count : count + most]
    rows[:, (0, 2)], rows[:, (3, 5)] = begin[:most], end[:most]
    rows[:, (1, 4)] = OVER_FLOOR
    rows[:, 6:] = np.broadcast_to(np.asarray(colour, np.float32), (len(begin), 4))[:most]
    return count + most
