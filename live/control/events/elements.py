"""The event that places a procedural element (T105-T110, T132)."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent

Points = tuple[tuple[float, float], ...]
"""Points of the stage (x, z) [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceElement(ControlEvent):
    """Places an element of a kind of `live.base.element_kinds` for some measures."""

    kind: str
    points: Points = ((0.0, 0.0),)
    """Its place: a point, the two ends of a line, or a drawn line [m]."""
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    """The dancers: an expression as in `live.show.group.casting`."""
    next: bool = False
    """True: from the next measure line on."""
    radius: float = 0.0
    closed: bool = False
    flow: str = ""
    """The kind of flow."""
    whom: str = ""
    """Target of follow, pursue or evade: a dancer's number from 1, or a group."""
    fair: bool = False
    """One voice of an audience: dancers go to places with many voices; its strength counts as so many."""
    drag: bool = False
    """True: move the last one of the same source instead of adding another."""
