"""Record of where engines died, and the advice for the next engine so that it does not die there, too.

The supervisor reads the running tick and stage from the engine's shared memory, whatever ended it: an error, a signal,
a kill after a hang, or lack of memory.
"""

from collections import deque
from dataclasses import asdict, dataclass
from typing import Any, Final

from live.supervisor.restart_policy import RestartLimit

MAX_IN_A_ROW: Final = 3
"""Number of engines that end in one stage within `SECONDS`, in any tick, before it is put out of service."""
SECONDS: Final = 30.0
DRAWING: Final = 32
"""Number of `Stage.DRAWING`; all other numbers are stages of a tick."""


@dataclass(slots=True)
class DeathReport:
    """Advice for an engine that resumes, from the deaths of its predecessors."""

    tick: int = 0
    stage: int = 0
    """The stage that ran in that tick; 0: none."""
    times: int = 1
    """Number of engines in a row that ended there."""
    trip: bool = False
    """Whether the stage has ended so many engines, in any tick, that it is put out of service."""
    calm: bool = False
    """Whether devices, which run outside of ticks, are not used from now on (stage.md 4.7: three in thirty seconds)."""
    plain: bool = False
    """Whether pictures are drawn in the simplest way from now on."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return asdict(self)


class DeathHistory:
    """Records and judges the deaths of one show's engines. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.count = 0
        """Engines that have ended since the start."""
        self._outside = RestartLimit()
        self._last: tuple[int, int] | None = None
        self._times = 0
        self._stages: deque[tuple[float, int]] = deque(maxlen=MAX_IN_A_ROW - 1)
        self._calm = self._plain = False

    def record(self, now: float, tick: int, stage: int, *, blamed: bool = True) -> DeathReport:
        """Record that an engine ended at `now` [s] in `stage` of `tick`, outside of all ticks (0), or while drawing.

        Not `blamed`: it was killed on an overloaded machine and may only have been slow. That counts only if the next
        one is killed in the same stage of the same tick.
        """
        self.count += 1
        if not stage and blamed:
            self._calm = self._outside.record(now) or self._calm
        again = bool(stage) and blamed and self._ended_often(now, stage)
        self._plain = self._plain or (again and stage == DRAWING)
        if stage in (0, DRAWING):
            self._last, self._times = None, 0
            return DeathReport(tick, calm=self._calm, plain=self._plain)
        self._times = self._times + 1 if self._last == (tick, stage) else 1
        self._last = tick, stage
        return DeathReport(tick, stage, self._times, again, self._calm, self._plain)

    def _ended_often(self, now: float, stage: int) -> bool:
        before = [one for when, one in self._stages if now - when < SECONDS]
        self._stages.append((now, stage))
        return len(before) == MAX_IN_A_ROW - 1 and all(one == stage for one in before)
