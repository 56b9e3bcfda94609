"""LinkLead: what to tell a Link session so that it runs with the show, gently."""

from dataclasses import dataclass
from typing import Final

from live.clock.timeline import Timeline
from live.control.link.link_reading import LinkReading, apart

ALONE_PAUSE: Final = 0.25
"""Seconds between two changes of a session in which nobody else is."""

ALONE_ERROR: Final = 0.002
LED_ERROR: Final = 0.001
"""Seconds of phase that are left as they are: alone, and where others listen."""

SAME_TEMPO: Final = 2e-5
"""Relative: smaller changes of tempo are not worth a message (0.0024 bpm at 120)."""

BEND: Final = 0.03
"""How much faster or slower than the show the session may run to meet its beat: half a semitone."""

BEND_TIME: Final = 2.0
"""Seconds in which a small phase error is run in."""


@dataclass(frozen=True, slots=True)
class LinkChange:
    """What is committed to the session."""

    tempo: float
    """Beats per minute from now on."""
    phase: float | None = None
    """Beats into the measure that now is; None: the session's beat goes on as it is."""
    force: bool = False
    """Whether the others' beat jumps, too: only where a person has asked for it."""


class LinkLead:
    """Compares the session with the show's Timeline and decides on changes: one a beat at most.

    Alone, the session simply takes the show's tempo and phase, so that nothing jumps when somebody joins it
    (BEATTIME-2). With others it is *led*: the tempo is sent, and a phase error is run in by a tempo that is up to 3 %
    off. Only at `resync` (somebody chose to lead, or set the one) may the beat of all be moved at once, as Ableton's
    documentation of forceBeatAtTime asks. Pure. Thread: one at a time.
    """

    def __init__(self) -> None:
        self._next = 0.0
        self._force = False

    def resync(self) -> None:
        """A person asks for it: the next change may move everybody's beat."""
        self._force = True

    def change(self, reading: LinkReading, timeline: Timeline, tempo: float) -> LinkChange | None:
        """What to commit now, if anything; `tempo` is the music's [bpm], the timeline's own carries corrections."""
        if reading.time < self._next:
            return None
        wanted = timeline.phase_at(reading.time)
        behind = apart(wanted, reading.phase, reading.beats_per_measure) * 60.0 / tempo  # seconds that the session is
        change = (self._led if reading.peers else self._alone)(reading, tempo, wanted, behind)
        if change is not None:
            self._next = reading.time + (60.0 / tempo if reading.peers else ALONE_PAUSE)
        return change

    def _alone(self, reading: LinkReading, tempo: float, wanted: float, behind: float) -> LinkChange | None:
        if abs(behind) > ALONE_ERROR or reading.fold != 1:
            return LinkChange(tempo, wanted)
        return LinkChange(tempo) if _differ(tempo, reading.tempo) else None

    def _led(self, reading: LinkReading, tempo: float, wanted: float, behind: float) -> LinkChange | None:
        if self._force:
            self._force = False
            return LinkChange(tempo, wanted, force=True)
        if reading.fold != 1:  # somebody races: first back to a tempo in which beats can be compared
            return LinkChange(tempo)
        bend = 0.0 if abs(behind) <= LED_ERROR else min(max(behind / BEND_TIME, -BEND), BEND)
        asked = tempo * (1.0 + bend)
        return LinkChange(asked) if _differ(asked, reading.tempo) else None


def _differ(tempo: float, other: float) -> bool:
    return abs(tempo - other) > SAME_TEMPO * other
