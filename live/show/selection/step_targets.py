"""Aims: which step each dancer should dance next, where she should end, and whither she should face (T067, T068).

Headings: where each dancer should face at the end of her next measure, by what her group looks at (T126, T127).
"""

import numpy as np
import numpy.typing as npt

from live.clock.timeline import Timeline
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import wrapped
from live.graph.select.selector import Choosing
from live.show.dancers.dancers import Dancers
from live.show.group.group_motion import GroupMotion
from live.show.patch.patch import Patch
from live.show.patch.section_motion import ATTRACTOR, CENTRE, DANCER, DEGREES, GROUP, PATH, PUBLIC, Facing, parse_facing
from live.show.score.canon import Echo, Programme
from live.show.score.step_program import GroupProgramme
from live.show.selection.choices import Choices
from live.show.selection.lookahead import Foresight

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

MOVES = 0.25
"""A way shorter than this [m] in a measure has no direction: whoever stands faces where she came to (T126)."""
CLOSE = 0.3
"""Nobody turns after what is nearer than this [m]."""


class Headings:
    """The headings of A dancers, measure after measure.

    A heading that is wanted becomes one that is danced by T127: a quarter of the turn in one measure, half of it in
    the next, a quarter in the third. A show does not know what will be wanted a measure later, so the turn begins with
    the measure in which it is wanted, not before.
    """

    def __init__(self, patch: Patch, motion: GroupMotion) -> None:
        """PersonError for words that mean nothing."""
        self._patch = patch
        self._motion = motion
        count = len(motion.casting.group)
        self._facing = [self.parse(section.facing) for section in patch.group]
        self._raw = np.zeros((2, count))
        """What was wanted in the last two measures, unwrapped, the newest first."""
        self._before = self._raw.copy()

    def parse(self, words: str) -> Facing:
        """What `words` mean in this show; PersonError if nothing."""
        casting = self._motion.casting
        return parse_facing(words, dancers=len(casting.group), groups=casting.names)

    def take_patch(self, fresh: "Headings") -> None:
        """Take over where groups look whose patch says something else now; others keep what they were told."""
        for index, (old, new) in enumerate(zip(self._patch.group, fresh._patch.group, strict=True)):
            if old.facing != new.facing:
                self._facing[index] = fresh._facing[index]

    @property
    def facings(self) -> tuple[Facing, ...]:
        """Where each group looks."""
        return tuple(self._facing)

    def set(self, group: int, facing: Facing) -> None:
        """The dancers of that group look there from their next decided measure on."""
        self._facing[group] = facing

    def begin(self, heading: Float64) -> None:
        """Everybody faces `heading` (A,) [rad] and wants to."""
        self._raw[:] = heading

    def take_back(self) -> None:
        """The last `next` shall not have been."""
        self._raw[:] = self._before

    def next(self, start: Float64, wish: Float64, planned: Float64, known: Bool) -> Float64:
        """Headings (A,) [rad] at the end of the next measure of dancers who go from `start` to `wish` (A, 2) [m].

        `planned` (A,) are the headings of those who are in an evolution (`known`): they are smoothed already. To be
        called once for each measure.
        """
        self._before[:] = self._raw
        wanted = self._raw[0].copy()
        for index, facing in enumerate(self._facing):
            members = np.flatnonzero(self._motion.casting.group == index)
            if len(members):
                wanted[members] = self._wanted(facing, members, start, wish, wanted)
        passing = self._motion.entrances.passing  # whoever comes or goes looks where she goes
        wanted[passing] = _towards(wish - start, MOVES, wanted)[passing]
        wanted[known] = planned[known]
        newest = self._raw[0] + wrapped(wanted - self._raw[0])
        smooth = 0.25 * newest + 0.5 * self._raw[0] + 0.25 * self._raw[1]
        smooth[known | passing] = newest[known | passing]
        self._raw[1], self._raw[0] = self._raw[0], newest
        self._raw[1, passing] = newest[passing]
        return np.asarray(smooth)

    def _wanted(
        self, facing: Facing, members: npt.NDArray[np.intp], start: Float64, wish: Float64, last: Float64
    ) -> Float64:
        """Headings of `members` (n,), (n,)."""
        match facing.kind:
            case k if k == PUBLIC:
                return np.zeros(len(members))
            case k if k == DEGREES:
                return np.full(len(members), facing.heading)
            case k if k == PATH:
                return _towards((wish - start)[members], MOVES, last[members])
        place = self._place(facing, members)
        if place is None:
            return last[members]
        return _towards(place - wish[members], CLOSE, last[members])

    def _place(self, facing: Facing, members: npt.NDArray[np.intp]) -> Float64 | None:
        """What the members look at [m], (2,) or (n, 2); None if it is not there."""
        group, position = self._motion.casting.group, self._motion.state.position.astype(np.float64)
        index = int(group[members[0]])
        match facing.kind:
            case k if k == CENTRE:
                return np.array(self._patch.group[index].centre)
            case k if k == DANCER:
                return position[facing.dancer] if self._motion.present[facing.dancer] else None
            case k if k == GROUP:
                whom = (group == self._motion.casting.names.index(facing.name)) & self._motion.present
                return position[whom].mean(axis=0) if whom.any() else None
            case k if k == ATTRACTOR:
                return self._motion.elements.attractor_of(int(members[0]))
        return None


def _towards(way: Float64, least: float, last: Float64) -> Float64:
    """Headings (n,) along `way` (n, 2); `last` (n,) where it is shorter than `least` [m]."""
    return np.where(np.hypot(*way.T) > least, np.arctan2(way[:, 0], way[:, 1]), last)


Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

