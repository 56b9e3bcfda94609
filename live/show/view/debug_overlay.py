"""Debug overlay for the operator: strokes on the floor that show each dancer's agent and target.

A cross marks the agent, with a line from the dancer. A ring marks the target at the end of the measure (the predicted
agent), with a line from the dancer; its colour goes from green to red with the distance at which the measure will
actually end. A square under a foot means that it is locked.
"""

from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import GUIDE_CAPACITY, StageView
from live.motion.pose.foot_lock_kernels import HELD
from live.motion.skeleton import SKELETON

if TYPE_CHECKING:
    from live.show.show import Show


RING: Final = 10
"""Number of strokes of a ring."""
RING_M: Final = 0.16
CROSS_M: Final = 0.10
FOOT_M: Final = 0.07
RED_M: Final = 0.25
"""Distance from the target at which a measure is drawn red [m]."""
OVER_FLOOR: Final = 0.012
AGENT_COLOUR: Final = (0.35, 0.75, 1.0, 0.9)
LOCKED_COLOUR: Final = (1.0, 0.95, 0.3, 0.9)
FEET: Final = (SKELETON.index("leftFoot"), SKELETON.index("rightFoot"))


def draw_guides(show: "Show", view: StageView) -> None:
    """Write the strokes of all dancers on the stage into the view, up to its capacity."""
    there = np.flatnonzero(view.present)
    hips = view.joint_position[there, 0][:, (0, 2)].astype(np.float64)
    agent = show.state.position[there].astype(np.float64)
    count = _strokes(view, 0, hips, agent, AGENT_COLOUR)
    for way in ((CROSS_M, 0.0), (0.0, CROSS_M)):
        count = _strokes(view, count, agent - way, agent + way, AGENT_COLOUR)
    held = (show.dancers.lock.state[there, :, HELD] > 0.0).T
    for side, joint in enumerate(FEET):
        foot = view.joint_position[there[held[side]], joint][:, (0, 2)].astype(np.float64)
        count = _outline(view, count, foot, FOOT_M, 4, LOCKED_COLOUR)
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
    """Add a regular polygon around each of `middle` (n, 2) [m]; return the new number of strokes."""
    angle = np.linspace(0.0, 2.0 * np.pi, corners + 1) + np.pi / 4.0
    around = radius * np.column_stack([np.sin(angle), np.cos(angle)])
    for k in range(corners):
        count = _strokes(view, count, middle + around[k], middle + around[k + 1], colour)
    return count


def _strokes(
    view: StageView, count: int, begin: npt.NDArray[np.float64], end: npt.NDArray[np.float64], colour: npt.ArrayLike
) -> int:
    """Add strokes on the floor from `begin` (n, 2) to `end` (n, 2) [m] after `count`; return the new number."""
    most = min(len(begin), GUIDE_CAPACITY - count)
    rows = view.guide[count : count + most]
    rows[:, (0, 2)], rows[:, (3, 5)] = begin[:most], end[:most]
    rows[:, (1, 4)] = OVER_FLOOR
    rows[:, 6:] = np.broadcast_to(np.asarray(colour, np.float32), (len(begin), 4))[:most]
    return count + most
