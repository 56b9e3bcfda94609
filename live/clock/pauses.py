"""Pauses: when music that can be heard no more has stopped, and when it only rests as it did before."""

from collections import deque
from typing import Final, Literal

from live.clock.quiet import SILENT_LEVEL

Hearing = Literal["sound", "pause", "silence"]
"""sound: it plays, or rests as usual; pause: longer than that, nobody knows yet; silence: what comes next is new."""

PAUSE_AFTER: Final = 0.8
"""Seconds below `SILENT_LEVEL` that make a pause: within a second of its end music counts as lost."""

SILENCE_AFTER: Final = 1.2
"""Seconds that make a silence."""

LONGER: Final = 1.25
"""Rests that come again and again may be so many times as long as they were (a click at 40 bpm rests 1.5 s)."""

LONGEST_REST: Final = 2.4
"""What is longer [s] is no rest of music that plays."""

USUAL: Final = 3
REMEMBERED: Final = 12.0
"""A rest is usual if so many as long, or longer, ended within this time [s]."""


class Pauses:
    """Told the level of what is heard, piece by piece."""

    def __init__(self) -> None:
        self._rests: deque[tuple[float, float]] = deque(maxlen=64)
        self._since: float | None = None
        self._usual = 0.0
        self.state: Hearing = "sound"
        """How it is now; "sound" until the first silence, as nobody has waited before."""

    def step(self, level: float, position: float) -> Hearing:
        """`level` (RMS, full scale = 1) of what was heard up to `position` [s, never less than before]."""
        if level >= SILENT_LEVEL:
            if self._since is not None:
                self._rests.append((position - self._since, position))
            self._since, self.state = None, "sound"
            return self.state
        if self._since is None:
            self._since, self._usual = position, self._usual_rest(position)
        still = position - self._since
        longest = LONGER * self._usual
        if still >= max(SILENCE_AFTER, longest + SILENCE_AFTER - PAUSE_AFTER):
            self.state = "silence"
        elif still >= max(PAUSE_AFTER, longest):
            self.state = "pause"
        return self.state

    def _usual_rest(self, position: float) -> float:
        """How long rests usually were lately [s]; 0 where there were none."""
        lately = [rest for rest, end in self._rests if rest <= LONGEST_REST and end > position - REMEMBERED]
        return sorted(lately)[-USUAL] if len(lately) >= USUAL else 0.0
