"""Motion segments: how an intention sits on the timeline: who, when, how long, how varied (T085, T086)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from live.agents.evolutions.intention import Intention
from live.agents.evolutions.start_delays import TOGETHER, Ripple
from live.agents.groups.relations import Line, canon
from live.base.errors import PersonError


@dataclass(frozen=True, slots=True)
class Segment:
    """One evolution of one group over some measures."""

    intention: str | Intention
    """A name in the repertoire, so that edits reach it, or an intention of its own."""
    group: str = ""
    """Who, as an expression of `groups.selection`; empty means everyone. Places mean where they stand at the start."""
    start: int = 0
    """Measure at whose line it begins, from 0."""
    measures: int = 1
    """Measures until all have arrived."""
    ripple: Ripple = TOGETHER
    """Starts that differ from dancer to dancer."""
    mirror: Line | None = None
    """Formation or way are mirrored about this line."""
    later: float = 0.0
    """Beats by which it begins and ends later than its measures (canon)."""

    def __post_init__(self) -> None:
        if self.measures < 1 or self.start < 0:
            raise PersonError(
                f"a segment of {self.measures} measures from measure {self.start + 1} on",
                "measures count from 1, and a segment lasts at least one",
            )
        if not 0.0 <= self.later < 1e6:
            raise PersonError(f"a segment that begins {self.later} beats later", "it can only be later, not earlier")

    def begin_beat(self, measure_beats: float) -> float:
        """The beat (from the first measure line) at which it begins."""
        return self.start * measure_beats + self.later

    def end_beat(self, measure_beats: float) -> float:
        """The beat at which all have arrived."""
        return (self.start + self.measures) * measure_beats + self.later


def in_canon(segment: Segment, groups: Sequence[str], beats: float) -> tuple[Segment, ...]:
    """The same motion by several groups, each `beats` later than the one before (T147)."""
    return tuple(
        replace(segment, group=group, later=segment.later + delay)
        for group, delay in zip(groups, canon(len(groups), beats), strict=True)
    )


def in_mirror(segment: Segment, group: str, line: Line | None = None) -> tuple[Segment, Segment]:
    """The motion, and the same by another group mirrored about `line` (the middle line of the stage if left out)."""
    return segment, replace(segment, group=group, mirror=line or Line())
