"""Events of the machines of a show, and of edits of patch and step files while it runs."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class TakeOver(ControlEvent):
    """A standby machine becomes the leader; no effect on a leader."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BreakerTripped(ControlEvent):
    """A stage of the tick failed repeatedly and is disabled."""

    name: str
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResetBreaker(ControlEvent):
    """A disabled stage of the tick is enabled again; empty: all."""

    name: str = ""


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
