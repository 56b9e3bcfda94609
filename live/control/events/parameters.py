"""The event of all parameters."""

from dataclasses import dataclass
from typing import ClassVar

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class SetParameter(ControlEvent):
    """Sets a parameter, or fades it to a value; its row (`live.base.parameter`) says what is allowed."""

    edits: ClassVar[str] = "parameters"
    address: str
    value: tuple[float, ...]
    """Its numbers: one, or three of a colour or place."""
    group: str = "*"
    """The group, for parameters that each group has."""
    measures: float = 0.0
    """How long it takes."""
