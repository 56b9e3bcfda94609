"""Events of formations, groups, entrances and exits, and objects on the stage."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class Evolve(ControlEvent):
    """Dancers go to a formation within some measures (T096)."""

    formation: str
    """A name in the patch, or a description (`live.agents.formations.formation_notation`)."""
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    match: str = "squared"
    """Assignment of dancers to places (T097-T100)."""
    ripple: float = 0.0
    """Beats from the first dancer's start to the last one's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DefineFormation(ControlEvent):
    """A named formation is defined or changed, with every use of it (T087)."""

    name: str
    formation: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Travel(ControlEvent):
    """Dancers travel along a drawn line (T103)."""

    points: str
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    single_file: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Pause(ControlEvent):
    """Dancers stay where they are for some measures (T103)."""

    measures: float = 4.0
    group: str = "*"
    next: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Release(ControlEvent):
    """Dancers leave their formation and evolution."""

    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Regroup(ControlEvent):
    """Dancers dance with another group from their next measure on (T104)."""

    dancers: str
    group: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRipple(ControlEvent):
    """Sets a delay that runs over a group (T051)."""

    beats: float
    """Delay from the first dancer to the last; 0: none."""
    begins: str = "left"
    """Where it starts: a side of the stage, `centre`, or x z [m]."""
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Enter(ControlEvent):
    """Dancers waiting in the wings enter at the next measure line."""

    count: float = 1.0
    group: str = "*"
    gate: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Leave(ControlEvent):
    """Dancers leave the stage through a gate."""

    dancers: str
    gate: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceObstacle(ControlEvent):
    """Places a round obstacle at (x, z) with `radius` [m]."""

    name: str
    x: float
    z: float
    radius: float = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceWall(ControlEvent):
    """Places a wall from (x, z) to (x2, z2) [m]."""

    name: str
    x: float
    z: float
    x2: float
    z2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RemoveObstacle(ControlEvent):
    """Removes the obstacle or wall of this name."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SetStage(ControlEvent):
    """Resizes the stage to `width` by `depth` [m]; dancers outside come in."""

    width: float
    depth: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Performer(ControlEvent):
    """Position (x, z) [m] of a real dancer."""

    name: str
    x: float
    z: float
