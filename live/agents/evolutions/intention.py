"""Motion intentions (what a group does, stored once by name) and motion segments (who, when, how long) (T085-T087)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.facing import Facing, Orientation
from live.agents.evolutions.slot_assignment import Cost, Fill
from live.agents.evolutions.start_delays import TOGETHER, Ripple
from live.agents.groups.roster import Line
from live.base.errors import PersonError

EVEN_TURN: Final = Orientation()
"""Turn evenly from the first heading to the last."""
ALONG_PATH: Final = Orientation(Facing.TANGENT)
"""Face along the path."""
BY_MEASURES: Final = Orientation(Facing.MEASURES)
"""Face along the path, a heading for each measure."""


class FormationLike(Protocol):
    """The interface of a formation that evolutions need; `agents.formations` makes them."""

    @property
    def name(self) -> str: ...
    @property
    def slots(self) -> npt.NDArray[np.floating]: ...
    @property
    def heading(self) -> npt.NDArray[np.floating]: ...
    @property
    def marks(self) -> Sequence[str]: ...


@runtime_checkable
class FormationMaker(Protocol):
    """A formation whose places depend on the number of dancers."""

    @property
    def name(self) -> str: ...
    def places_for(self, count: int) -> FormationLike:
        """Return the places for `count` dancers."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """A formation given by its numbers."""

    name: str
    slots: npt.NDArray[np.floating]
    """Places (S, 2) [m]."""
    heading: npt.NDArray[np.floating]
    """Heading at each place (S,) [rad]."""
    marks: Sequence[str] = ()
    """A required attribute for each place ("": any dancer); may be empty."""


class AssignmentMethod(StrEnum):
    """How dancers are assigned to places."""

    COST = "cost"
    """Assignment of least cost."""
    ID = "id"
    """The first dancer of the group to the first place, and so on (T097)."""


class PathMode(StrEnum):
    """How paths of dancers who would collide are treated."""

    MENDED = "mended"
    """Straight; to avoid collisions, start times are changed, then paths are bent."""
    STRAIGHT = "straight"
    """Always straight: steering keeps dancers apart."""
    DIVIDED = "divided"
    """Straight; to avoid collisions, paths are bent by divide and conquer (T101)."""


@dataclass(frozen=True, slots=True)
class Matching:
    """How dancers are assigned to places (T097-T100)."""

    by: AssignmentMethod = AssignmentMethod.COST
    cost: Cost = Cost.SQUARED
    equal_weight: float = 0.5
    """Weight of equal path lengths against short ones in `Cost.BOTH`."""
    fill: Fill = Fill.NEAREST


@dataclass(frozen=True, slots=True)
class Hold:
    """Fixed condition: be in a formation (T095); dancers who are not there yet go there within the first measure."""

    formation: str
    matching: Matching = Matching()


@dataclass(frozen=True, slots=True)
class Evolve:
    """Boundary condition: go from where the last motion left the group into a formation (T096)."""

    formation: str
    matching: Matching = Matching()
    path_mode: PathMode = PathMode.MENDED
    orientation: Orientation = EVEN_TURN
    soft: float = 0.25
    """Share of the time used to accelerate, and to decelerate; 0: constant speed."""


@dataclass(frozen=True, slots=True)
class Pause:
    """Initial condition: keep the places in which the last motion ended (T103)."""


class FollowMode(StrEnum):
    """How a group follows a drawn path."""

    SHIFTED = "shifted"
    """Each dancer from their own place: the formation keeps its shape."""
    FILE = "file"
    """In single file, one after the other."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Initial condition: follow a drawn path (T103)."""

    path: str
    follow: FollowMode = FollowMode.SHIFTED
    gap: float = 0.8
    """Metres between two dancers in single file."""
    orientation: Orientation = ALONG_PATH
    soft: float = 0.25


@dataclass(frozen=True, slots=True)
class FollowWays:
    """Group motion as material: each dancer follows a way that was drawn or recorded (T145, T146)."""

    ways: str
    matching: Matching = Matching()
    orientation: Orientation = BY_MEASURES
    backwards: bool = False
    """From the ends of the ways to their starts."""


@dataclass(frozen=True, slots=True)
class Procedural:
    """Initial condition with evolution rules: elements move the group, no places are prescribed (T103, 4.4)."""

    marks: tuple[str, ...] = ()
    """Names of the elements, for storyboards; the elements define the motion."""


