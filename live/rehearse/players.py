"""FakePlayers: people with phones and control surfaces, who touch a show when they like; Poisson, seeded."""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from live.control.registry.asking import ASKING_CONTROLS
from live.control.registry.control import Control
from live.control.registry.registry import REGISTRY
from live.rehearse.words import Words, junk

SALT: Final = 0xF0E5
RANKS: Final = {"audience": 0, "musician": 1, "operator": 2}
FOLLOWED: Final = ("/dance/attract", "/dance/voice", "/dance/performer")
"""What a finger on a phone sends again and again while it moves."""
SHARES: Final = {"/dance/go": 4.0, "/dance/section": 3.0, "/dance/signal": 3.0, "/dance/undo": 3.0}
"""How much more often some are used than others."""
RARE: Final = ("/dance/ping", "/dance/panic", "/dance/blackout", "/dance/clear", "/dance/stage", "/dance/hold",
               "/dance/hold/score", "/dance/practice", "/dance/clock/source", "/dance/clock/metre", "/dance/clock/hold",
               "/dance/clock/half", "/dance/clock/double", "/dance/clock/count_in", "/dance/output/fade",
               "/dance/output/freeze", "/dance/output/flashes", "/dance/output/card",
               "/dance/picture/quality")  # fmt: skip


class Call(NamedTuple):
    """One message."""

    time: float
    """When it arrives [s of the show]."""
    address: str
    values: list[object]
    source: str


class FakePlayers:
    """So many people, each of whom touches something about `rate` times a minute."""

    def __init__(
        self, seed: int, words: Words, *, count: int = 8, rate: float = 6.0, nonsense: float = 0.05,
        role: str = "operator", start: float = 0.0,
    ) -> None:  # fmt: skip
        """`rate` [1/min] of each; `nonsense`: the share of messages that make no sense; `role`: the most they may."""
        self._chance = np.random.default_rng([seed, SALT])
        self._words, self._nonsense = words, nonsense
        self._rate = count * rate / 60.0
        self._count, self._time = count, start
        allowed = (control for control in REGISTRY if RANKS[control.who] <= RANKS[role])
        self._controls = [control for control in allowed if control not in ASKING_CONTROLS]
        weights = np.array([_share(control) for control in self._controls])
        self._shares = weights / weights.sum()

    def calls(self) -> Iterator[Call]:
        """Message after message, in the order of their times, without an end."""
        chance = self._chance
        while self._rate > 0.0:
            self._time += float(chance.exponential(1.0 / self._rate))
            source = f"phone {int(chance.integers(self._count)) + 1}"
            control = self._controls[int(chance.choice(len(self._controls), p=self._shares))]
            if chance.random() < self._nonsense:
                yield Call(self._time, control.address, junk(chance), source)
                continue
            values: list[object] = list(self._words.values(control, chance))
            yield Call(self._time, control.address, values, source)
            if control.address in FOLLOWED and len(values) >= 2:
                yield from self._finger(control, values, source)

    def _finger(self, control: Control, values: list[object], source: str) -> Iterator[Call]:
        """The same finger, moving for a second or so."""
        at = [index for index, argument in enumerate(control.arguments) if argument.name in ("x", "z")]
        time = self._time
        for _ in range(int(self._chance.integers(2, 20))):
            time += 0.05
            values = list(values)
            for index in at:
                values[index] = float(values[index]) + 0.1 * float(self._chance.standard_normal())  # type: ignore[arg-type]
            yield Call(time, control.address, values, source)
        self._time = time


def _share(control: Control) -> float:
    if control.address in RARE:
        return 0.15
    return SHARES.get(control.address, 1.0)
