"""Taken along: how far each dancer's answer has come in, and where it takes her.

It comes in over a measure and goes out over one. Who is far from where she would answer goes there first; who answers
moves as her answer and her own steps do, as far as each is in.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.partner_live.stage_partner import ReadLeader
from live.motion.partner_live.stage_partner_kernels import turn_between
from live.show.partner.leader_input import answer_at
from live.show.partner.partner_pairs import Asked, Pair

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

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
STRAYS: Final = 0.12
"""Who walks along a way is never farther than this [m] from her agent on it."""


class TakenAlong:
    """Who of A dancers is taken along by an answer, and how. Thread: the show's."""

    def __init__(self, count: int) -> None:
        self.level: Float64 = np.zeros(count)
        """How far each dancer's answer has come in, 0 to 1, linear in time, (A,)."""
        self.share: Float64 = np.zeros(count)
        """How much of it is shown, (A,)."""
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
        self.answered: Float64 = np.zeros((count, 2))
        """Where the answer was at the last tick [m], (A, 2)."""
        self.place: Float64 = np.zeros((count, 2))
        """Where the dancer was then [m], (A, 2)."""
        self.turn: Float64 = np.zeros(count)
        """From where she faces to where her answer does [rad], (A,)."""
        self._before: Float64 = np.zeros((count, 2))  # where she was to be for it
        self._amount: Float64 = np.zeros(count)
        self._waited: Float64 = np.zeros(count)
        self._known: Bool = np.zeros(count, np.bool_)

    def begin_tick(self) -> None:
        """Nobody is moved, taken along or on her way yet."""
        self.moved[:] = 0.0
        for those in (self.following, self.carried, self.led, self.seeks):
            those[:] = False

    def forget(self, row: int) -> None:
        """Where the answer of a dancer was is known no more: it is another one."""
        self._known[row] = False

    def go(
        self, pair: Pair, one: Asked, read: ReadLeader, *, wanted: bool, danced: float, measures: float,
        hips: Float32, agents: Float32, dt: float,
    ) -> None:  # fmt: skip
        """Take the follower of a pair along, as far as her answer is in; it comes in while it is `wanted`.

        Her leader has `danced` so many beats, `measures` have passed since the last tick, `dt` [s] ago; dancers are
        with their `hips` (A, 2) [m], their agents at `agents` (A, 2) [m].
        """
        row = pair.follower
        seen = answer = answer_at(read, danced)
        if one.by_path:  # who walks stays with her agent, and does not overstep where that stops
            away = answer - agents[row]
            answer = agents[row] + away * min(1.0, STRAYS / max(float(np.hypot(*away)), 1e-9))
        if not read.answered or (read.held and not self.level[row]):
            return
        if not self._known[row] or self.level[row] == 0.0:
            self._known[row] = True
            self._remember(row, seen, answer, hips[row])
        gap = answer - hips[row]
        far = not pair.own_place and float(np.hypot(*gap)) > NEAR
        if wanted and self.level[row] == 0.0 and far and self._waited[row] < PATIENCE:
            self._waited[row] += measures
            self.seeks[row], self.goal[row] = True, answer
            self._remember(row, seen, answer, hips[row])
            return
        self._waited[row] = 0.0
        level = min(max(self.level[row] + (measures if wanted else -measures), 0.0), 1.0)
        self.level[row] = level
        self._amount[row] += (1.0 - math.exp2(-dt / FADE_HALFLIFE)) * (one.amount - self._amount[row])
        if not level:
            self._amount[row] = one.amount
        share = level * level * (3.0 - 2.0 * level) * float(self._amount[row])
        self.share[row] = share
        if share > 0.0:
            self._carry(pair, one, share, answer, hips, dt)
        self._remember(row, seen, answer, hips[row] + self.moved[row])
        self.carried[row] = share > 0.0
        self.following[row] = share > 0.0 and not one.by_path
        self.led[pair.leader] |= self.following[row]

    def _remember(self, row: int, seen: Float64, answer: Float64, place: Float32 | Float64) -> None:
        self.answered[row], self._before[row], self.place[row] = seen, answer, place

    def _carry(self, pair: Pair, one: Asked, share: float, answer: Float64, hips: Float32, dt: float) -> None:
        """She goes as her answer goes and as her steps go, as far as each is in; beside that, to where it is."""
        row = pair.follower
        own = hips[row] - self.place[row]
        move = share * (answer - self._before[row] - own)
        if not pair.own_place or one.by_path:
            gap = answer - (hips[row] + move)
            size = float(np.hypot(*gap))
            pull = share * min(size * (1.0 - math.exp(-dt / CLOSES)), FASTEST * dt)
            move = move + gap * (pull / max(size, 1e-9))
        self.moved[row] = move

    def face(self, row: int, face: Float32, answered: Float32) -> None:
        """How far her answer, with its hips turned by `answered` (4,), is turned from her own `face` (4,)."""
        known = self.level[row] > 0.0
        self.turn[row] = turn_between(face, answered, float(self.turn[row]) if known else 0.0)
