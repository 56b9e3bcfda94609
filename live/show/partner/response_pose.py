"""Poses of answering dancers: the answer replaces the dancer's pose, with foot lock and hand holds."""

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.partner_live.hand_holds import Held, hands_of
from live.motion.partner_live.stage_partner import Standing
from live.motion.partner_live.stage_partner_kernels import show_answers
from live.motion.skeleton import SKELETON
from live.show.partner.leader_input import AnswerLeaders, See, frames_since
from live.show.partner.partner_pairs import Asked, Pair
from live.show.partner.response_path import TakenAlong

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

WHOLE: Final = 0.98
"""Weight of the answer above which its standing feet are locked."""


class AnswerPoses:
    """Poses of the answers to `leaders`, placed by the root motion `along`. Thread: the show's."""

    def __init__(self, leaders: AnswerLeaders, along: TakenAlong) -> None:
        self._leaders, self._along = leaders, along
        self.standing = Standing(len(along.level))
        """Foot lock of the answering dancers."""
        self._offsets = np.array(SKELETON.offsets, np.float32)
        self._parents = np.array(SKELETON.parents, np.int32)

    def tick(self, acting: Sequence[Pair], see: See, dt: float) -> None:
        """Advance foot lock by `dt` [s], for followers of the `acting` pairs whose answer is fully faded in."""
        along = self._along
        whole = [pair for pair in acting if along.share[pair.follower] > WHOLE and along.carried[pair.follower]]
        if not whole and not self.standing.lock.farthest:
            return
        rows = np.array([pair.follower for pair in whole], np.int32)
        if not whole:
            self.standing.tick(rows, np.zeros((0, len(self._parents), 3), np.float32), np.zeros((0, 2), np.bool_), dt)
            return
        contact = np.stack([self._leaders.of(pair).contact for pair in whole])
        self.standing.tick(rows, see(rows)[0], contact, dt)

    def stand(self, position: Float32, rotation: Float32, age: float) -> None:
        """Apply foot lock in world poses (A, J, 3) and (A, J, 4), `age` [s] after the last tick."""
        self.standing.hold(np.flatnonzero(self._along.share > 0.0).astype(np.int32), position, rotation, age)

    def show(
        self, acting: Sequence[Pair], danced: Float64, position: Float32, rotation: Float32, rows: Int32 | None
    ) -> None:
        """Blend the answers of the `acting` pairs into world poses `position` (A, J, 3) and `rotation` (A, J, 4),
        with dancers at the danced beats `danced` (A,); with `rows` (n,) only of these dancers, (n, J, 3) and (n, J,
        4)."""
        along = self._along
        shown = [pair for pair in acting if along.share[pair.follower] > 0.0]
        where = None if rows is None else {int(row): n for n, row in enumerate(rows)}
        if where is not None:
            shown = [pair for pair in shown if pair.follower in where]
        if not shown:
            return
        reads = [self._leaders.of(pair) for pair in shown]
        follow = np.array([pair.follower for pair in shown], np.int32)
        who = follow if where is None else np.array([where[int(row)] for row in follow], np.int32)
        frames = [frames_since(read, float(danced[pair.leader])) for pair, read in zip(shown, reads, strict=True)]
        show_answers(
            position, rotation, who, np.arange(len(shown), dtype=np.int32), np.array(frames), along.share[follow],
            along.turn[follow],
            np.ascontiguousarray(along.place[follow]), np.ascontiguousarray(along.answered[follow]),
            np.stack([read.root for read in reads]), np.stack([read.turned for read in reads]),
            self._offsets, self._parents,
        )  # fmt: skip


def holds_of(
    pairs: Iterable[Pair],
    asked: Sequence[Asked],
    leaders: AnswerLeaders,
    share: npt.NDArray[np.float64],
) -> list[Held]:
    """Return the hands to hold in the shown `pairs`, whose answers have weight `share` (A,).

    A dancer at an own place, or led by a path, stands elsewhere than the examples' follower and holds no hands.
    """
    return [
        Held(pair.leader, pair.follower, hands_of(leaders.of(pair).partner), asked[pair.partner].hands)
        for pair in pairs
        if share[pair.follower] > 0.0 and not pair.own_place
    ]
