"""Events of the patch: it was edited while the show runs."""

from dataclasses import dataclass

from live.control.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchChanged(ControlEvent):
    """The patch was edited: what the show makes of it acts from the next measure line on."""

    patch: str
    """The whole patch as JSON, or that compressed (`live.base.packed`): a replay needs no files."""
    version: str
    """A short hash of it."""
