"""Answering: dancers of a show who answer its leaders, live, as followers of examples have answered theirs (H024).

So many times in each of her own beats a leader is looked at as she is seen, and read (`live/motion/example/online`);
what answers her is shown by her followers in place of their steps, which they go on dancing unseen, wherever they are
taken. It comes in over a measure and goes out over one. All is decided in ticks; what is drawn reads it.
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
"""A leader who has not moved for so long [s] has stopped: until then her followers hold what they do."""
STANDS: Final = 2.0
"""Beats a dancer of the show may stand in a step without having stopped."""


class Answering:
    """The partners of one show, of A dancers. Thread: the show's."""

    def __init__(self, patch: Patch, casting: Casting, variation: Variation, bank: AnswerBank | None) -> None:
        """Without a bank nobody answers. PersonError for partners that cannot be was told before (`check_partners`)."""
        count = len(casting.group)
        self.bank = bank or AnswerBank(())
        self._casting, self._variation = casting, variation
        self._beats = patch.clock.beats_per_measure
        self.asked: list[Asked] = asked_of(patch) if self.bank.lores else []
        self.pairs: list[Pair] = []
        self.leaders = AnswerLeaders(self.bank)
        """Who is answered."""
        self.along = TakenAlong(count)
        """Who answers, and where that takes her."""
        self.live: Bool = np.zeros(count, np.bool_)
        """Who is moved by a stream, (A,): such a leader has stopped as soon as she stands like a picture."""
        self._poses = AnswerPoses(self.leaders, self.along)
        self.holding = Holding(count)
        """Whose hands they hold."""
        self._ways: dict[int, DrawnWay] = {}
        self._agents: Float32 = np.zeros((count, 2), np.float32)
        self._danced: Float64 = np.zeros(count)
        self._written, self._roster = list(self.asked), casting.roster
        self._leaving: list[Pair] = []
        self.ask(self.asked)

    def take_patch(self, fresh: "Answering") -> None:
        """Ask what another patch asks; what was said live of partners whose tables are the same stays.

        What it answers from is known from the start on (`edit.fitted` sees to that).
        """
        for index, (old, new) in enumerate(zip(self._written, fresh._written, strict=True)):
            if old != new:
                self.asked[index] = new
        self._written = fresh._written
        self.settle()

    # -- who answers whom ----------------------------------------------------------------------------------------

    def ask(self, asked: list[Asked]) -> None:
        """Something else is asked from now on; PersonError if that cannot be, and all stays as it was."""
        pairs = in_order(pairs_of(asked, self._casting))
        check_pairs(asked, pairs)
        self.asked = asked
        self._take(pairs)

    def settle(self) -> None:
        """Groups may be others than before: who can still answer somebody does."""
        if self.asked:
            with contextlib.suppress(PersonError):
                self.ask(self.asked)

    def find(self, name: str) -> list[int]:
        """The partners that a name means; "" and "*" are all. PersonError if none is called so."""
        if name.strip() in ("", "*") and self.asked:
            return list(range(len(self.asked)))
        found = [n for n, one in enumerate(self.asked) if one.name.casefold() == name.casefold().strip()]
        if not found:
            known = ", ".join(one.name for one in self.asked) or "none: write [[partner]]"
            raise PersonError(f"no partner is called {name!r}", f"there are: {known}")
        return found

    def change(self, name: str, key: str, value: object) -> None:
        """What is asked of the partners called `name` changes in one key of `Asked`; PersonError if it cannot be."""
        asked = list(self.asked)
        for index in self.find(name):
            if key == "window":
                value = min(float(str(value)), self.bank.lores[index].stretch)
            asked[index] = replace(asked[index], **{key: value})  # type: ignore[arg-type]
        self.ask(asked)

    def walk_on(self, name: str, point: tuple[float, float], *, anew: bool) -> None:
        """Who is led by her own way in the partners called `name` goes on to `point` [m]; PersonError for none."""
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
        """Read those who lead now; who answered somebody else leaves her first."""
        old = (*self._leaving, *self.pairs)
        self._leaving = [pair for pair in old if pair not in pairs and self.along.level[pair.follower] > 0.0]
        self.leaders.take(pairs, self._leaving)
        self.pairs = pairs

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self) -> None:
        """A measure begins: dancers may be of other groups now."""
        if self._casting.roster is not self._roster:
            self._roster = self._casting.roster
            self.settle()

    def danced(self, phase: Float64) -> Float64:
        """Beats danced so far by everybody, who is at `phase` (A,) of the present measure."""
        return np.asarray((self._variation.measure + phase) * self._beats)

    def tick(
        self, phase: Float64, hips: Float32, faces: Float32, there: Bool, tracks: Tracks, see: See, dt: float
    ) -> None:
        """A tick of `dt` [s]: read who leads, and take along who answers.

        Dancers are at `phase` (A,) of the measure with their `hips` (A, 2) [m], turned by `faces` (A, 4); `there` (A,):
        who is on the stage. `tracks`: places (A, 2) [m] and velocities (A, 2) [m/s] of their agents. `see` tells how
        some dancers look now.
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
        """The pairs that are shown, or may be: who leaves one leader has no other one yet."""
        busy = {pair.follower for pair in self._leaving}
        return [*(pair for pair in self.pairs if pair.follower not in busy), *self._leaving]

    def _let_go(self) -> None:
        """What is held for nobody is let go."""
        for key, read in self.leaders.read.items():
            if read.held and not any(
                self.along.level[pair.follower] > 0.0 for pair in self._acting() if (pair.partner, pair.leader) == key
            ):
                read.let_go()
                for pair in self.pairs:
                    if (pair.partner, pair.leader) == key:
                        self.along.forget(pair.follower)

    def _wanted(self, pair: Pair, one: Asked, read: ReadLeader, there: Bool) -> bool:
        """Whether she is to answer: both are there, and the leader has not stopped."""
        if not (one.on and one.amount > 0.0 and read.known and there[pair.leader] and there[pair.follower]):
            return False
        if one.by_path:
            return True  # a way may rest
        stands = HOLD / read.lore.period if self.live[pair.leader] else STANDS
        return read.still <= stands * read.lore.per_beat

    # -- what is seen --------------------------------------------------------------------------------------------

    def stand(self, position: Float32, rotation: Float32, age: float) -> None:
        """Hold the feet of those who answer in poses (A, J, 3) and (A, J, 4), world, `age` [s] after the last tick."""
        self._poses.stand(position, rotation, age)

    def reach(self, position: Float32, rotation: Float32, age: float) -> None:
        """Bring hands that are held together in poses (A, J, 3) and (A, J, 4), world, `age` [s] after the last tick."""
        self.holding.reach(position, rotation, self.along.share, age)

    def show(self, phase: Float64, position: Float32, rotation: Float32, rows: Int32 | None = None) -> None:
        """Change poses at `position` (A, J, 3) and `rotation` (A, J, 4), world, of dancers at `phase` (A,) of the
        measure to what answers; or those of the dancers `rows` (n,) alone, (n, J, 3) and (n, J, 4)."""
        if self.pairs or self._leaving:
            self._poses.show(self._acting(), self.danced(phase), position, rotation, rows)
