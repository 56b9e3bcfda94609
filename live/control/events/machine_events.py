"""Events that concern the machines of a show, not its dance."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class TakeOver(ControlEvent):
    """A machine that stands by leads from now on; one that leads already does nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BreakerTripped(ControlEvent):
    """A stage of the tick ended in an error again and again: the show goes on without it."""

    name: str
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResetBreaker(ControlEvent):
    """A stage of the tick is put into service again; empty: all."""

    name: str = ""
