"""Plan of a tick: what desk, audience, performers and score ask for, edits, and the choice of the next steps."""

from typing import TYPE_CHECKING

from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.calls import Calls
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.audience.audience import Audience
    from live.show.capture.gestures import Gestures
    from live.show.capture.seen_steps import SeenSteps
    from live.show.desk.light_desk import LightDesk
    from live.show.selection.interrupts import Interrupts
    from live.show.stages.hot_swap import HotSwap
    from live.show.stages.step_selection import StepSelection


class PlanStage:
    """Stages DESK, AUDIENCE, SCORE, EDITS, SELECTION and INTERRUPTS of one show; what performers ask for is CAPTURE."""

    def __init__(
        self,
        breakers: CircuitBreakers,
        calls: Calls,
        *,
        desk: "LightDesk",
        audience: "Audience",
        hot_swap: "HotSwap",
        gestures: "Gestures",
        selection: "StepSelection",
        interrupts: "Interrupts",
        seen_steps: "SeenSteps",
    ) -> None:
        self._seen_steps = seen_steps
        self._breakers, self._calls, self._desk, self._audience = breakers, calls, desk, audience
        self._gestures = gestures
        self._hot_swap, self._selection, self._interrupts = hot_swap, selection, interrupts

    def tick(self, now: Now, beat: float) -> None:
        """Plan for the tick at `beat`."""
        closed = self._breakers.closed
        if closed(Stage.DESK):
            self._desk.tick(now)
        if closed(Stage.AUDIENCE):
            self._audience.tick()
        if closed(Stage.CAPTURE):
            self._calls.issue(self._gestures.tick(now))
        self._calls.fire(now)
        if closed(Stage.EDITS):
            self._hot_swap.tick(now)
        if closed(Stage.CAPTURE):
            self._calls.issue(self._seen_steps.tick(now))
        self._selection.tick(now, beat)
        if closed(Stage.INTERRUPTS):
            self._interrupts.tick(now.span, now.timeline, now.time)
