"""Events that place procedural elements."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class Attract(ControlEvent):
    """Dancers gather at (x, z) [m] for a number of measures (T105)."""

    x: float
    z: float
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    """The dancers: an expression as in `live.show.group.casting`."""
    next: bool = False
    """True: from the next measure line on."""
    drag: bool = False
    """True: move the last one of the same source instead of adding another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Repel(ControlEvent):
    """Dancers move away from (x, z) [m] for a number of measures (T105)."""

    x: float
    z: float
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    drag: bool = False
    """True: move the last one of the same source instead of adding another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread(ControlEvent):
    """Dancers spread over the stage for a number of measures (T109)."""

    measures: float = 4.0
    group: str = "*"
    next: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Voice(ControlEvent):
    """One voice of an audience, at (x, z) [m]; each source has one."""

    x: float
    z: float
    strength: float = 1.0
    """Above 1: counts as so many voices."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceElement(ControlEvent):
    """Places any element (T105-T110), see `live.agents.elements.element`."""

    kind: str
    points: str = ""
    """Its points, "x z, x z" [m]; empty if it needs none."""
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    radius: float = 0.0
    closed: bool = False
    flow: str = ""
    """The kind of flow."""
    whom: str = ""
    """Target of follow, pursue or evade: a dancer's number from 1, or a group."""
