"""The present of a show, as parts see it that handle an event or act at a tick."""

from dataclasses import dataclass

from live.base.arrays import Float32
from live.clock.timeline import Timeline
from live.show.stages.measure_span import MeasureSpan


@dataclass(slots=True, eq=False)
class Now:
    """The present of a show: the input of parts that handle an event, or act at a tick. It is never changed.

    It is made in each tick and for each event, and a frozen dataclass takes four times as long.
    """

    time: float
    """Time of the last tick [s]."""
    timeline: Timeline
    span: MeasureSpan
    """The current measure."""
    measure_beats: int
    """Beats of a danced measure; the timeline's may differ for a while."""
    position: Float32
    """Positions of the agents [m], (A, 2)."""

    @property
    def beat(self) -> float:
        """The beat of the timeline."""
        return self.timeline.beat_at(self.time)

    @property
    def danced_beats(self) -> float:
        """Beats danced so far: (measure number + fraction) times beats per measure."""
        return self.danced_beats_at(self.time)

    def danced_beats_at(self, time: float) -> float:
        """Return the beats danced at `time` [s]."""
        return self.span.danced_beats(self.timeline.beat_at(time), self.measure_beats)
