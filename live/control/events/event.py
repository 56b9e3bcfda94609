"""Base class of all events."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEvent:
    """One event, with arrival `time` [s of the show] and `source` ("osc", "key", "audio" …)."""

    time: float
    source: str