Intention = Hold | Evolve | Pause | Trajectory | FollowWays | Procedural


@dataclass(frozen=True, slots=True)
class Repertoire:
    """Formations, drawn paths and intentions by name; an edit reaches every segment that refers to them."""

    formations: Mapping[str, FormationLike | FormationMaker] = field(default_factory=dict)
    paths: Mapping[str, npt.NDArray[np.floating]] = field(default_factory=dict)
    """Polylines (N, 2) [m]."""
    intentions: Mapping[str, Intention] = field(default_factory=dict)
    ways: Mapping[str, npt.NDArray[np.floating]] = field(default_factory=dict)
    """Ways of a group as knots at even times (D, K, 2) [m]."""

    def with_formation(self, formation: FormationLike | FormationMaker) -> "Repertoire":
        """Return a copy with this formation added or replaced."""
        return replace(self, formations={**self.formations, formation.name: formation})

    def with_path(self, name: str, polyline: npt.ArrayLike) -> "Repertoire":
        """Return a copy with this drawn path added or replaced."""
        return replace(self, paths={**self.paths, name: np.asarray(polyline, np.float64)})

    def with_ways(self, name: str, ways: npt.NDArray[np.floating]) -> "Repertoire":
        """Return a copy with these ways of a group added or replaced."""
        return replace(self, ways={**self.ways, name: ways})

    def formation(self, name: str, count: int) -> FormationLike:
        """Return the formation of this name for `count` dancers, or raise a PersonError that lists the names."""
        if name not in self.formations:
            raise PersonError(f"no formation is called {name!r}", _there_are(self.formations))
        formation = self.formations[name]
        return formation.places_for(count) if isinstance(formation, FormationMaker) else formation

    def path(self, name: str) -> npt.NDArray[np.floating]:
        """Return the drawn path of this name, or raise a PersonError."""
        if name not in self.paths:
            raise PersonError(f"no path is called {name!r}", _there_are(self.paths))
        return self.paths[name]

    def ways_of(self, name: str) -> npt.NDArray[np.floating]:
        """Return the ways of this name, or raise a PersonError."""
        if name not in self.ways:
            raise PersonError(f"no evolution is called {name!r}", _there_are(self.ways))
        return self.ways[name]

    def intention(self, of: "str | Intention") -> Intention:
        """Return the intention of a segment. Raises PersonError if it or a name in it does not exist."""
        if isinstance(of, str):
            if of not in self.intentions:
                raise PersonError(f"no intention is called {of!r}", _there_are(self.intentions))
            of = self.intentions[of]
        if isinstance(of, Hold | Evolve):
            self.formation(of.formation, 1)
        if isinstance(of, Trajectory):
            self.path(of.path)
        if isinstance(of, FollowWays):
            self.ways_of(of.ways)
        return of


def _there_are(names: Mapping[str, object]) -> str:
    return f"there are: {', '.join(sorted(names))}" if names else "there are none yet"


@dataclass(frozen=True, slots=True)
class Segment:
    """One evolution of one group over some measures."""

    intention: str | Intention
    """A name in the repertoire, so that edits reach it, or an intention given directly."""
    group: str = ""
    """The dancers, as an expression of `groups.selection`; empty means all. Places are those at the start."""
    start: int = 0
    """Measure at whose line the segment begins, from 0."""
    measures: int = 1
    """Measures until all dancers have arrived."""
    ripple: Ripple = TOGETHER
    """Delays of the individual dancers' starts."""
    mirror: Line | None = None
    """Line about which the formation or path is mirrored."""
    delay: float = 0.0
    """Beats by which it begins and ends later than its measures (canon)."""

    def __post_init__(self) -> None:
        if self.measures < 1 or self.start < 0:
            raise PersonError(
                f"a segment of {self.measures} measures from measure {self.start + 1} on",
                "measures count from 1, and a segment lasts at least one",
            )
        if not 0.0 <= self.delay < 1e6:
            raise PersonError(f"a segment that begins {self.delay} beats later", "it can only be later, not earlier")

    def begin_beat(self, measure_beats: float) -> float:
        """Return the beat (from the first measure line) at which the segment begins."""
        return self.start * measure_beats + self.delay

    def end_beat(self, measure_beats: float) -> float:
        """Return the beat at which all dancers have arrived."""
        return (self.start + self.measures) * measure_beats + self.delay
