"""Events that concern the machines of a show, not its dance.

Events of the patch: it was edited while the show runs.
"""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchChanged(ControlEvent):
    """The patch was edited: what the show makes of it acts from the next measure line on."""

    patch: str
    """The whole patch as JSON, or that compressed (`live.base.compression`): a replay needs no files."""
    version: str
    """A short hash of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsChanged(ControlEvent):
    """Files of steps were changed or taken away: from the next measure line on nobody begins what they were before.

    The clips themselves stand in the event, as they were and as they are: a replay does not ask the files.
    """

    gone: str
    """Names of the clips that are not begun any more, a line each."""
    was: str
    """They themselves, as text."""
    now: str
    """The clips that came, as text; empty if none did."""
    library: str
    """Hash of the library with them."""
