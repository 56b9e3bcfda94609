"""Motion of the agents that lead the dancers of a show (T080).

In each tick, an agent's command comes from the running evolution (`agents/evolutions`), is modified by elements
(`agents/elements`), and is made collision-free by the crowd step (`agents/crowd`). Steps and poses play no part here.
"""

from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import LEASH, LONG_LEASH, AgentCommand
from live.agents.agent_command_kernels import hold_on_leash
from live.agents.crowd.agent_state import AgentModel, AgentState
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.entrances.entrances import ENTERING, ON, WAITING, Entrances
from live.agents.entrances.gate import Gate
from live.agents.prediction import CrowdPrediction
from live.agents.separation.path_separation import PlaceSeparation
from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.show.capture.stage_presence import Performers
from live.show.dancers.partners import PairSteering, Partners
from live.show.group.casting import Casting
from live.show.group.elements import Elements
from live.show.group.evolutions import Evolutions
from live.show.group.stage_area import StageArea, gates_of, place_item, show_set, steering_of, update_set
from live.show.partner.partner_agents import PartnerAgents
from live.show.patch.patch import Patch
from live.show.score.score import Score
from live.show.selection.lookahead import RELEASE_INFLUENCE, AgentLookAhead
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.partner.partner_response import PartnerResponse


EDGE_MARGIN = 0.3
"""Least distance of starting places from the edge of the stage [m]."""


def starting_places(
    evolutions: Evolutions,
    partners: Partners,
    separation: PlaceSeparation,
    gate: Gate,
    on: Bool,
    half: Float32,
    heading: Float64,
) -> Float32:
    """Return starting places [m], (A, 2), and write headings [rad] to `heading` (A,).

    Dancers who are `on` (A,) the stage, of half sizes `half` (2,) [m], stand in their formations. The others come last
    and wait behind `gate`. Partners stand at arm's length.
    """
    count = len(on)
    placed = evolutions.starting_places()
    position = np.zeros((count, 2), np.float32)
    position[: len(placed)] = placed
    position[len(placed) :] = gate.waiting_places(count - len(placed))
    edge = half - np.float32(EDGE_MARGIN)
    partners.form_pairs(on)
    partners.place_pairs(position, heading)
    position[on] = np.clip(position[on], -edge, edge)
    wanted = position.copy()
    for _ in range(8):  # formations of two groups may lie on each other
        separation(position, wanted, float(edge.max()))
        position[on] = np.clip(position[on], -edge, edge)
        partners.gather(position, heading)
    position[~on] = wanted[~on]
    return position


Rows = npt.NDArray[np.intp]

AGENT_RADIUS: Final = 0.25
MIN_DANCER_DISTANCE: Final = 0.7
"""Least distance of two dancers at the end of a measure [m]: a bit more than shoulder width."""
MAX_SPEED_FACTOR: Final = 1.6
"""Factor by which agents in an evolution may exceed the steps' mean speed, as they accelerate and brake."""
STANDING_SEPARATION: Final = 0.9
"""Distance under which standing dancers make room for each other [m]."""


