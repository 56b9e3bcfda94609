"""Answering: dancers of a show who answer its leaders, live, as followers of examples have answered theirs (H024).

So many times in each of her own beats a leader is looked at as she is seen, and read (`live/motion/example/online`);
what answers her is shown by her followers in place of their steps, which they go on dancing unseen, wherever they are
taken. It comes in over a measure and goes out over one. All is decided in ticks; what is drawn reads it.
"""

import contextlib
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.motion.example.cloud import END_JOINTS
from live.motion.example.staged.holding import Holding
from live.motion.example.staged.kernels import show_answers, turn_between
from live.motion.example.staged.read_leader import ReadLeader
from live.motion.example.staged.standing import Standing
from live.motion.skeleton import SKELETON
from live.show.answer_bank import AnswerBank
from live.show.answer_holds import holds_of
from live.show.answer_pairs import Asked, Pair, asked_of, check_pairs, in_order, pairs_of
from live.show.casting import Casting
from live.show.drawn_ways import DrawnWay
from live.show.patch import Patch
from live.show.variation import Variation

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
Tracks = tuple[Float32, Float32]
See = Callable[[Int32], tuple[Float32, Float32]]

HOLD: Final = 0.25
"""A leader who has not moved for so long [s] has stopped: until then her followers hold what they do."""
STANDS: Final = 2.0
"""Beats a dancer of the show may stand in a step without having stopped."""
NEAR: Final = 0.9
"""Who is nearer than this [m] to where she would answer needs no way there."""
PATIENCE: Final = 3.0
"""Measures after which she goes over wherever she is."""
FASTEST: Final = 0.7
"""So fast [m/s] she is brought to her place beside what she goes herself ..."""
CLOSES: Final = 0.4
"""... with this time constant [s]."""
FADE_HALFLIFE: Final = 0.15
"""Half-life [s] of the way to where the fader is."""
LEAP: Final = 4
"""Frames that a leader's beats may jump by and still go on."""
AT_ONCE: Final = 2
"""Leaders read in one tick; who is next is read in the next one."""
STRAYS: Final = 0.12
"""Who walks along a way is never farther than this [m] from her agent on it."""
APART: Final = 0.618
"""Frames of each next leader begin so much of a frame earlier, so that few begin at once."""
WHOLE: Final = 0.98
"""Where so much of an answer is in, its feet that stand are held."""
BEYOND: Final = 1.6
"""So many frames an answer goes on after its latest frame."""
KEPT: Final = 64
"""News that are kept for who tells them on."""


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
        self._read: dict[tuple[int, int], ReadLeader] = {}
        self.level: Float64 = np.zeros(count)
        """How far each dancer's answer has come in, 0 to 1, linear in time, (A,)."""
        self.following: Bool = np.zeros(count, np.bool_)
        """Who is taken along by her answer now, (A,)."""
        self.carried: Bool = np.zeros(count, np.bool_)
        """Who is, and who goes her own way as an answer to it, (A,)."""
        self.led: Bool = np.zeros(count, np.bool_)
        """Who leads somebody who is, (A,)."""
        self.seeks: Bool = np.zeros(count, np.bool_)
        """Who goes to where she would answer, (A,), and where that is [m]: `goal` (A, 2)."""
        self.goal: Float64 = np.zeros((count, 2))
        self.moved: Float64 = np.zeros((count, 2))
        """By how much each dancer is to be taken elsewhere in this tick [m], (A, 2)."""
        self.live: Bool = np.zeros(count, np.bool_)
        """Who is moved by a stream, (A,): such a leader has stopped as soon as she stands like a picture."""
        self.news: list[tuple[int, str, str]] = []
        """The latest units danced: number from 1, partner, label."""
        self.told = 0
        """How many there were in all."""
        self._fresh: list[str] = []
        self._answered: Float64 = np.zeros((count, 2))  # where the answer was at the last tick
        self._before: Float64 = np.zeros((count, 2))  # where she was to be for it
        self._place: Float64 = np.zeros((count, 2))  # where the dancer was then
        self._share: Float64 = np.zeros(count)
        self._turn: Float64 = np.zeros(count)  # from where she faces to where her answer does
        self.standing = Standing(count)
        """The feet of those who answer."""
        self.holding = Holding(count)
        """Whose hands they hold."""
        self._ways: dict[int, DrawnWay] = {}
        self._agents: Float32 = np.zeros((count, 2), np.float32)
        self._amount: Float64 = np.zeros(count)
        self._waited: Float64 = np.zeros(count)
        self._danced: Float64 = np.zeros(count)
        self._known: Bool = np.zeros(count, np.bool_)
        self._offsets = np.array(SKELETON.offsets, np.float32)
        self._parents = np.array(SKELETON.parents, np.int32)
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
        wanted = {(pair.partner, pair.leader) for pair in pairs}
        old = (*self._leaving, *self.pairs)
        self._leaving = [pair for pair in old if pair not in pairs and self.level[pair.follower] > 0.0]
        keep = wanted | {(pair.partner, pair.leader) for pair in self._leaving}
        for key in [key for key in self._read if key not in keep]:
            del self._read[key]
        for key in sorted(wanted - set(self._read)):
            self._read[key] = ReadLeader(self.bank.lores[key[0]], (len(self._read) * APART) % 1.0)
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
        self._read_leaders(danced, there, tracks, see)
        self.moved[:] = 0.0
        self._agents[:] = tracks[0]
        for those in (self.following, self.carried, self.led, self.seeks):
            those[:] = False
        self._let_go()
        for pair in self._acting():
            self._go(pair, danced, passed, hips, there, dt)
            turned = self._read[pair.partner, pair.leader].turned[0, 0]
            row, known = pair.follower, self.level[pair.follower] > 0.0
            self._turn[row] = turn_between(faces[row], turned, float(self._turn[row]) if known else 0.0)
        self._leaving = [pair for pair in self._leaving if self.level[pair.follower] > 0.0]
        self._stand(see, dt)
        self.holding.tick(holds_of(self._acting(), self.asked, self._read, self._share), see, dt)
        for index, way in list(self._ways.items()):
            if not way.tick(tracks[0], self.seeks, self.goal, float(passed.max())):
                del self._ways[index]

    def _acting(self) -> list[Pair]:
        """The pairs that are shown, or may be: who leaves one leader has no other one yet."""
        busy = {pair.follower for pair in self._leaving}
        return [*(pair for pair in self.pairs if pair.follower not in busy), *self._leaving]

    def _let_go(self) -> None:
        """What is held for nobody is let go."""
        for key, read in self._read.items():
            if read.held and not any(
                self.level[pair.follower] > 0.0 for pair in self._acting() if (pair.partner, pair.leader) == key
            ):
                read.let_go()
                for pair in self.pairs:
                    if (pair.partner, pair.leader) == key:
                        self._known[pair.follower] = False

    def _read_leaders(self, danced: Float64, there: Bool, tracks: Tracks, see: See) -> None:
        """Those whose next frame has begun, AT_ONCE of them, who waits longest first."""
        due = []
        for key, read in self._read.items():
            leader = key[1]
            frames = read.due(float(danced[leader]))
            if read.line is not None and not 0 <= frames <= LEAP:
                read.hold(self._frames(read, float(danced[leader])))
            if frames and there[leader] and self.asked[key[0]].on:
                due.append((-frames, key))
        due.sort(key=lambda one: (one[0], one[1]))
        now = [key for _, key in due[:AT_ONCE]]
        rows = np.array([key[1] for key in now if not self.asked[key[0]].by_path], np.int32)
        if len(rows):
            position, _ = see(rows)
            points = position[:, END_JOINTS].astype(np.float64)
        n = 0
        for key in now:
            read, leader, one = self._read[key], key[1], self.asked[key[0]]
            if one.by_path:
                floor, height = read.shadows(*tracks, leader)
            else:
                floor, height = points[n, :, 2] + 1j * points[n, :, 0], points[n, :, 1]
                n += 1
            read.frame(np.ascontiguousarray(floor), np.ascontiguousarray(height), float(danced[leader]), one.window)
            if read.news:
                self._tell(one.name, read.news)

    def _tell(self, name: str, label: str) -> None:
        self.told += 1
        self.news = [*self.news[1 - KEPT :], (self.told, name, label)]
        self._fresh.append(label)

    def take_fresh(self) -> list[str]:
        """The labels of units that were decided since the last call."""
        fresh, self._fresh = self._fresh, []
        return fresh

    # -- where she goes ------------------------------------------------------------------------------------------

    def _go(self, pair: Pair, danced: Float64, passed: Float64, hips: Float32, there: Bool, dt: float) -> None:
        """Take the follower of a pair along, as far as her answer is in."""
        row, one = pair.follower, self.asked[pair.partner]
        read = self._read[pair.partner, pair.leader]
        wanted = pair in self.pairs and self._wanted(pair, one, read, there)
        seen = answer = self._answer(read, danced[pair.leader])
        if one.by_path:  # who walks stays with her agent, and does not overstep where that stops
            away = answer - self._agents[row]
            answer = self._agents[row] + away * min(1.0, STRAYS / max(float(np.hypot(*away)), 1e-9))
        if not read.answered or (read.held and not self.level[row]):
            return
        if not self._known[row] or self.level[row] == 0.0:
            self._known[row] = True
            self._answered[row], self._before[row], self._place[row] = seen, answer, hips[row]
        gap = answer - hips[row]
        far = not pair.own_place and float(np.hypot(*gap)) > NEAR
        measures = float(passed[row]) / self._beats
        if wanted and self.level[row] == 0.0 and far and self._waited[row] < PATIENCE:
            self._waited[row] += measures
            self.seeks[row], self.goal[row] = True, answer
            self._answered[row], self._before[row], self._place[row] = seen, answer, hips[row]
            return
        self._waited[row] = 0.0
        level = min(max(self.level[row] + (measures if wanted else -measures), 0.0), 1.0)
        self.level[row] = level
        self._amount[row] += (1.0 - math.exp2(-dt / FADE_HALFLIFE)) * (one.amount - self._amount[row])
        if not level:
            self._amount[row] = one.amount
        share = level * level * (3.0 - 2.0 * level) * float(self._amount[row])
        self._share[row] = share
        if share > 0.0:
            self._carry(pair, one, share, answer, hips, dt)
        self._answered[row], self._before[row], self._place[row] = seen, answer, hips[row] + self.moved[row]
        self.carried[row] = share > 0.0
        self.following[row] = share > 0.0 and not one.by_path
        self.led[pair.leader] |= self.following[row]

    def _carry(self, pair: Pair, one: Asked, share: float, answer: Float64, hips: Float32, dt: float) -> None:
        """She goes as her answer goes and as her steps go, as far as each is in; beside that, to where it is."""
        row = pair.follower
        own = hips[row] - self._place[row]
        move = share * (answer - self._before[row] - own)
        if not pair.own_place or one.by_path:
            gap = answer - (hips[row] + move)
            size = float(np.hypot(*gap))
            pull = share * min(size * (1.0 - math.exp(-dt / CLOSES)), FASTEST * dt)
            move = move + gap * (pull / max(size, 1e-9))
        self.moved[row] = move

    def _wanted(self, pair: Pair, one: Asked, read: ReadLeader, there: Bool) -> bool:
        """Whether she is to answer: both are there, and the leader has not stopped."""
        if not (one.on and one.amount > 0.0 and read.known and there[pair.leader] and there[pair.follower]):
            return False
        if one.by_path:
            return True  # a way may rest
        stands = HOLD / read.lore.period if self.live[pair.leader] else STANDS
        return read.still <= stands * read.lore.per_beat

    def _answer(self, read: ReadLeader, danced: float) -> Float64:
        """Where the answer is when its leader has danced so many beats [m], (2,)."""
        t = 2.0 * self._frames(read, danced)
        begin = int(t >= 1.0)
        t -= begin
        return np.asarray((1.0 - t) * read.root[begin, ::2] + t * read.root[begin + 1, ::2], np.float64)

    def _frames(self, read: ReadLeader, danced: float) -> float:
        """How many frames have passed since the latest one."""
        return min(max(read.since(danced), 0.0), BEYOND)

    def _stand(self, see: See, dt: float) -> None:
        """Follow the feet of those who answer wholly."""
        whole = [pair for pair in self._acting() if self._share[pair.follower] > WHOLE and self.carried[pair.follower]]
        if not whole and not self.standing.lock.farthest:
            return
        rows = np.array([pair.follower for pair in whole], np.int32)
        if not whole:
            self.standing.tick(rows, np.zeros((0, len(self._parents), 3), np.float32), np.zeros((0, 2), np.bool_), dt)
            return
        contact = np.stack([self._read[pair.partner, pair.leader].contact for pair in whole])
        self.standing.tick(rows, see(rows)[0], contact, dt)

    # -- what is seen --------------------------------------------------------------------------------------------

    def stand(self, position: Float32, rotation: Float32, age: float) -> None:
        """Hold the feet of those who answer in poses (A, J, 3) and (A, J, 4), world, `age` [s] after the last tick."""
        self.standing.hold(np.flatnonzero(self._share > 0.0).astype(np.int32), position, rotation, age)

    def reach(self, position: Float32, rotation: Float32, age: float) -> None:
        """Bring hands that are held together in poses (A, J, 3) and (A, J, 4), world, `age` [s] after the last tick."""
        self.holding.reach(position, rotation, self._share, age)

    def show(self, phase: Float64, position: Float32, rotation: Float32, rows: Int32 | None = None) -> None:
        """Change poses at `position` (A, J, 3) and `rotation` (A, J, 4), world, of dancers at `phase` (A,) of the
        measure to what answers; or those of the dancers `rows` (n,) alone, (n, J, 3) and (n, J, 4)."""
        shown = [pair for pair in self._acting() if self._share[pair.follower] > 0.0]
        where = None if rows is None else {int(row): n for n, row in enumerate(rows)}
        if where is not None:
            shown = [pair for pair in shown if pair.follower in where]
        if not shown:
            return
        danced = self.danced(phase)
        reads = [self._read[pair.partner, pair.leader] for pair in shown]
        follow = np.array([pair.follower for pair in shown], np.int32)
        who = follow if where is None else np.array([where[int(row)] for row in follow], np.int32)
        frames = [self._frames(read, float(danced[pair.leader])) for pair, read in zip(shown, reads, strict=True)]
        show_answers(
            position, rotation, who, np.arange(len(shown), dtype=np.int32), np.array(frames), self._share[follow],
            self._turn[follow],
            np.ascontiguousarray(self._place[follow]), np.ascontiguousarray(self._answered[follow]),
            np.stack([read.root for read in reads]), np.stack([read.turned for read in reads]),
            self._offsets, self._parents,
        )  # fmt: skip
