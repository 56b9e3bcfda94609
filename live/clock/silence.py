"""Silence detection: for a tracker frame by frame, and for tempo following as sound, pause or silence."""

from collections import deque
from typing import Final, Literal

SILENT_LEVEL: Final = 10.0 ** (-55.0 / 20.0)
"""Below this level (RMS, full scale = 1) there is no music: -55 dB lies above the noise of a line input."""

BELOW_MUSIC: Final = 10.0 ** (-20.0 / 20.0)
"""Sound this far below the music before counts as room noise, unless it contains beats."""

RISE: Final = 2.0
FALL: Final = 0.06
"""Rates at which the music's level is raised and lowered [1/s]."""

BEAT_THRESHOLD: Final = 0.3
"""Beat probability above which there is music, however soft."""

SILENT_AFTER: Final = 1.2
"""Seconds below `SILENT_LEVEL` that count as silence; gaps between clicks at 60 bpm do not."""

PAUSE: Final = 0.25
"""Seconds below it after which missing beats carry no information, if the music had no rests before."""

REST_RATIO: Final = 1.3
"""Rests may be longer than those before by this factor."""

REST_FADE: Final = 0.1
"""Rate at which rests are forgotten [1/s]."""


class SilenceDetector:
    """Detects silence from level and beat probability, frame by frame."""

    def __init__(self, hop: float) -> None:
        self._hop = hop
        self._rest = 0.0
        self._music = 0.0
        self.duration = 0.0
        """Seconds since the last audible frame."""
        self.has_sound = False
        """Whether any frame was audible since the start."""

    def step(self, level: float, beat: float = 1.0) -> float:
        """Process the next frame's level and beat probability.

        Return the length [s] of the silence that this frame ends; 0 if none.
        """
        audible = level >= SILENT_LEVEL and (level >= BELOW_MUSIC * self._music or beat >= BEAT_THRESHOLD)
        self._music += self._hop * (RISE if level > self._music else FALL) * (level - self._music)
        if not audible:
            self.duration += self._hop
            return 0.0
        ended, self.duration, self.has_sound = self.duration, 0.0, True
        self._rest *= 1.0 - REST_FADE * self._hop
        if ended <= 2.0 * SILENT_AFTER:
            self._rest = max(self._rest, ended)
        return ended

    @property
    def silent(self) -> bool:
        """Whether the last `SILENT_AFTER` seconds were silent."""
        return self.duration >= SILENT_AFTER

    @property
    def expects_beats(self) -> bool:
        """Whether missing beats carry information: not in a silence longer than the rests before."""
        return self.duration <= max(PAUSE, REST_RATIO * self._rest)


SoundState = Literal["sound", "pause", "silence"]
"""sound: music plays, or rests as usual; pause: a longer rest, undecided yet; silence: the music has ended."""

PAUSE_AFTER: Final = 0.8
"""Seconds below `SILENT_LEVEL` that count as a pause: music is reported lost within a second of its end."""

SILENCE_AFTER: Final = 1.2
"""Seconds that count as silence."""

REST_TOLERANCE: Final = 1.25
"""Recurring rests may be longer than usual by this factor (a click at 40 bpm rests 1.5 s)."""

LONGEST_REST: Final = 2.4
"""A longer gap [s] is not a rest within music."""

USUAL_COUNT: Final = 3
REST_MEMORY: Final = 12.0
"""A rest length is usual if this many as long, or longer, ended within this time [s]."""


class PauseDetector:
    """Detects pauses and silence from the level of successive blocks."""

    def __init__(self) -> None:
        self._rests: deque[tuple[float, float]] = deque(maxlen=64)
        self._since: float | None = None
        self._usual = 0.0
        self.state: SoundState = "sound"
        """The present state; "sound" until the first silence."""

    def step(self, level: float, position: float) -> SoundState:
        """Process the level (RMS, full scale = 1) of the audio up to `position` [s, never less than before]."""
        if level >= SILENT_LEVEL:
            if self._since is not None:
                self._rests.append((position - self._since, position))
            self._since, self.state = None, "sound"
            return self.state
        if self._since is None:
            self._since, self._usual = position, self._usual_rest(position)
        still = position - self._since
        longest = REST_TOLERANCE * self._usual
        if still >= max(SILENCE_AFTER, longest + SILENCE_AFTER - PAUSE_AFTER):
            self.state = "silence"
        elif still >= max(PAUSE_AFTER, longest):
            self.state = "pause"
        return self.state

    def _usual_rest(self, position: float) -> float:
        """Return the usual length of recent rests [s]; 0 if there were none."""
        lately = [rest for rest, end in self._rests if rest <= LONGEST_REST and end > position - REST_MEMORY]
        return sorted(lately)[-USUAL_COUNT] if len(lately) >= USUAL_COUNT else 0.0
