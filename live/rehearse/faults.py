"""Faults: what goes wrong in a hall, at seeded times of the show."""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

SALT: Final = 0xFA17
KINDS: Final = {
    "source lost": 0.10, "stall": 0.15, "flood": 0.08, "garbage": 0.10, "good edit": 0.20, "bad edit": 0.15,
    "edit back": 0.05, "tempo jump": 0.10, "impossible beats": 0.08, "device again": 0.05, "other source": 0.08,
    "crowd of calls": 0.05, "rest": 0.05,
}  # fmt: skip
"""Kinds, and how often each comes in a minute."""


class Fault(NamedTuple):
    """One fault."""

    time: float
    """When [s of the show]."""
    kind: str
    size: float
    """How bad it is, 0 to 1."""


def faults(seed: int, *, rate: float = 1.0, start: float = 20.0) -> Iterator[Fault]:
    """Fault after fault, in the order of their times, without an end; `rate`: so many times as often as KINDS says."""
    if rate <= 0.0:
        return
    chance = np.random.default_rng([seed, SALT])
    names = list(KINDS)
    shares = np.array([KINDS[name] for name in names])
    each, time = 60.0 / (rate * float(shares.sum())), start
    while True:
        time += float(chance.exponential(each))
        name = names[int(chance.choice(len(names), p=shares / shares.sum()))]
        yield Fault(time, name, float(chance.random()))
