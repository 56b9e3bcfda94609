"""Live partner response: dancers answer their leaders as the followers of recorded examples did (H024).

A leader's pose is read several times per beat and matched (`live/motion/partner_live`). The follower shows the answer
instead of the own steps, which continue unseen. The answer fades in and out over one measure. All decisions are made in
ticks; drawing only reads them.
"""

import contextlib
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.motion.partner_live.hand_holds import Holding
from live.motion.partner_live.stage_partner import ReadLeader
from live.show.dancers.variation import Variation
from live.show.group.casting import Casting
from live.show.partner.leader_input import AnswerLeaders, See, Tracks
from live.show.partner.partner_pairs import Asked, Pair, asked_of, check_pairs, in_order, pairs_of
from live.show.partner.partner_sources import AnswerBank
from live.show.partner.response_path import TakenAlong
from live.show.partner.response_pose import AnswerPoses, holds_of
from live.show.patch.patch import Patch
from live.show.selection.drawn_paths import DrawnWay

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

HOLD: Final = 0.25
"""Time [s] without motion after which a captured leader counts as stopped; until then followers hold their pose."""
STANDS: Final = 2.0
"""Beats without motion after which a leader who dances steps counts as stopped."""


class Answering:
    """The partners of one show with A dancers. Thread: the show's."""

    def __init__(self, patch: Patch, casting: Casting, variation: Variation, bank: AnswerBank | None) -> None:
        """Without a bank no dancer answers. Invalid partners were reported before (`check_partners`)."""
        count = len(casting.group)
        self.bank = bank or AnswerBank(())
        self._casting, self._variation = casting, variation
        self._beats = patch.clock.beats_per_measure
        self.asked: list[Asked] = asked_of(patch) if self.bank.lores else []
        self.pairs: list[Pair] = []
        self.leaders = AnswerLeaders(self.bank)
        """Readers of the leaders."""
        self.along = TakenAlong(count)
        """Fade and root motion of the followers."""
        self.live: Bool = np.zeros(count, np.bool_)
        """Dancers moved by a live stream, (A,): such a leader has stopped after HOLD."""
        self._poses = AnswerPoses(self.leaders, self.along)
        self.holding = Holding(count)
        """Hand holds between followers and leaders."""
        self._ways: dict[int, DrawnWay] = {}
        self._agents: Float32 = np.zeros((count, 2), np.float32)
        self._danced: Float64 = np.zeros(count)
        self._written, self._roster = list(self.asked), casting.roster
        self._leaving: list[Pair] = []
        self.ask(self.asked)

    def take_patch(self, fresh: "Answering") -> None:
        """Adopt the partner tables of an edited patch; live settings stay for unchanged tables.

        The example bank is fixed at the start (`edit.fitted` ensures that).
        """
        for index, (old, new) in enumerate(zip(self._written, fresh._written, strict=True)):
            if old != new:
                self.asked[index] = new
        self._written = fresh._written
        self.settle()

    # -- pairs ---------------------------------------------------------------------------------------------------

    def ask(self, asked: list[Asked]) -> None:
        """Apply these settings; on PersonError nothing changes."""
        pairs = in_order(pairs_of(asked, self._casting))
        check_pairs(asked, pairs)
        self.asked = asked
        self._take(pairs)

    def settle(self) -> None:
        """Form the pairs again after groups changed; on an error the old pairs stay."""
        if self.asked:
            with contextlib.suppress(PersonError):
                self.ask(self.asked)

    def find(self, name: str) -> list[int]:
        """Return the indices of the partners with this name; "" and "*" are all. Raises PersonError for none."""
        if name.strip() in ("", "*") and self.asked:
            return list(range(len(self.asked)))
        found = [n for n, one in enumerate(self.asked) if one.name.casefold() == name.casefold().strip()]
        if not found:
            known = ", ".join(one.name for one in self.asked) or "none: write [[partner]]"
            raise PersonError(f"no partner is called {name!r}", f"there are: {known}")
        return found

    def change(self, name: str, key: str, value: object) -> None:
        """Set one key of `Asked` for the partners called `name`; raises PersonError if the result is invalid."""
        asked = list(self.asked)
        for index in self.find(name):
            if key == "window":
                value = min(float(str(value)), self.bank.lores[index].stretch)
            asked[index] = replace(asked[index], **{key: value})  # type: ignore[arg-type]
        self.ask(asked)

    def walk_on(self, name: str, point: tuple[float, float], *, anew: bool) -> None:
        """Extend the drawn path of the path-led partners called `name` to `point` [m]; PersonError for none."""
        meant = [index for index in self.find(name) if self.asked[index].by_path]
        if not meant:
            raise PersonError(f"partner {name!r} is led by dancers, not by a way", 'leader = "path" in the patch')
        for index in meant:
            rows = [pair.follower for pair in self.pairs if pair.partner == index]
            way = self._ways.get(index)
            if way is None or anew or way.rows != rows:
                way = self._ways[index] = DrawnWay(rows, self._agents)
            way.add(point)

    def _take(self, pairs: list[Pair]) -> None:
        """Read the leaders of these pairs; a follower with another leader fades out of the old answer first."""
        old = (*self._leaving, *self.pairs)
        self._leaving = [pair for pair in old if pair not in pairs and self.along.level[pair.follower] > 0.0]
        self.leaders.take(pairs, self._leaving)
        self.pairs = pairs

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self) -> None:
        """Begin a measure: update the pairs if groups have changed."""
        if self._casting.roster is not self._roster:
            self._roster = self._casting.roster
            self.settle()

    def danced(self, phase: Float64) -> Float64:
        """Return the danced beat of each dancer at `phase` (A,) of the present measure."""
        return np.asarray((self._variation.measure + phase) * self._beats)

    def tick(
        self, phase: Float64, hips: Float32, faces: Float32, there: Bool, tracks: Tracks, see: See, dt: float
    ) -> None:
        """Advance by one tick of `dt` [s]: read the leaders and move the followers.

        Dancers are at `phase` (A,) of the measure with their `hips` (A, 2) [m] and hip rotation `faces` (A, 4); `there`
        (A,): present on the stage. `tracks`: positions (A, 2) [m] and velocities (A, 2) [m/s] of their agents. `see`
        returns the present poses of some dancers.
        """
        if not self.asked:
            return
        danced = self.danced(phase)
        passed = np.clip(danced - self._danced, 0.0, 1.0)
        self._danced[:] = danced
        self.leaders.look(self.asked, danced, there, tracks, see)
        self.along.begin_tick()
        self._agents[:] = tracks[0]
        self._let_go()
        for pair in self._acting():
            one, read = self.asked[pair.partner], self.leaders.of(pair)
            self.along.go(
                pair, one, read, wanted=pair in self.pairs and self._wanted(pair, one, read, there),
                danced=danced[pair.leader], measures=float(passed[pair.follower]) / self._beats,
                hips=hips, agents=self._agents, dt=dt,
            )  # fmt: skip
            self.along.face(pair.follower, faces[pair.follower], read.turned[0, 0])
        self._leaving = [pair for pair in self._leaving if self.along.level[pair.follower] > 0.0]
        self._poses.tick(self._acting(), see, dt)
        self.holding.tick(holds_of(self._acting(), self.asked, self.leaders, self.along.share), see, dt)
        for index, way in list(self._ways.items()):
            if not way.tick(tracks[0], self.along.seeks, self.along.goal, float(passed.max())):
                del self._ways[index]

    def _acting(self) -> list[Pair]:
        """Return the pairs that may be shown: a follower still leaving one leader has no other yet."""
        busy = {pair.follower for pair in self._leaving}
        return [*(pair for pair in self.pairs if pair.follower not in busy), *self._leaving]

    def _let_go(self) -> None:
        """Release the held state of leaders without a visible follower."""
        for key, read in self.leaders.read.items():
            if read.held and not any(
                self.along.level[pair.follower] > 0.0 for pair in self._acting() if (pair.partner, pair.leader) == key
            ):
                read.let_go()
                for pair in self.pairs:
                    if (pair.partner, pair.leader) == key:
                        self.along.forget(pair.follower)

    def _wanted(self, pair: Pair, one: Asked, read: ReadLeader, there: Bool) -> bool:
        """Whether the follower should answer: both are present, and the leader has not stopped."""
        if not (one.on and one.amount > 0.0 and read.known and there[pair.leader] and there[pair.follower]):
            return False
        if one.by_path:
            return True  # a way may rest
        stands = HOLD / read.lore.period if self.live[pair.leader] else STANDS
        return read.still <= stands * read.lore.per_beat

    # -- drawing -------------------------------------------------------------------------------------------------

    def stand(self, position: Float32, rotation: Float32, age: float) -> None:
        """Apply foot lock to the answering dancers in world poses (A, J, 3) and (A, J, 4), `age` [s] after the last
        tick."""
        self._poses.stand(position, rotation, age)

    def reach(self, position: Float32, rotation: Float32, age: float) -> None:
        """Join held hands in world poses (A, J, 3) and (A, J, 4), `age` [s] after the last tick."""
        self.holding.reach(position, rotation, self.along.share, age)

    def show(self, phase: Float64, position: Float32, rotation: Float32, rows: Int32 | None = None) -> None:
        """Blend the answers into world poses `position` (A, J, 3) and `rotation` (A, J, 4) of dancers at `phase`
        (A,) of the measure; with `rows` (n,) only of these dancers, (n, J, 3) and (n, J, 4)."""
        if self.pairs or self._leaving:
            self._poses.show(self._acting(), self.danced(phase), position, rotation, rows)
