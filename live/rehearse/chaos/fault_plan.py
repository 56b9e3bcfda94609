"""What goes wrong in a chaos run of real processes, and when: seeded, every kind once before any comes again."""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

SALT: Final = 0xCA05
KINDS: Final = {
    "exception once": 8.0, "exception three times": 9.0, "exception always": 12.0,
    "exception in a thread": 4.0, "exception in callbacks": 5.0,
    "kill engine": 9.0, "kill engine twice": 14.0, "kill spare": 9.0, "kill nursery": 9.0, "kill sound": 6.0,
    "kill supervisor": 22.0,
    "stop engine briefly": 5.0, "stop engine": 12.0, "stop supervisor": 6.0, "stop all in bursts": 6.0,
    "starve": 8.0,
    "disk full": 6.0, "disk read-only": 6.0,
    "no descriptors in the engine": 8.0, "no descriptors in the supervisor": 10.0,
    "clock steps": 4.0,
    "cut web": 3.0, "cut audience": 3.0, "cut OSC": 3.0, "cut the engine's wire": 10.0,
}  # fmt: skip
"""Kinds of faults, and for how long [s] each is given: for itself, and until all is as before."""
ENDS_ENGINE: Final = (
    "exception once", "exception three times", "exception always", "kill engine", "kill engine twice", "stop engine",
    "cut the engine's wire",
)  # fmt: skip
"""Kinds after which another engine goes on, and is counted."""
LEAST: Final = {"kill engine twice": 2, "stop engine": 0}
"""So many engines end at least; one that was stopped may go on by itself, if the watchdog waits for a busy machine."""
DISK: Final = ("disk full", "disk read-only", "no descriptors in the supervisor")
"""Kinds in which lines of the journal may be lost."""


class Blow(NamedTuple):
    """One fault of a chaos run."""

    time: float
    """When [s since the show was ready]."""
    kind: str
    size: float
    """How bad it is, 0 to 1."""
    which: int
    """Which call site, thread or process, of those that there are."""


def blows(seed: int, *, until: float, rate: float = 1.0) -> Iterator[Blow]:
    """Fault after fault until that time [s]; `rate`: so many times as fast as `KINDS` allow."""
    chance = np.random.default_rng([seed, SALT])
    time, names = 1.0, list(KINDS)
    while True:
        for index in chance.permutation(len(names)):
            kind = names[int(index)]
            if time + KINDS[kind] / rate > until:
                return
            yield Blow(time, kind, float(chance.random()), int(chance.integers(1 << 20)))
            time += KINDS[kind] / rate
