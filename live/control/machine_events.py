"""Events that concern the machines of a show, not its dance."""

from dataclasses import dataclass

from live.control.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class TakeOver(ControlEvent):
    """A machine that stands by leads from now on; one that leads already does nothing."""
