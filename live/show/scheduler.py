"""Scheduler: measure lines, look-ahead and the choice of every dancer's next step, a beat ahead of the line (T038).

The planning of the next measure is a row of small pieces, so many in each tick that they are done a beat before the
line: from LOOK_BEATS before it on the agents are run ahead on a copy; then it is asked what each dancer should dance,
where she should end and whither she should face, and the motion graph is searched for some dancers at a time. A beat
before the line, what was found is laid down where the dancers will really end; at the line everybody crosses, and
nothing is searched. The way a dancer is still off after her step is spread over that measure (position targets, T068).
"""

import math
from functools import partial
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.look_ahead import LookAhead
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.graph.choosing.choosing import Choosing, with_direction
from live.graph.motion_graph import MotionGraph
from live.graph.placing import joined
from live.show.aims import Aims
from live.show.behind import behind
from live.show.carrying import FAITHFUL, Carrying
from live.show.choices import Choices
from live.show.dancers import Dancers
from live.show.drafting import Drafting
from live.show.echo import Programme
from live.show.following import choose_following, place_followers
from live.show.group_motion import GroupMotion
from live.show.measure import MeasureSpan
from live.show.patch import Patch
from live.show.pieces import Piece, Pieces
from live.show.programmes import take_programmes

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

LOOK_BEATS: Final = 1.75
"""Beats before the measure line at which the look-ahead begins."""
DECIDE_BEATS: Final = 1.0
"""Beats before it at which the next steps are chosen: never later than the blend begins."""
ANEW_TICKS: Final = 8.0
"""With fewer ticks until the decision the planning of a measure is not begun anew."""
AT_A_TIME: Final = 48
"""Dancers whose measures are chosen in one piece."""


