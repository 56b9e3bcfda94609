"""Events about formations, groups, who comes and goes, and what stands on the stage."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class Evolve(ControlEvent):
    """Dancers go to a formation within some measures (T096)."""

    formation: str
    """A name in the patch, or words (`live.agents.formations.formation_notation`)."""
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    match: str = "squared"
    """Who goes where (T097-T100)."""
    ripple: float = 0.0
    """Beats from the first who starts to the last."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DefineFormation(ControlEvent):
    """A formation by name is made or changed; every use of it changes with it (T087)."""

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
    """Dancers leave what a formation or evolution asks of them."""

    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Regroup(ControlEvent):
    """Dancers dance with another group from their next measure on (T104)."""

    dancers: str
    group: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRipple(ControlEvent):
    """A delay runs over a group from now on (T051)."""

    beats: float
    """From the first dancer to the last; 0: nobody is late any more."""
    begins: str = "left"
    """Where: a side of the stage, `centre`, or x z [m]."""
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Enter(ControlEvent):
    """Dancers who wait in the wings come at the next measure line."""

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
    """Something round stands at (x, z) [m], `radius` [m] wide around it."""

    name: str
    x: float
    z: float
    radius: float = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceWall(ControlEvent):
    """A wall stands from (x, z) to (x2, z2) [m]."""

    name: str
    x: float
    z: float
    x2: float
    z2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RemoveObstacle(ControlEvent):
    """The obstacle or wall of this name is gone."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SetStage(ControlEvent):
    """The stage becomes `width` by `depth` [m]: dancers outside come in."""

    width: float
    depth: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Performer(ControlEvent):
    """A real dancer is at (x, z) [m]."""

    name: str
    x: float
    z: float
