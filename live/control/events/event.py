"""Base class of all events."""

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEvent:
    """One event, with arrival `time` [s of the show] and `source` ("osc", "key", "audio" …)."""

    edits: ClassVar[str] = ""
    """What lasting state it edits, so that undo takes it back: "set", "scenes" …; empty: none."""

    time: float
    source: str
