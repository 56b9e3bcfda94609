"""Pickup: soft take-over: a fader does nothing until it comes to the value that is there, so that nothing jumps."""

from dataclasses import dataclass
from typing import Final

OWN: Final = 1.0
"""Seconds in which a value that was set may be on its way there: until then nobody else is thought to have set it."""
CLOSE: Final = 2.0
"""Steps of the fader by which a value may differ and be the same."""


@dataclass(slots=True)
class Pickup:
    """One fader and the value that it sets; all as places of the fader, 0 to 1. Thread: one at a time."""

    held: bool = False
    """Whether the fader has the value."""
    sent: float = 0.0
    at: float = 0.0
    """What it set last, and when [s]."""
    begun: float = 0.0
    """The value when that was set: a value that fades is between the two."""
    before: float | None = None
    """Where the fader was last."""

    def takes(self, share: float, present: float, step: float, time: float, *, fades: bool = False) -> bool:
        """Whether the fader, which is at `share` now, sets the value, which is `present`; to be told if it does.

        `fades`: what it sets takes a while to come.
        """
        before, self.before = self.before, share
        near = CLOSE * step
        if self.held and time - self.at > OWN:
            low, high = sorted((self.begun, self.sent)) if fades else (self.sent, self.sent)
            self.held = low - near <= present <= high + near
        if not self.held:
            crossed = before is not None and min(before, share) <= present <= max(before, share)
            self.held = crossed or abs(share - present) <= near
        if self.held:
            self.sent, self.at, self.begun = share, time, present
        return self.held