class GroupMotion:
    """The agents of one show. `begin_measure` is called at measure lines, `command` and `advance` in every tick."""

    def __init__(self, patch: Patch, casting: Casting, *, seed: int, score: Score | None = None) -> None:
        """Place all dancers in their groups' formations. Raises PersonError for a formation that is impossible."""
        count = len(casting.group)
        half = (patch.stage.width / 2, patch.stage.depth / 2)
        self._patch, self.casting = patch, casting
        self._seed = seed
        self._beats = patch.clock.beats_per_measure  # of a danced measure in plans, whatever the metre becomes live
        steering = steering_of(patch)
        radius = np.array([section.radius for section in patch.group], np.float32)[casting.group]
        responsibility = np.where(casting.soloists, 0.0, 1.0).astype(np.float32)
        self.model = AgentModel(radius, responsibility, steering, seed)
        self.stage_area = StageArea(patch.stage)
        self.gates = gates_of(patch, *half)
        self.entrances = Entrances(count, patch.dancer_count, self.gates, half)
        self.surroundings = Surroundings()
        self.performers = Performers(self.surroundings, AGENT_RADIUS)
        for item in patch.obstacle:
            place_item(self.surroundings, item)
        self.separation = PlaceSeparation(count, MIN_DANCER_DISTANCE, half_width=half[0], half_depth=half[1], seed=seed)
        score = score or Score(patch)
        self.evolutions = Evolutions(patch, casting, radius=radius, seed=seed, score=score)
        self.elements = Elements(patch, casting, seed=seed, score=score)
        self.partners = Partners(patch, casting)
        self.starting_heading: Float64 = np.zeros(count)
        """Headings at the beginning of the show [rad], shape (A,)."""
        places = starting_places(
            self.evolutions, self.partners, self.separation, self.gates[0], self.entrances.present,
            np.array(half, np.float32), self.starting_heading,
        )  # fmt: skip
        self.state = AgentState.at_rest(places)
        self._spare = AgentState.at_rest(self.state.position)
        self._advance = PairSteering(CrowdStepper(self.model), self.partners)
        self.commands = AgentCommand(count)
        self._partner_agents = PartnerAgents(self.model.radius, AGENT_RADIUS)
        look = CrowdPrediction(count, self._advance, self.surroundings, self._compute_commands_ahead)
        self._ahead = AgentLookAhead(
            look, self.evolutions, self.elements, self.entrances, self.stage_area, count, self._beats
        )
        self._now: tuple[Timeline, MeasureSpan] | None = None
        self._speed: Float32 = np.zeros(count, np.float32)
        self._leash: Float32 = np.zeros(count, np.float32)

    def begin_measure(self, span: MeasureSpan, beat: float, timeline: Timeline, heading: Float64) -> Rows:
        """Begin the measure `span` at `beat`; dancers face `heading` (A,) [rad].

        Returns the dancers who enter the stage with it. Their agents stand at the gates now.
        """
        self._now = (timeline, span)
        entered = self.entrances.cross_measure_line(self.state.position)
        self.partners.form_pairs(self.entrances.state == ON)
        if len(entered):
            self.state.velocity[entered] = 0.0
        self.elements.begin_measure(span.number, beat, timeline.beats_per_measure, self.state.position)
        self.evolutions.begin_measure(span.number, self.state.position, heading, self.entrances.staying)
        return entered

    def follow_partner_response(self, partner_response: "PartnerResponse | None", shown: Float32) -> None:
        """Move the agents of dancers in a partner response to where they are `shown` (A, 2) [m], so that others avoid
        them, but not so near to their leaders that these avoid them too."""
        self._partner_agents.follow_partner_response(partner_response, shown, self.state)

    @property
    def on_stage(self) -> Bool:
        """Whether each dancer is on the stage, shape (A,)."""
        return np.asarray(self.entrances.state == ON)

    @property
    def present(self) -> Bool:
        """Whether each dancer is visible, shape (A,)."""
        return self.entrances.present

    def group_states(self) -> Int32:
        """Return 0 for each dancer who is not visible, else the number of their group, from 1, shape (A,)."""
        return np.where(self.present, self.casting.group + 1, 0).astype(np.int32)

    # -- time ----------------------------------------------------------------------------------------------------

    def command(self, time: float, timeline: Timeline, span: MeasureSpan, *, speed: Float32) -> None:
        """Write the agents' `commands` for the tick at `time` [s]: evolutions, over them elements, and entrances.

        `speed` (A,) [m/s] is the top speed that the dancers' steps can follow.
        """
        self._now, self._speed = (timeline, span), speed
        self.stage_area.tick(timeline.beat_at(time))
        self.entrances.update_arrivals(self.state.position)
        if len(self.partners.leader):
            self.partners.end_pairs(self.entrances.state == ON)
        self.performers.tick(time)
        self.evolutions.work(self.state.position)
        self._compute_commands(self.commands, self.state, time, ahead=False)
        if self.evolutions.running:
            self.evolutions.release(self.elements.influence >= RELEASE_INFLUENCE)

    def advance(self, time: float, *, reference: Float32, reference_velocity: Float32) -> None:
        """Advance the agents by one tick, as commanded, without collisions.

        `reference` (A, 2) [m] are the dancers' reference positions in the measure, and `reference_velocity` (A, 2)
        [m/s] the velocities of these.
        """
        self._advance(
            self.state, self._spare, commands=self.commands, surroundings=self.surroundings, time=time, dt=TICK
        )
        self.state, self._spare = self._spare, self.state
        # in an evolution agents stay at the planned places, which are the dancers' targets
        hold_on_leash(
            self.state.position, self.state.velocity, reference, reference_velocity, self.commands.rows,
            self.entrances.state, ENTERING, ON, LEASH, LONG_LEASH, self._leash,
        )  # fmt: skip

    def _compute_commands_ahead(self, wants: AgentCommand, state: AgentState, time: float) -> None:
        self._compute_commands(wants, state, time, ahead=True)

    def _compute_commands(self, wants: AgentCommand, state: AgentState, time: float, *, ahead: bool) -> None:
        """Fill the commands `wants` for agents in `state` at `time` [s]. With `ahead`, nothing else changes."""
        if self._now is None:
            return
        timeline, span = self._now
        beat, size = timeline.beat_at(time), self._beats
        wants.reset(self._speed, STANDING_SEPARATION)
        if self.evolutions.running:
            danced = span.danced_beats(beat, size)
            rate = (span.danced_beats(timeline.beat_at(time + TICK), size) - danced) / TICK
            self.evolutions.write(wants, state, danced, rate)
            wants.raise_firm_speeds(self._speed, MAX_SPEED_FACTOR)
        if not ahead:
            self.elements.refresh(beat, wants, state)
        self.elements.blend(wants, state, time=time, beat=beat, ahead=ahead)
        self._partner_agents.set_commands(wants, state)
        self.entrances.write(wants, state.position)

    # -- look-ahead ----------------------------------------------------------------------------------------------

    def begin_lookahead(self, time: float, seconds: float, heading: Float64, late: Float64) -> None:
        """Begin to predict the agents `seconds` [s] ahead of `time` [s], and to prepare the next measure's segments.

        `heading` (A,) [rad] are the headings at its beginning, `late` (A,) [beats] the intended delays.
        """
        tempo = 120.0 if self._now is None else self._now[0].tempo
        self._ahead.begin(self.state, time, seconds, late, tempo)
        if self._now is None:
            return
        timeline, span = self._now
        position = self.state.position
        self.elements.begin_measure(span.number + 1, span.end, timeline.beats_per_measure, position)
        self.evolutions.prepare(span.number + 1, position, heading)

    def withdraw(self, measure: int) -> None:
        """Replace the preparations for `measure`, which has not begun: the score has jumped."""
        self.elements.withdraw(measure)
        self.evolutions.withdraw(measure)

    def run_lookahead(self, steps: int) -> None:
        """Run at most `steps` coarse steps of the look-ahead."""
        self._ahead.work(steps)

    def predicted_ends(self) -> tuple[Float64, Bool, Float64]:
        """Return the predicted positions at the end of the next measure, (A, 2) [m], which dancers are in an evolution
        then, (A,), and their headings, (A,) [rad].

        The look-ahead must be finished. Measures of delayed dancers end later.
        """
        return self._ahead.ends(None if self._now is None else self._now[1])

    # -- live ----------------------------------------------------------------------------------------------------

    def resize(self, width: float, depth: float, *, measure: int, beat: float, beats_per_measure: float) -> None:
        """Set the stage to `width` by `depth` [m] from `beat` of `measure` on. Raises PersonError if impossible."""
        there = int(np.count_nonzero(self.entrances.state != WAITING))
        if not self.stage_area.resize(width, depth, dancers=there, beat=beat, beats_per_measure=beats_per_measure):
            return
        self._resize(self._patch, measure)

    def _resize(self, patch: Patch, measure: int) -> None:
        """Give the size of the stage and the gates of `patch` to all that moves on it, within `measure`."""
        half_width, half_depth = self.stage_area.half.tolist()
        half = half_width, half_depth
        self._place_gates(patch, half)
        self.casting.half = half
        self._advance.resize(*half)
        self.elements.resize(*half)
        self.evolutions.resize(half, self.stage_area.fit_size, measure=measure)

    def _place_gates(self, patch: Patch, half: tuple[float, float]) -> None:
        self.gates = gates_of(patch, *half)
        self.entrances.resize(self.gates, half)

    def set_yielding(self, rows: npt.NDArray[np.integer], led: Bool) -> None:
        """Make all others yield to the agents `rows` (n,) while these are `led` (n,) by a performer."""
        usual = np.where(self.casting.soloists[rows], 0.0, 1.0)
        self.model.responsibility[rows] = np.where(led, 0.0, usual)
        self._advance.yield_to(rows, self.model.responsibility[rows])

    def apply_patch(self, fresh: "GroupMotion") -> None:
        """Apply stage, gates, steering and set of another patch. Items moved live stay in place."""
        old, new = self._patch, fresh._patch
        if old.steering != new.steering:
            self._advance.steer(fresh.model.steering)
        self.separation.resize(fresh.separation)
        if old.stage != new.stage:
            self.stage_area.change_patch(new.stage, beats_per_measure=self._beats)
            self._resize(new, -1 if self._now is None else self._now[1].number)
        elif old.gate != new.gate:
            self._place_gates(new, self.casting.half)
        update_set(self.surroundings, old.obstacle, new.obstacle)

    def show(self, view: StageView) -> None:
        """Copy visible dancers, stage size, elements, obstacles, walls and performers into the drawing snapshot."""
        np.greater_equal(self.entrances.state, ENTERING, out=view.present)
        view.stage_size = float(2.0 * self.stage_area.border[0]), float(2.0 * self.stage_area.border[1])
        self.elements.show(view)
        show_set(self.surroundings, view)
        self.performers.mark_obstacles(view)
