"""Show: the deterministic simulation core. It reads no clock, device or disk.

The same patch, library, seed and (tick, event) list give bit-identical states, live or replayed. An event that raises
is refused the same way by engine, warm standby, second machine and replay: its effects before the error remain, so all
reach the same state and the show continues.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import StageView
from live.clock.timeline import Moment, Timeline
from live.control.events.event import ControlEvent
from live.show.circuit_breakers import CircuitBreakers
from live.show.desk.refusals import Refusals
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.agents.crowd.agent_state import AgentState
    from live.clock.follower.manual_control import TrackerHint
    from live.clock.follower.timeline_follower import TimelineFollower
    from live.graph.motion_graph import MotionGraph
    from live.show.audience.audience import Audience
    from live.show.capture.capture_manager import CaptureManager
    from live.show.capture.gestures import Gestures
    from live.show.capture.seen_steps import SeenSteps
    from live.show.dancers.character_springs import CharacterSprings
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.expression import Expression
    from live.show.dancers.garments import Garments
    from live.show.dancers.step_requests import StepRequests
    from live.show.dancers.variation import Variation
    from live.show.desk.launcher import Launcher
    from live.show.desk.light_desk import LightDesk
    from live.show.frame import Frame
    from live.show.group.casting import Casting
    from live.show.group.group_motion import GroupMotion
    from live.show.patch.patch import Patch
    from live.show.patch.patch_update import PatchUpdates
    from live.show.score.music_reactions import Reactions
    from live.show.score.playhead import Playhead
    from live.show.score.score_runner import ScoreRunner
    from live.show.selection.interrupts import Interrupts
    from live.show.selection.scheduler import Scheduler
    from live.show.stages.hot_swap import HotSwap
    from live.show.stages.light_stage import LightStage
    from live.show.stages.show_clock import ShowClock
    from live.show.view.view_builder import ViewBuilder


@dataclass(eq=False)
class Show:
    """One show: its parts, as `live/show/assembly.py` has built them. Thread: the show's, unless a method says other.

    Call `apply` for events, then `tick` for each due tick, and `fill` for each frame.
    """

    seed: int
    breakers: CircuitBreakers
    """Circuit breakers of the stages of a tick."""
    refusals: Refusals
    clock: "ShowClock"
    casting: "Casting"
    reactions: "Reactions"
    score_runner: "ScoreRunner"
    motion: "GroupMotion"
    variation: "Variation"
    dancers: "Dancers"
    garments: "Garments"
    scheduler: "Scheduler"
    interrupts: "Interrupts"
    directions: "StepRequests"
    mocap: "CaptureManager"
    desk: "LightDesk"
    audience: "Audience"
    light: "LightStage"
    hot_swap: "HotSwap"
    view_builder: "ViewBuilder"
    expression: "Expression"
    launcher: "Launcher"
    springs: "CharacterSprings"
    seen_steps: "SeenSteps"
    gestures: "Gestures"
    frame: "Frame"
    """The stages, in their order."""

    # -- running -----------------------------------------------------------------------------------------------------

    def apply(self, event: ControlEvent) -> bool:
        """Apply an event, effective from the next tick. False, and counted, if it was refused."""
        return self.frame.input(event)

    def tick(self, time: float) -> bool:
        """Advance to the tick at `time` [s]; True if a measure line was crossed.

        After an exception the state is unusable; `breakers.running` is the stage that failed.
        """
        return self.frame.tick(time)

    def view(self) -> StageView:
        """Return an empty drawing snapshot of the right size, to be filled each frame."""
        return self.view_builder.view()

    def fill(self, view: StageView, time: float) -> None:
        """Fill the snapshot for `time` [s], at most a tick after the last one; poses are at the exact beat."""
        self.frame.view(view, time)

    def state_hash(self) -> str:
        """Return a short hash over every bit of the agents' and dancers' states and the poses of this tick."""
        return self.view_builder.state_hash(self.clock.now(self.state.position))

    # -- present -----------------------------------------------------------------------------------------------------

    @property
    def patch(self) -> "Patch":
        """The patch in force."""
        return self.hot_swap.patch

    @property
    def graph(self) -> "MotionGraph":
        """The motion graph in use."""
        return self.hot_swap.graph

    @property
    def patch_updates(self) -> "PatchUpdates":
        """The state of a patch reload."""
        return self.hot_swap.patch_updates

    @property
    def time(self) -> float:
        """Time of the last tick [s]."""
        return self.clock.time

    @property
    def follower(self) -> "TimelineFollower":
        """The follower of the music."""
        return self.clock.follower

    @property
    def timeline(self) -> Timeline:
        """Beats and measures over time."""
        return self.clock.timeline

    @property
    def span(self) -> MeasureSpan:
        """The current measure."""
        return self.clock.span

    @property
    def danced_beats(self) -> float:
        """Beats danced so far, see `ShowClock.danced_beats`."""
        return self.clock.danced_beats

    @property
    def playhead(self) -> "Playhead":
        """The position in the score."""
        return self.score_runner.playhead

    @property
    def group(self) -> npt.NDArray[np.int32]:
        """The group of each dancer, (A,)."""
        return self.casting.group

    @property
    def state(self) -> "AgentState":
        """The current agent state."""
        return self.motion.state

    @property
    def blackout(self) -> bool:
        """Whether the picture is or becomes black."""
        return self.light.blackout

    @property
    def brightness(self) -> float:
        """Brightness of the picture without the desk's master, 0 to 1."""
        return self.light.brightness

    def moment(self, time: float) -> Moment:
        """Return the musical time at `time` [s]."""
        return Moment.of(self.timeline, time, self.follower.confidence)

    def explain_choice(self) -> dict[str, Any] | None:
        """Explain the selected dancer's current step, see `StepChoices.why`; None if no dancer is selected."""
        asked = self.directions.explained_dancer
        return None if asked is None else self.scheduler.choices.explain(asked, self.scheduler.choosing)

    def seed_tracker(self, listener: Callable[["TrackerHint"], None]) -> None:
        """Send beat tracker seeds to `listener`, now and in future."""
        self.clock.seed_tracker(listener)


def apply_safely(show: Show, event: ControlEvent) -> bool | None:
    """Apply an event, effective from the next tick; False if it was refused, None if it raised."""
    try:
        return show.apply(event)
    except Exception as error:  # one failed event must not end the show
        show.refusals.add(f"{type(event).__name__} failed: {type(error).__name__}: {error}")
        return None
