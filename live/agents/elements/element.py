"""One element as a value: kind, place, groups, strength and time span."""

import itertools
import math
from dataclasses import dataclass, replace
from typing import Final

from live.agents.elements import element_table_kernels as column
from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    DECAYS,
    DRAWN,
    EVERYBODY,
    FLOCK,
    FLOW,
    GRID,
    KIND_NAMES,
    LINE_KINDS,
    MAX_POINTS,
    PARTICIPANT,
    TARGETED_KINDS,
    UNIFORM,
)
from live.base.errors import PersonError

FADE_BEATS: Final = 1.0
"""Fade time in beats: ease-out after the start, linear before the end."""
CROSSING_SEPARATION: Final = 0.7
"""Separation of crossing dancers [m]; more would keep the two streams apart."""
MAX_DISTANCE: Final = 1000.0
"""Largest distance of an element from the middle of the stage [m]."""
Points = tuple[tuple[float, float], ...]
_NAMES: Final = {kind: word for word, kind in reversed(KIND_NAMES.items())}


@dataclass(frozen=True, slots=True)
class Element:
    """One element; it fades in over its first beat and out over its last one (T105, T132).

    `points` (x, z) [m] are its place: one for a point, two for a segment, more for a polyline (`closed`: a region or a
    closed path). `radius` [m] makes a disc or a broad line, and is the half width of a path. A crossing is the line
    through its first two points; a uniform flow goes from the first to the second; radial flow and vortex are centred
    on the first (negative strength: inwards, or reversed).
    """

    kind: int
    points: Points = ((0.0, 0.0),)
    strength: float = 1.0
    start_beat: float = 0.0
    end_beat: float = math.inf
    groups: int = EVERYBODY
    """Bit mask of the addressed groups; EVERYBODY includes dancers of no group."""
    source: str = ""
    """Origin of the element: a phone, an OSC address or the score."""
    closed: bool = False
    radius: float = 0.0
    fair: bool = False
    """One vote of an audience: attractors are clustered, places with many votes win, a single one captures no dancer.
    """
    flow_kind: int = UNIFORM
    decay: float | None = None
    """Decay length [m] of f(d) = exp(-d / decay); None: the default of its kind."""
    target: int = -1
    """Index of the dancer to follow, pursue or evade; -1: the dancers of `target_group`."""
    target_group: int = -1
    """Bit of the group to pursue or evade (its nearest dancer) or to follow (its first dancer)."""
    wedge: bool = False
    """Whether followers form a wedge instead of a line."""
    separation: float | None = None
    """Distance [m] below which the addressed dancers repel each other; None: the field's default."""
    alignment: float = 0.6
    cohesion: float = 0.4
    """Weights of a flock's `alignment` and `cohesion`."""

    def __post_init__(self) -> None:
        """Validate all fields; raises PersonError."""
        name = _NAMES.get(self.kind)
        if name is None:
            raise PersonError(f"no kind of element has the number {self.kind}", "use the names of KIND_NAMES")
        places = tuple(itertools.chain.from_iterable(self.points))
        numbers = self.strength, self.start_beat, self.radius, self.alignment, self.cohesion, *places
        numbers += self.decay or 1.0, self.separation or 0.0
        if not all(map(math.isfinite, numbers)) or math.isnan(self.end_beat):
            raise PersonError(f"{name}: every place, strength and beat must be a finite number")
        if not 1 <= len(self.points) <= MAX_POINTS:
            raise PersonError(f"{name}: {len(self.points)} points", f"give 1 to {MAX_POINTS}")
        if max(places) > MAX_DISTANCE or min(places) < -MAX_DISTANCE:
            raise PersonError(
                f"{name}: a place more than {MAX_DISTANCE:.0f} m away", "places are metres from the middle"
            )
        if self.radius < 0.0 or (self.decay is not None and self.decay <= 0.0) or (self.separation or 0.0) < 0.0:
            raise PersonError(
                f"{name}: radius, decay and separation must not be negative, decay must be above 0",
                "give numbers above 0",
            )
        if not 0 < self.groups <= EVERYBODY:
            raise PersonError(f"{name}: the group mask {self.groups} addresses nobody", "set at least one of 64 bits")
        self._check_place(name)

    def _check_place(self, name: str) -> None:
        needs_line = self.kind in LINE_KINDS or (self.kind == FLOW and self.flow_kind in (UNIFORM, DRAWN))
        if needs_line and line_length(self.points) < 1e-3:
            raise PersonError(f"{name}: its line has no length", "give two points that lie apart")
        if self.kind == CROSSING and math.dist(self.points[0], self.points[1]) < 1e-3:
            raise PersonError(f"{name}: the first two points of its line coincide", "give two points that lie apart")
        if self.kind in TARGETED_KINDS and (self.target < 0) == (self.target_group < 0):
            raise PersonError(f"{name}: target missing or ambiguous", "give either a dancer or a group")
        if not -1 <= self.target_group <= 63 or self.target < -1:
            raise PersonError(f"{name}: no such dancer or group", "dancers count from 0, groups have bits 0 to 63")
        if self.kind == FLOW and not UNIFORM <= self.flow_kind <= GRID:
            raise PersonError(f"{name}: no flow has the number {self.flow_kind}", "use the names of FLOW_NAMES")
        if self.fair and self.kind != ATTRACTOR:
            raise PersonError(f"{name}: only attractors can be fair")

    @property
    def x(self) -> float:
        """Drawing position across the stage [m]."""
        return self.points[0][0]

    @property
    def z(self) -> float:
        """Drawing position towards the audience [m]."""
        return self.points[0][1]

    @property
    def table_kind(self) -> int:
        """Kind in the kernels' arrays; fair attractors are voices."""
        return PARTICIPANT if self.fair else self.kind

    @property
    def decay_length(self) -> float:
        """Decay length [m] of the fall-off."""
        return self.decay if self.decay is not None else DECAYS[self.kind]

    def table_row(self, separation: float, corners: int, outline: int) -> tuple[float, ...]:
        """Return the numbers of the element in the first columns of the element table, in their order.

        `separation` [m]: the field's default; `corners`, `outline`: numbers of vertices in the table, for dancers and
        in the picture.
        """
        usual = CROSSING_SEPARATION if self.kind == CROSSING else separation
        flock = self.kind == FLOCK
        return (
            self.start_beat,
            self.end_beat,
            self.table_kind,
            self.strength,
            corners,
            outline,
            self.closed and corners > 2,
            self.radius,
            self.decay_length,
            usual if self.separation is None else self.separation,
            self.alignment if flock else 0.0,
            self.cohesion if flock else 0.0,
            self.flow_kind,
            self.target,
            self.target_group,
            self.wedge,
            self.x,
            self.z,
        )

    def level(self, beat: float) -> float:
        """Return the fade level, 0 to 1, at `beat`."""
        into, left = beat - self.start_beat, self.end_beat - beat
        if into < 0.0 or left <= 0.0:
            return 0.0
        return float(min(column.fade_in_level(into / FADE_BEATS), left / FADE_BEATS))

    def faded_out(self, beat: float) -> "Element":
        """Return a copy that fades out from `beat` on, from its current level; unchanged if it ends sooner."""
        end = beat + self.level(beat) * FADE_BEATS
        if end >= self.end_beat:
            return self
        # the start moves back, so that the fade out continues from the level of an unfinished fade in
        return replace(self, start_beat=self.start_beat - FADE_BEATS, end_beat=end)


def line_length(points: Points) -> float:
    """Return the length [m] of a polyline."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def rectangle(x: float, z: float, width: float, depth: float) -> Points:
    """Return the corners of a rectangle around (x, z) [m], for a region (`closed`)."""
    a, b = width / 2.0, depth / 2.0
    return (x - a, z - b), (x + a, z - b), (x + a, z + b), (x - a, z + b)


__all__ = ["FADE_BEATS", "FLOCK", "Element", "Points", "line_length", "rectangle"]
