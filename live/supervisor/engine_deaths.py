"""Deaths: where engines ended, and what the next one is told so that it does not end there, too.

The supervisor sees the tick and the stage that ran in the engine's page of shared memory, however it ended: by an
error, a signal, a hang that was ended, or for want of memory. It needs no array for that.
"""

from collections import deque
from dataclasses import asdict, dataclass
from typing import Any, Final

from live.supervisor.restart_policy import RestartLimit

IN_A_ROW: Final = 3
"""So many engines that ended in one stage within `SECONDS` put it out of service, in whatever ticks that was."""
SECONDS: Final = 30.0
DRAWING: Final = 32
"""The number of `Stage.DRAWING`; those below are stages of a tick, as are those above."""


@dataclass(slots=True)
class Lesson:
    """What an engine that goes on is told of the ones before it."""

    tick: int = 0
    stage: int = 0
    """The stage of that tick which ran; 0: none."""
    times: int = 1
    """So many engines in a row ended there."""
    trip: bool = False
    """Whether the stage has ended so many, in whatever ticks, that it is put out of service."""
    calm: bool = False
    """Whether devices, of which no tick knows, are left alone from now on (stage.md 4.7: three in thirty seconds)."""
    plain: bool = False
    """Whether pictures are drawn as simply as can be from now on."""

    def told(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)


class Deaths:
    """Judges the ends of one show's engines. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.count = 0
        """Engines that ended, since the start."""
        self._outside = RestartLimit()
        self._last: tuple[int, int] | None = None
        self._times = 0
        self._stages: deque[tuple[float, int]] = deque(maxlen=IN_A_ROW - 1)
        self._calm = self._plain = False

    def note(self, now: float, tick: int, stage: int, *, blamed: bool = True) -> Lesson:
        """An engine ended at `now` [s] in `stage` of `tick`, or outside of all ticks (0), or drawing.

        Not `blamed`: it was ended on an overloaded machine, and may only have been slow. That counts for nothing, but
        where the next one is ended in the same stage of the same tick, too.
        """
        self.count += 1
        if not stage and blamed:
            self._calm = self._outside.note(now) or self._calm
        again = bool(stage) and blamed and self._ended_often(now, stage)
        self._plain = self._plain or (again and stage == DRAWING)
        if stage in (0, DRAWING):
            self._last, self._times = None, 0
            return Lesson(tick, calm=self._calm, plain=self._plain)
        self._times = self._times + 1 if self._last == (tick, stage) else 1
        self._last = tick, stage
        return Lesson(tick, stage, self._times, again, self._calm, self._plain)

    def _ended_often(self, now: float, stage: int) -> bool:
        before = [one for when, one in self._stages if now - when < SECONDS]
        self._stages.append((now, stage))
        return len(before) == IN_A_ROW - 1 and all(one == stage for one in before)
