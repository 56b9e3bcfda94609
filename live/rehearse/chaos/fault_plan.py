"""Seeded schedule of faults for a chaos run of real processes; every kind comes once before any is repeated."""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

SALT: Final = 0xCA05
FAULT_SECONDS: Final = {
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
"""Kinds of faults, and the time [s] for each: the fault itself and the recovery."""
ENGINE_FAULTS: Final = (
    "exception once", "exception three times", "exception always", "kill engine", "kill engine twice", "stop engine",
    "cut the engine's wire",
)  # fmt: skip
"""Kinds after which another engine takes over; these restarts are counted."""
MIN_ENDED_ENGINES: Final = {"kill engine twice": 2, "stop engine": 0}
"""Minimum number of ended engines. A stopped engine may resume if the watchdog is patient with a busy machine."""
DISK_FAULTS: Final = ("disk full", "disk read-only", "no descriptors in the supervisor")
"""Kinds that may lose lines of the journal."""


class ChaosFault(NamedTuple):
    """One fault of a chaos run."""

    time: float
    """When [s since the show was ready]."""
    kind: str
    severity: float
    """Severity, 0 to 1."""
    selector: int
    """Random number that selects the call site, thread or process."""


def chaos_schedule(seed: int, *, until: float, rate: float = 1.0) -> Iterator[ChaosFault]:
    """Yield faults until `until` [s]; `rate`: factor by which they come faster than the times in `KINDS`."""
    chance = np.random.default_rng([seed, SALT])
    time, names = 1.0, list(FAULT_SECONDS)
    while True:
        for index in chance.permutation(len(names)):
            kind = names[int(index)]
            if time + FAULT_SECONDS[kind] / rate > until:
                return
            yield ChaosFault(time, kind, float(chance.random()), int(chance.integers(1 << 20)))
            time += FAULT_SECONDS[kind] / rate
