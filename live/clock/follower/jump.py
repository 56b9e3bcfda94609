"""Jump: what is announced when the beat or the measure lines do not simply go on."""

from dataclasses import dataclass
from typing import Literal

Cause = Literal["start", "new song", "one", "lines", "hand", "first downbeat"]
"""start: the source started or moved its song position; new song: after silence the tempo is another one; one: "this
is the one"; lines: the source's measure lines are taken over; hand: nudged by beats, halved or doubled; first downbeat:
the measures are counted back to the known first one."""


@dataclass(frozen=True, slots=True)
class Jump:
    """At `time` [s] the beat went from `before` to `after` (equal where only the measure lines moved)."""

    time: float
    before: float
    after: float
    cause: Cause
