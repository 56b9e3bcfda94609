"""Arm clearance: nobody's arms pass through the own trunk, or through another's arms and trunk; applied to poses."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64
from live.base.row_ranges import Part, run_rows
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.pose.arm_clearance_kernels import ease_arms, find_arms, look_ahead
from live.motion.pose.body_capsules import ARM_CHAINS, TRUNK_JOINTS
from live.motion.pose.hand_hold import HeldArms
from live.motion.pose.neighbour_clearance_kernels import draw_back_arms, find_pairs
from live.motion.pose.pose_pipeline import RANGE
from live.motion.pose.sample_kernels import BLOCK
from live.motion.pose.trunk_clearance_kernels import move_arms

NOBODY_HELD: Final = HeldArms(0)
"""No dancer's arm is in a hold."""
EASING_S: Final = 0.03
"""Time constant [s] of each of the three low-pass filters through which arms keep off others in a show: an arm that
another one meets at 5 m/s gives way within 0.1 s, its elbow is not thrown, and poses are still struck on the beat."""
PUSH_EASING_S: Final = 0.012
"""The same for arms that are pushed out of the own trunk, which nobody sees ahead."""
LEAD_S: Final = 0.06
"""Arms keep off where others will be after this time [s], if joints go on as they went since the last frame, ..."""
MOST_LEAD: Final = np.float32(0.3)
"""... by at most this [m] along each axis."""
MAX_EASING_GAP: Final = 0.25
"""After a longer gap between two frames [s] arms are at once where they should be."""
NO_FILTERS: Final = np.zeros((0, 0, 0, 2, 3), np.float32)
NOTHING_KEPT: Final = np.zeros(2, np.float32)
NO_PUSHES: Final = np.zeros((0, 0, 2, 3), np.float32)
"""Arguments of the kernels without easing."""


class ArmEasing:
    """How arms have kept off other dancers in the frames of a show so far. Frames, not ticks, advance it: it belongs to
    the pictures of a show, not to its state."""

    def __init__(self) -> None:
        self._filters = NO_FILTERS
        self._last = self._way = self._ahead = np.zeros((0, 0, 3), np.float32)
        self._kept: Float32 = np.zeros(2, np.float32)
        self.active: Bool = np.zeros((0, 2), np.bool_)
        """Arms whose filters may be other than 0, (A, 2)."""
        self._time = -math.inf

    def advance(
        self, position: Float32, time: float, ranges: Sequence[tuple[int, int]]
    ) -> tuple[Float32, Float32, Float32]:
        """Return where the joints of the dancers in `ranges` go from `position` (A, J, 3) [m], the filters, and how
        much of them stays (2,), 0 to 1.

        Everything of them stays at a frame at a `time` [s] that is not later than the last one.
        """
        passed, self._time = time - self._time, time
        if len(self._last) != len(position):
            self._filters = np.zeros((2, 3, 2 * len(position), 2, 3), np.float32)
            self.active = np.zeros((len(position), 2), np.bool_)
            self._last, self._way, self._ahead = (np.zeros_like(position) for _ in range(3))
            passed = math.inf
        if passed > MAX_EASING_GAP:
            self._way[:] = 0.0
        later = 0.0 < passed <= MAX_EASING_GAP
        per = LEAD_S / passed if later else 0.0

        def part(begin: int, end: int) -> None:
            look_ahead(
                position, self._last, self._way, self._ahead, per, later, MOST_LEAD, TRUNK_JOINTS, ARM_CHAINS,
                begin, end,
            )  # fmt: skip

        _run(part, ranges, least=8 * RANGE)
        for k, constant in enumerate((EASING_S, PUSH_EASING_S)):
            self._kept[k] = 0.0 if passed > MAX_EASING_GAP else math.exp(-max(passed, 0.0) / constant)
        return self._ahead, self._filters, self._kept


