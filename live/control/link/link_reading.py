"""LinkReading: what a Link session says at one instant, in the show's seconds and in beats that dancers can dance."""

from dataclasses import dataclass

from live.clock.timeline import TEMPO_MAX_BPM


@dataclass(frozen=True, slots=True)
class LinkReading:
    """A session's tempo, beat and transport at `time`.

    Link allows up to 999 bpm. Beyond what a Timeline can run, every second beat (or every fourth …) is the beat, as
    Ableton's test plan asks (TEMPO-4); `fold` says how many of Link's beats one is.
    """

    time: float
    """Seconds of the show."""
    peers: int
    """Other participants of the session; 0: we are alone."""
    tempo: float
    """Folded beats per minute."""
    beat: float
    """Folded beats; modulo `beats_per_measure` it is what all participants share, the number of measures is our own."""
    beats_per_measure: int
    fold: int = 1
    playing: bool = False
    """The session's transport; it means something only where start/stop is shared."""
    since: float = 0.0
    """When the transport was last started or stopped [s]; it may lie ahead."""

    @property
    def period(self) -> float:
        """Seconds from beat to beat."""
        return 60.0 / self.tempo

    @property
    def phase(self) -> float:
        """Beats into the measure, in [0, beats_per_measure)."""
        return self.beat % self.beats_per_measure


def fold_of(tempo: float) -> int:
    """How many of Link's beats [bpm] one danced beat is: 1, 2 or 4."""
    fold = 1
    while tempo / fold > TEMPO_MAX_BPM:
        fold *= 2
    return fold


def apart(phase: float, other: float, quantum: float) -> float:
    """By how many beats `phase` is ahead of `other`, the short way round: in [-quantum / 2, quantum / 2)."""
    return (phase - other + 0.5 * quantum) % quantum - 0.5 * quantum
