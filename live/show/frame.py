"""One frame of a show, from top to bottom: input, then for each due tick clock, plan, group, crowd and dancers; view.

`live/show/engine.py` calls it: `Engine` writes each event of the frame to the journal and hands it to `input`, runs
`tick` for each tick due, and draws what `view` has filled in.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from live.base.stage_snapshot import StageView
from live.control.events.event import ControlEvent
from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion
    from live.show.stages.crowd_stage import CrowdStage, GroupStage
    from live.show.stages.dancers_stage import DancersStage
    from live.show.stages.event_router import EventRouter
    from live.show.stages.garments_stage import GarmentsStage
    from live.show.stages.light_stage import LightStage
    from live.show.stages.measure_lines import MeasureLines
    from live.show.stages.plan_stage import PlanStage
    from live.show.stages.show_clock import ShowClock
    from live.show.stages.springs_stage import SpringsStage
    from live.show.stages.tripped_stages import TrippedStages
    from live.show.view.view_builder import ViewBuilder


@dataclass(eq=False)
class Frame:
    """The stages of one show in their order. Thread: the show's.

    Each stage first checks its circuit breaker. If it is tripped, a fallback computes what later stages need, so the
    show continues whichever stage fails.
    """

    breakers: CircuitBreakers
    router: "EventRouter"
    clock: "ShowClock"
    measure_lines: "MeasureLines"
    plan: "PlanStage"
    group: "GroupStage"
    crowd: "CrowdStage"
    dancers: "DancersStage"
    springs: "SpringsStage"
    garments: "GarmentsStage"
    light: "LightStage"
    view_builder: "ViewBuilder"
    motion: "GroupMotion"
    tripped: "TrippedStages"

    def input(self, event: ControlEvent) -> bool:
        """Pass an event to its parts; False if it was refused."""
        return self.router.apply(event)

    def tick(self, time: float) -> bool:
        """Advance to the tick at `time` [s]; True if a measure line was crossed."""
        self.clock.time = time
        crossed = self._tick(time) if self.breakers.closed(Stage.TICK) else self._stand()
        self.breakers.leave()
        return crossed

    def _tick(self, time: float) -> bool:
        clock = self.clock
        clock.advance(time)
        crossed = self.measure_lines.cross()
        now = self._now()
        self.plan.tick(now, clock.beat)  # cues, fades, votes, score, edits, next steps, interrupts
        fraction = clock.fraction()
        self.group.tick(now)  # evolutions, elements and entrances write a command for each agent
        self.crowd.tick(now)  # agents follow them and avoid each other
        self.dancers.tick(self._now(), fraction)  # correction, steps, captured performers, partners
        self.springs.tick(self._now(), fraction)
        self.garments.tick(now, fraction)  # skirts, sleeves, ribbons and hair follow the bodies
        self.light.tick()
        return crossed

    def _now(self) -> Now:
        return self.clock.now(self.motion.state.position)

    def _stand(self) -> bool:
        """Run a tick without motion."""
        crossed = self.clock.stand()
        if crossed:
            self.tripped.drop_unfinished()
        return crossed

    def view(self, view: StageView, time: float) -> None:
        """Fill the drawing snapshot for `time` [s], at most a tick after the last one; poses are at the exact beat."""
        self.view_builder.fill(view, time, self._now())