def apply_arm_clearance(
    position: Float32, rotation: Float32, share: Float64, *, held: HeldArms | None = None, visible: Bool | None = None,
    detail: Float64 | None = None, easing: ArmEasing | None = None, time: float = 0.0,
) -> None:  # fmt: skip
    """Move arms in poses (A, J, 3) [m] and (A, J, 4), in place, by the share `share` (A,) of what is needed.

    Arms in a hold are not moved, and the arms of a couple may touch; without `held` nobody holds hands. Dancers who are
    not `visible` (A,) are in nobody's way; without it all are visible. With `detail` (A,), 0 to 1, the arms of dancers
    who are small in the picture move less, and those at 0 cost nothing. Without `easing` there is no state: the same
    poses give the same; with it arms that others come near to at `time` [s] give way softly.
    """
    held = NOBODY_HELD if held is None else held
    visible = np.ones(len(position), np.bool_) if visible is None else visible
    count = len(position)
    ranges = [(0, count)]
    if detail is not None and detail.min(initial=1.0) < 1.0:
        share, visible = share * detail, visible & (detail > 0.0)
        ranges = _block_ranges(detail > 0.0)
    ahead, filters, kept = position, NO_FILTERS, NOTHING_KEPT
    if easing is not None:
        ahead, filters, kept = easing.advance(position, time, ranges)
    both = np.repeat(share, 2).reshape(count, 2)
    amount: Float32 = (both * (np.float32(1.0) - held.share) if len(held.share) else both).astype(np.float32)
    if not (amount > 0.0).any():
        return
    box, drawn = np.empty((4, count), np.float32), np.empty((2 * count, 2, 3), np.float32)
    near, moves = np.zeros((2, count, 2), np.bool_)
    active = np.ones((count, 2), np.bool_) if easing is None else easing.active

    def find(begin: int, end: int) -> None:
        find_arms(position, ahead, rotation, box, near, amount, TRUNK_JOINTS, ARM_CHAINS, begin, end)

    def ease(begin: int, end: int) -> None:
        ease_arms(drawn, filters, kept, held.share, near, active, moves, begin, end)

    _run(find, ranges, least=2 * RANGE, block=BLOCK)
    pairs = find_pairs(box, visible)
    each_arm: Float32 = amount.reshape(-1)
    draw_back_arms(
        ahead, rotation, drawn, pairs, each_arm, held.share, held.partner, held.together, TRUNK_JOINTS, ARM_CHAINS
    )
    _run(ease, ranges, least=8 * RANGE)
    which, pushes = np.flatnonzero(moves).astype(np.int32), filters[1] if len(filters) else NO_PUSHES

    def move(begin: int, end: int) -> None:
        move_arms(
            position,
            rotation,
            drawn,
            each_arm,
            which[begin:end],
            end - begin,
            pushes,
            kept[1],
            TRUNK_JOINTS,
            ARM_CHAINS,
        )

    run_rows(move, len(which), least=RANGE, block=BLOCK)


def _block_ranges(rows: Bool) -> list[tuple[int, int]]:
    """Return ranges in which the marked `rows` (A,) lie: of whole multiples of RANGE, each costs some microseconds."""
    blocks = np.add.reduceat(rows, np.arange(0, len(rows), RANGE)) > 0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], blocks, [False]]).astype(np.int8)))
    return [(RANGE * begin, min(RANGE * end, len(rows))) for begin, end in edges.reshape(-1, 2).tolist()]


def _run(part: Part, ranges: Sequence[tuple[int, int]], *, least: int, block: int = 1) -> None:
    """Call `part` for the rows of all ranges, as `run_rows` does."""
    for begin, end in ranges:
        if begin:
            run_rows(partial(_shifted, part, begin), end - begin, least=least, block=block)
        else:
            run_rows(part, end, least=least, block=block)


def _shifted(part: Part, first: int, begin: int, end: int) -> None:
    part(first + begin, first + end)


def clear_own_trunk(clip: Clip) -> Clip:
    """Return the clip with the arms pushed out of the own trunk, as in the live show; other joints are unchanged."""
    position, rotation = forward_kinematics(clip.root_position, clip.rotation)
    world = np.ascontiguousarray(position, np.float32), np.ascontiguousarray(rotation, np.float32)
    before = world[1].copy()
    samples = clip.sample_count
    apply_arm_clearance(*world, np.ones(samples), visible=np.zeros(samples, np.bool_))
    moved = (world[1] != before).any(axis=(1, 2))
    mended = clip.rotation.copy()
    mended[moved] = local_rotations(world[1][moved])
    return replace(clip, rotation=np.ascontiguousarray(quaternion.align_signs(mended), np.float32))
