"""ControlEvent: what all events have."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEvent:
    """One event: when it arrived (`time`, seconds of the show) and from where (`source`: "osc", "key", "audio" …)."""

    time: float
    source: str