class Scheduler:
    """Decides for A dancers in their groups; deterministic."""

    def __init__(
        self,
        patch: Patch,
        dancers: Dancers,
        motion: GroupMotion,
        programmes: list[Programme],
        group: Int32,
        choosing: Choosing | None = None,
    ) -> None:
        """`group` (A,) is shared with the show, which may change it between measures; `choosing` is that of the
        dancers' graph if it is known."""
        self._patch = patch
        self._dancers = dancers
        self._motion = motion
        self._group = group
        self.programmes = programmes
        self.carrying = Carrying(patch, dancers, motion)
        self.aims = Aims(patch, dancers, motion, programmes, group)
        self.order = self.aims.order
        self.speed: Float32 = self.aims.speed
        """Top speed of each agent [m/s], shape (A,)."""
        count = len(group)
        self.choices = Choices(count)
        self._drafting = Drafting(dancers, self.choices, self.aims)
        self._asked_from = np.full(count, -1, np.int32)
        self._arguments: tuple[Any, ...] = ()
        self._following: tuple[Int32, Int32] = np.zeros(0, np.int32), np.zeros(0, np.int32)
        self._pieces = Pieces()
        self._looked = False  # whether headings have been asked for
        self._seconds = 2.0
        self.take_graph(dancers.graph, choosing or Choosing.of(dancers.graph))
        self.last_target: Float64 | None = None
        """Where the dancers were last sent, no farther than their steps reach [m], (A, 2); None before the first
        decision."""
        self.last_heading = np.zeros(count)
        """What they were to face there [rad], shape (A,)."""
        self.detours = 0
        """How often a dancer could not dance the wanted step at once, since the start."""
        self.dead_ends = 0
        """How often a dancer found no next measure and repeated hers, since the start."""

    def take_graph(self, graph: MotionGraph, choosing: Choosing) -> None:
        """Choose in this graph from now on; called when nobody's next measure is decided."""
        self.choosing = choosing
        self._drafting.take_graph(graph, choosing)
        self.aims.take_graph(graph, choosing)
        self.foresight = self.aims.foresight
        self._give = np.minimum(graph.node_give, self._patch.locomotion.correction_m)
        self._usual_give = float(np.median(self._give))

    def take_patch(self, fresh: "Scheduler") -> None:
        """Take over what groups dance, and how far corrections go. Called when nobody's next measure is decided."""
        take_programmes(self.programmes, fresh.programmes, fresh._patch)
        self.aims.reorder()
        self._give, self._usual_give = fresh._give, fresh._usual_give

    def farthest(self) -> Float64:
        """How far each dancer's steps go in one measure [m]: the farthest of her group's, shape (A,)."""
        return self.aims.farthest()

    def set_speed(self, measure: int, timeline: Timeline) -> None:
        """Let the agents of each group go as fast as its steps and the correction can follow."""
        self._seconds = timeline.beats_per_measure * 60.0 / timeline.tempo
        self.aims.set_speed(measure, timeline)

    @property
    def at_rest(self) -> bool:
        """Whether no measure is half planned."""
        return not self._pieces

    # -- the planning of one measure, in pieces ------------------------------------------------------------------

    def work(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Do this tick's share of the planning for the measure after `span`."""
        if self._dancers.decided:
            return
        left = span.end - timeline.beat_at(time)
        # a measure that "this is the one" has stretched reaches its blend more than a beat before its end
        blends = span.fraction(timeline.beat_at(time + TICK)) >= 1.0 - self._dancers.graph.window
        if left <= DECIDE_BEATS or blends:
            self.decide(span, timeline, time)
            return
        if not self._pieces:
            if left > max(LOOK_BEATS, DECIDE_BEATS + 2.0 * TICK) or self._arguments:
                return
            self._begin(span, timeline, time)
            return
        ticks = math.ceil((left - DECIDE_BEATS) * 60.0 / timeline.tempo / TICK)
        self._pieces.work(ticks)

    def plan_anew(self, span: MeasureSpan, timeline: Timeline, time: float) -> bool:
        """Forget what is planned of the measure after `span`, and plan it again; False if it is too late for that."""
        if self._dancers.decided:
            return False
        if not self._pieces and not self._arguments:
            return True  # not begun
        if (span.end - timeline.beat_at(time) - DECIDE_BEATS) * 60.0 / timeline.tempo < ANEW_TICKS * TICK:
            return False
        self._pieces.clear()
        self._arguments = ()
        if self._looked:
            self.aims.headings.take_back()
        for programme in self.programmes:
            programme.take_back(span.number + 1)
        return True

    def _begin(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Begin to plan the measure after `span`."""
        left = max(0.0, span.end - timeline.beat_at(time))
        beat = 60.0 / timeline.tempo
        seconds = (left + timeline.beats_per_measure) * beat
        # a ripple has many delays; quarters of a beat are near enough to look ahead
        late = np.round(4.0 * self._dancers.variation.late * timeline.beats_per_measure) / 4.0
        self._motion.look(time, seconds, self._dancers.present.end_heading(), late)
        steps = math.ceil((seconds + float(late.max()) * beat) / LookAhead.STEP) + len(np.unique(late))
        self._pieces.begin(self._planned(steps, span.number + 1))
        self._looked = False

    def _planned(self, steps: int, measure: int) -> list[Piece]:
        """The pieces of the planning of `measure`, with so many coarse `steps` of looking ahead.

        What they weigh is what they take, in about hundredths of a millisecond: something, and something per dancer.
        """
        count, variation = len(self._group), self._dancers.variation
        rows = [slice(row, min(row + AT_A_TIME, count)) for row in range(0, count, AT_A_TIME)]
        return [
            *[(3 + 0.055 * count, partial(self._motion.work, 1))] * steps,
            (32 + 0.2 * count, self._look),
            *[(45 + 0.04 * count, partial(self.aims.ask, index, measure, self.choices)) for index in self.order],
            (32 + 0.15 * count, self._limit),
            *[(5 + 0.65 * (some.stop - some.start), partial(self._choose, some)) for some in rows],
            (2, self._lead),
            *[(45, partial(self._follow, slice(row, row + AT_A_TIME))) for row in self._pairs_by_pieces()],
            (5, self._catch_up),
            (40 + 0.05 * count, partial(self._drafting.vary, measure)),
            (22 + 0.03 * count, self._mix),
            (22 + 0.04 * count, self._turn),
            (15, partial(variation.drift.foresee, measure + 3)),
        ]

    def _pairs_by_pieces(self) -> range:
        """Where the pieces begin in which followers choose."""
        return range(0, len(self._motion.partners.leader), AT_A_TIME)

    def _look(self) -> None:
        self._motion.work(1 << 20)
        self.aims.look(self.choices)
        self._looked = True

    def _limit(self) -> None:
        """How far everybody can get, and all that the choice asks for."""
        variation, limits = self._dancers.variation, self._patch.locomotion
        share = FAITHFUL + (1.0 - FAITHFUL) * variation.obedience
        self.choosing.allow(seconds=self._seconds, turn=math.radians(limits.turn_deg), give=self._give)
        self.aims.limit(self.choices, share * self._usual_give)
        self._asked_from[:] = self._dancers.node
        self._arguments = (
            self._asked_from,
            with_direction(self._dancers.present.end_placement()),
            with_direction(np.column_stack([self.choices.target, self.aims.heading])),
            self.aims.row,
            self.aims.ahead,
            self._motion.partners.own_sides(variation.sides, self._dancers.graph.library.node_side[self._asked_from]),
            np.column_stack([variation.on_support, variation.face_average, share]),
            self.choices.out,
        )

    def _choose(self, rows: slice) -> None:
        self.choosing.choose(rows, *self._arguments)

    def _lead(self) -> None:
        """Where leaders' measures, chosen already, will end, says where their followers' should."""
        partners = self._motion.partners
        self._following = partners.follower, partners.follower
        if len(partners.leader):
            self._following = place_followers(partners, self.choosing, self.choices, self.aims.heading, self._arguments)

    def _follow(self, pairs: slice) -> None:
        rows, sides = (array[pairs] for array in self._following)
        if len(rows):
            choose_following(rows, sides, self.choosing, self.choices, self._arguments)

    def _catch_up(self) -> bool:
        """Choose anew for those who were put into another measure since they were asked; whether there are any."""
        node = self._dancers.node
        changed = np.flatnonzero(self._asked_from != node)
        if not len(changed):
            return False
        self._asked_from[changed] = node[changed]
        self._arguments[1][changed] = with_direction(self._dancers.present.end_placement())[changed]
        for row in changed.tolist():
            self._choose(slice(row, row + 1))
        return True

    def _mix(self) -> None:
        self._drafting.mix(self._arguments[1], self._arguments[6][:, 0])

    def _turn(self) -> None:
        self._drafting.turn(self._arguments[1])

    # -- the decision --------------------------------------------------------------------------------------------

    def decide(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Choose the next measure of every dancer now, finishing what is not planned yet."""
        if not self._pieces and not self._arguments:
            self._begin(span, timeline, time)
        self._pieces.finish()
        if self._catch_up():
            self._drafting.vary(span.number + 1)
            self._mix()
            self._turn()
        self._take()
        self._arguments = ()
        self.last_target, self.last_heading = self.choices.target.copy(), self.aims.heading.copy()

    def _take(self) -> None:
        """Lay down the chosen measures where the dancers will be, and add what they need to end in place."""
        dancers, graph, choices = self._dancers, self._dancers.graph, self.choices
        coming, edge = dancers.coming, choices.edge[:, 0]
        hips, _, axes = dancers.present.ends_and_axes()  # by now: the present measure may have been aimed anew
        coming.copy_from(self._drafting.draft)
        coming.placement[:] = joined(axes, graph.edge_transform[np.maximum(edge, 0)])
        stuck = edge < 0
        if stuck.any():  # cannot happen in a pruned graph; a dancer who is stuck repeats her measure
            self.dead_ends += int(stuck.sum())
            coming.placement[stuck] = axes[stuck]
        self.detours += int(
            np.count_nonzero((choices.step >= 0) & (graph.library.node_step[coming.node] != choices.step))
        )
        self.carrying.decided(hips, choices.target, choices.wish)

    # -- what there is to say ------------------------------------------------------------------------------------

    def behind(self) -> dict[str, Any]:
        """How near to where they are sent the dancers of each group get, and what should be recorded (T075)."""
        return behind(
            self.choices,
            self._group,
            tuple(section.name for section in self._patch.group),
            self._dancers.graph.library.steps,
            self._motion.present,
        )
