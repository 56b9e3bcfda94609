"""Choice of the next measure of all dancers, with a simpler choice while the scheduler is out of service."""

from typing import TYPE_CHECKING

from live.show.circuit_breakers import FALLBACK, CircuitBreakers, Stage
from live.show.selection.nearest_steps import repeat_measure
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.stage_area import StageArea
    from live.show.selection.scheduler import Scheduler


class StepSelection:
    """Step selection of one show; stage SELECTION. Thread: the show's."""

    def __init__(
        self, breakers: CircuitBreakers, scheduler: "Scheduler", dancers: "Dancers", stage_area: "StageArea"
    ) -> None:
        self._breakers, self._scheduler, self._dancers, self._stage_area = breakers, scheduler, dancers, stage_area

    def tick(self, now: Now, beat: float) -> None:
        """Do the share of the tick at `beat`."""
        level = self._breakers.enter(Stage.SELECTION)
        if not level:
            self._scheduler.work(now.span, now.timeline, now.time)
        elif level == FALLBACK and self._scheduler.must_decide(now.span, beat):
            self._scheduler.decide_nearest(self._stage_area.half)

    def decide(self, now: Now) -> None:
        """Choose all next measures at once, because the measure line is reached."""
        level = self._breakers.enter(Stage.SELECTION)
        if not level:
            self._scheduler.decide(now.span, now.timeline, now.time)
        elif level == FALLBACK:
            self._scheduler.decide_nearest(self._stage_area.half)
        else:
            repeat_measure(self._dancers)