STANDS: float = 0.15
"""A group stands if its dancers are not to go even this far [m] in the next measure."""
HELD_BACK: float = 0.2
"""Nobody is asked for more of what can be corrected than this share beyond her step's reach: the rest is for the
parting of dancers who meet. Of a step in place all of it may be."""


class Aims:
    """What is wanted of A dancers in their groups for one measure; asked for piece by piece."""

    def __init__(
        self, patch: Patch, dancers: Dancers, motion: GroupMotion, programmes: list[Programme], group: Int32
    ) -> None:
        """`group` (A,) is shared with the show, which may change it between measures."""
        self._patch, self._dancers, self._motion = patch, dancers, motion
        self._programmes, self._group = programmes, group
        self.order = list(range(len(programmes)))
        """The groups in the order in which they are asked: whoever echoes another one after her."""
        self.reorder()
        self.headings = Headings(patch, motion)
        count = len(group)
        self.speed: Float32 = np.zeros(count, np.float32)
        """Top speed of each agent [m/s]: what its dancer's steps can follow, shape (A,)."""
        self._asked: list[tuple[int | None, int]] = [(None, 0)] * len(programmes)  # measure and step of each group
        self.step = np.zeros(count, np.int32)
        """The step wanted of each dancer, below 0 for any, shape (A,)."""
        self.row = np.zeros(count, np.int32)
        """Which row of `ahead` counts for her, shape (A,)."""
        self.heading = np.zeros(count)
        """What she should face at the end [rad], shape (A,)."""

    def reorder(self) -> None:
        """Take up which groups echo others."""
        self.order.sort(key=lambda index: (isinstance(self._programmes[index], Echo), index))

    def take_graph(self, graph: MotionGraph, choosing: Choosing) -> None:
        """Ask for what this graph can do from now on."""
        library = graph.library
        self._choosing = choosing
        self.foresight = Foresight(graph)
        self.ahead = np.zeros((2 * len(self._programmes), library.node_count))
        """Measures that go wrong if a node is danced next, for each group and its travel step, (2 G, N)."""
        reach = [library.reach(step) for step in range(len(library.steps))]
        # how far one measure of each step goes [m]; last, as for ANY_STEP, of the farthest
        self._reach = np.array([*reach, max(reach)])
        for programme in self._programmes:
            programme.take_graph(graph)

    def farthest(self) -> Float64:
        """How far each dancer's steps go in one measure [m]: the farthest of her group's, shape (A,)."""
        most = np.zeros(len(self._group))
        for index, programme in enumerate(self._programmes):
            steps = [*programme.steps, *([] if programme.travel_step is None else [programme.travel_step])]
            most[self._group == index] = max(float(self._reach[step]) for step in steps)
        return most

    def set_speed(self, measure: int, timeline: Timeline) -> None:
        """Let the agents of each group go as fast as its steps and the correction can follow."""
        seconds = timeline.beats_per_measure * 60.0 / timeline.tempo
        speeds = np.empty(len(self._programmes))
        for index in self.order:
            programme, (asked_for, step) = self._programmes[index], self._asked[index]
            if asked_for != measure:
                step = programme.wanted(measure, self._dancers.node[self._group == index])
            steps = [step] if programme.travel_step is None else [step, programme.travel_step]
            reach = max(float(self._reach[s]) for s in steps)
            speeds[index] = (reach + 0.2 * self._patch.locomotion.correction_m) / seconds
        self.speed[:] = speeds[self._group]

    def look(self, choices: Choices) -> None:
        """Where everybody should be and face at the end of the next measure; the look-ahead must be finished."""
        present = self._dancers.present
        wish, known, planned = self._motion.ahead()
        choices.begin(*present.ends(), self._motion.present)
        choices.wish[:] = wish
        self.heading[:] = self.headings.next(choices.stand, wish, planned, known)
        if len(self._motion.partners.leader):
            self._motion.partners.aim(choices.wish, self.heading, choices.stand, choices.heading, known)

    def ask(self, index: int, measure: int, choices: Choices) -> None:
        """Which step the dancers of group `index` should dance in `measure`: the group's in turn, or its travel step
        where the way is too far for that."""
        programme, members = self._programmes[index], self._group == index
        way = np.hypot(*(choices.wish - choices.stand).T)
        if isinstance(programme, GroupProgramme):
            programme.stands = not members.any() or bool(np.median(way[members]) < STANDS)
        step = programme.wanted(measure, self._dancers.node[members])
        self._asked[index] = measure, step
        self.step[members] = step
        self.row[members] = 2 * index
        self.ahead[2 * index] = self.foresight.sequence(programme.coming, programme.into)
        if programme.travel_step is not None and self._reach[programme.travel_step] > self._reach[step]:
            far = members & (way > self._reach[step] + 0.5 * self._patch.locomotion.correction_m)
            self.step[far] = programme.travel_step
            self.row[far] = 2 * index + 1
            self.ahead[2 * index + 1] = self.foresight.step(programme.travel_step)

    def limit(self, choices: Choices, bound: Float64) -> None:
        """Ask nobody for more than her step can do, with `bound` (A,) [m] of correction: the predicted agents."""
        change = wrapped(self.heading - choices.heading)
        way = choices.wish - choices.stand
        reached = self._choosing.ways.limit(self.step, choices.heading, change, way, HELD_BACK * bound, bound)
        choices.target[:] = choices.stand + reached
        if len(self._motion.partners.leader):
            self._motion.partners.gather(choices.target, self.heading)
        choices.step[:] = self.step
