"""Commands of the machines of a show, queries, and edits of patch and step files while it runs."""

from dataclasses import dataclass
from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument, Query

Port = Annotated[int, Argument.number("your receiving port; 0: the port that you send from", 0, 65535)]


@command("/dance/takeover", "operator")
class TakeOver(ControlEvent):
    """For a standby machine (`live play --standby`): it becomes the leader, and the old leader goes dark."""


@command("/dance/breaker/reset", "operator")
class ResetBreaker(ControlEvent):
    """Re-enables a stage of the show that was disabled because it failed repeatedly."""

    name: Annotated[str, Argument.label("its name in the overlay and the status; left out: all")] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class BreakerTripped(ControlEvent):
    """A stage of the tick failed repeatedly and is disabled."""

    name: str
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchChanged(ControlEvent):
    """The patch was edited; the change takes effect at the next measure line."""

    patch: str
    """The whole patch as JSON, possibly compressed (`live.base.compression`), so that a replay needs no files."""
    version: str
    """Short hash of the patch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsChanged(ControlEvent):
    """Step files were changed or removed; from the next measure line on their old clips are not started any more.

    The event contains the old and new clips, so that a replay does not need the files.
    """

    gone: str
    """Names of the clips that are not started any more, one per line."""
    was: str
    """Those clips as text."""
    now: str
    """The new clips as text; empty if there are none."""
    library: str
    """Hash of the library with them."""
    at_once: bool = False
    """Whether the steps can be chosen already for the next measure, if it is not decided."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExamplesChanged(ControlEvent):
    """Files of pairs of partners were edited; from the next measure line on followers dance from them.

    The event contains the files, so that a replay needs the recordings only.
    """

    was: str
    """What each edited file held, by its name in the patch, as JSON, possibly compressed."""
    now: str
    """What each holds now, likewise."""
    bank: str
    """Hash of all examples with them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TicksSkipped(ControlEvent):
    """Number of ticks left out because the machine stalled."""

    count: int


@command("/dance/ping", "audience")
class Ping(Query):
    """Answers /dance/pong, to the sender only; changes nothing."""


@command("/dance/get", "audience")
class Get(Query):
    """Answers with the message that would set the current value, to the sender only."""

    address: Annotated[str, Argument.text("a control with a current value, a figure under /dance/status, or a pattern")]


@command("/dance/subscribe", "musician")
class Subscribe(Query):
    """Sends you the current values, and then each that changes, unless you set it."""

    address: Annotated[str, Argument.text("all values at and under this address")] = "/dance"
    seconds: Annotated[float, Argument.number("duration; renew it in time", 1, 3600, "s")] = 60.0
    port: Port = 0


@command("/dance/unsubscribe", "musician")
class Unsubscribe(Query):
    """Ends the subscription."""

    port: Port = 0
