"""Quiet: whether nothing is played any more, or the music merely breathes.

Pauses: when music that can be heard no more has stopped, and when it only rests as it did before.
"""

from collections import deque
from typing import Final, Literal

SILENT_LEVEL: Final = 10.0 ** (-55.0 / 20.0)
"""Below this level (RMS, full scale = 1) nothing is played: -55 dB lies over the noise of a line input."""

BELOW_MUSIC: Final = 10.0 ** (-20.0 / 20.0)
"""So far below the music that was, a room hums or murmurs, unless beats are to be heard in it."""

RISE: Final = 2.0
FALL: Final = 0.06
"""How fast the level of the music is learned and forgotten [1/s]."""

BEATING: Final = 0.3
"""Chance of a beat that says that music is played, however softly."""

SILENT_AFTER: Final = 1.2
"""Seconds below `SILENT_LEVEL` that make a silence; clicks at 60 bpm are none."""

PAUSE: Final = 0.25
"""Seconds below it after which music without rests says nothing more about its beats."""

REST_RATIO: Final = 1.3
"""Rests may be this much longer than those before."""

REST_FADE: Final = 0.1
"""How fast rests are forgotten [1/s]."""


class Quiet:
    """Listens to the level and to the chance of a beat, frame by frame."""

    def __init__(self, hop: float) -> None:
        self._hop = hop
        self._rest = 0.0
        self._music = 0.0
        self.duration = 0.0
        """Seconds since something was to be heard."""
        self.heard = False
        """Whether anything was heard at all since the start."""

    def step(self, level: float, beat: float = 1.0) -> float:
        """Take the level of the next frame, and the chance of a beat in it.

        Returns the length [s] of the silence that it ends, 0 if it ends none.
        """
        audible = level >= SILENT_LEVEL and (level >= BELOW_MUSIC * self._music or beat >= BEATING)
        self._music += self._hop * (RISE if level > self._music else FALL) * (level - self._music)
        if not audible:
            self.duration += self._hop
            return 0.0
        ended, self.duration, self.heard = self.duration, 0.0, True
        self._rest *= 1.0 - REST_FADE * self._hop
        if ended <= 2.0 * SILENT_AFTER:
            self._rest = max(self._rest, ended)
        return ended

    @property
    def silent(self) -> bool:
        """Whether nothing was to be heard for the last `SILENT_AFTER` seconds."""
        return self.duration >= SILENT_AFTER

    @property
    def listening(self) -> bool:
        """Whether missing beats mean anything: not in a silence longer than the rests before."""
        return self.duration <= max(PAUSE, REST_RATIO * self._rest)


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
