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
    """Who: words as in `live.show.group.casting`."""
    next: bool = False
    """True: from the next measure line on."""
    drag: bool = False
    """True if this moves the one that the same source set last, instead of adding another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Repel(ControlEvent):
    """Dancers leave the surroundings of (x, z) [m] for a number of measures (T105)."""

    x: float
    z: float
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    drag: bool = False
    """True if this moves the one that the same source set last, instead of adding another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread(ControlEvent):
    """Dancers spread over the stage for a number of measures (T109)."""

    measures: float = 4.0
    group: str = "*"
    next: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Voice(ControlEvent):
    """One voice of an audience, at (x, z) [m]; every source has one."""

    x: float
    z: float
    strength: float = 1.0
    """Above 1: as many voices."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceElement(ControlEvent):
    """Any element (T105-T110): see `live.agents.elements.element`."""

    kind: str
    points: str = ""
    """Its points, "x z, x z" [m]; empty where it needs none."""
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    next: bool = False
    radius: float = 0.0
    closed: bool = False
    flow: str = ""
    """Kind of a flow."""
    whom: str = ""
    """Whom it follows, pursues or evades: a dancer's number from 1, or a group."""
