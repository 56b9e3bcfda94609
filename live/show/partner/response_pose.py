"""Poses of answering dancers: the answer replaces the dancer's pose, with foot lock and hand holds."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32
from live.motion.partner_live.hand_holds import HoldRequest
from live.motion.partner_live.stage_partner import FollowerFootLock
from live.motion.partner_live.stage_partner_kernels import blend_answers
from live.motion.skeleton import SKELETON
from live.show.partner.leader_input import LeaderReaders, PoseSource, frames_since
from live.show.partner.partner_pairs import Pair, PartnerSettings

if TYPE_CHECKING:
    from live.show.partner.response_path import ResponsePath


LOCK_WEIGHT: Final = 0.98
"""Weight of the answer above which its standing feet are locked."""


class ResponsePoses:
    """Poses of the answers to `leaders`, placed by the root motion `path`. Thread: the show's."""

    def __init__(self, leaders: LeaderReaders, path: "ResponsePath") -> None:
        self._leaders, self._path = leaders, path
        self.foot_lock = FollowerFootLock(len(path.level))
        """Foot lock of the answering dancers."""
        self._offsets = np.array(SKELETON.offsets, np.float32)
        self._parents = np.array(SKELETON.parents, np.int32)

    def tick(self, pairs: Sequence[Pair], poses_of: PoseSource, dt: float) -> None:
        """Advance foot lock by `dt` [s], for followers of the `pairs` whose answer is fully faded in."""
        along = self._path
        whole = [pair for pair in pairs if along.weight[pair.follower] > LOCK_WEIGHT and along.answering[pair.follower]]
        if not whole and not self.foot_lock.lock.max_shift:
            return
        rows = np.array([pair.follower for pair in whole], np.int32)
        if not whole:
            self.foot_lock.tick(rows, np.zeros((0, len(self._parents), 3), np.float32), np.zeros((0, 2), np.bool_), dt)
            return
        contact = np.stack([self._leaders.reader(pair).contact for pair in whole])
        self.foot_lock.tick(rows, poses_of(rows)[0], contact, dt)

    def lock_feet(self, position: Float32, rotation: Float32, age: float) -> None:
        """Apply foot lock in world poses (A, J, 3) and (A, J, 4), `age` [s] after the last tick."""
        self.foot_lock.apply(np.flatnonzero(self._path.weight > 0.0).astype(np.int32), position, rotation, age)

    def blend_poses(
        self, pairs: Sequence[Pair], danced_beats: Float64, position: Float32, rotation: Float32, rows: Int32 | None
    ) -> None:
        """Blend the answers of the `pairs` into world poses `position` (A, J, 3) and `rotation` (A, J, 4),
        with dancers at the danced beats `danced_beats` (A,); with `rows` (n,) only of these dancers, (n, J, 3) and
        (n, J, 4)."""
        along = self._path
        shown = [pair for pair in pairs if along.weight[pair.follower] > 0.0]
        where = None if rows is None else {int(row): n for n, row in enumerate(rows)}
        if where is not None:
            shown = [pair for pair in shown if pair.follower in where]
        if not shown:
            return
        reads = [self._leaders.reader(pair) for pair in shown]
        follow = np.array([pair.follower for pair in shown], np.int32)
        who = follow if where is None else np.array([where[int(row)] for row in follow], np.int32)
        frames = [frames_since(read, float(danced_beats[pair.leader])) for pair, read in zip(shown, reads, strict=True)]
        blend_answers(
            position, rotation, who, np.arange(len(shown), dtype=np.int32), np.array(frames), along.weight[follow],
            along.turn[follow],
            np.ascontiguousarray(along.last_position[follow]), np.ascontiguousarray(along.answer_position[follow]),
            np.stack([read.root for read in reads]), np.stack([read.answer_rotation for read in reads]),
            self._offsets, self._parents,
        )  # fmt: skip


def active_holds(
    pairs: Iterable[Pair],
    settings: Sequence[PartnerSettings],
    leaders: LeaderReaders,
    weight: npt.NDArray[np.float64],
) -> list[HoldRequest]:
    """Return the hands to hold in the shown `pairs`, whose answers have weight `weight` (A,).

    A dancer at an own place, or led by a path, stands elsewhere than the examples' follower and holds no hands.
    """
    return [
        HoldRequest(pair.leader, pair.follower, leaders.reader(pair).partner.hands, settings[pair.partner].hands)
        for pair in pairs
        if weight[pair.follower] > 0.0 and not pair.own_place
    ]
