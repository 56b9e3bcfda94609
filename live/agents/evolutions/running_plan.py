"""The running plan: segments of all groups, planned ahead and followed beat by beat (T085-T089, T096).

Beats of a plan are danced beats: (measure + fraction of it) times the beats of a measure, counted from measure 0.
Dancers therefore arrive on the danced measure line even if a "this is the one" tap has moved it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import AgentCommand
from live.agents.evolutions.evolution_kernels import track
from live.agents.evolutions.intention import Repertoire, Segment
from live.agents.evolutions.joint_planning import JointPlanning
from live.agents.evolutions.planned_segment import MAX_LATE_CALLS, PlannedSegment
from live.agents.evolutions.segment_start import SegmentStart
from live.agents.evolutions.trajectory import GroupState
from live.agents.groups.group_expression import select_dancers
from live.agents.groups.roster import Mask, Roster
from live.base.arrays import Float32


class HasPosition(Protocol):
    """An agent state with positions."""

    position: Float32
    """Places [m], shape (A, 2)."""


CATCH_UP_TIME = 0.3
"""Seconds within which a displaced dancer returns to the planned path."""
MAX_IMMEDIATE_DANCERS = 100
"""Segments that begin now are planned at once for up to this many dancers, otherwise over the next ticks."""
JOINT_PIECES_PER_CALL = 2
"""Pieces of joint planning in one call: about a millisecond."""
BEATS_HELD = 1.0
"""Beats for which ways stay as they are when joint planning begins with the segment: so long it takes."""


@dataclass(slots=True, eq=False)
class _Entry:
    """A segment of the plan and the dancers removed from it."""

    segment: Segment
    excluded: Mask


class Plan:
    """The planned motion of a show's dancers; the module defines its beats."""

    def __init__(
        self,
        roster: Roster,
        repertoire: Repertoire,
        segments: Iterable[Segment] = (),
        *,
        measure_beats: float = 4.0,
        half: tuple[float, float] = (6.0, 4.0),
        radius: npt.ArrayLike = 0.25,
        seed: int = 0,
    ) -> None:
        """`half` is half the width and depth of the stage [m], `radius` (A,) or one for all the body radii [m]."""
        self.roster = roster
        self.available: Mask = np.ones(roster.count, np.bool_)
        """Dancers who take part in segments that begin, shape (A,): not those offstage or leaving."""
        self.measure_beats = measure_beats
        self._repertoire = repertoire
        self._half = half
        self._radius = np.broadcast_to(np.asarray(radius, np.float64), (roster.count,))
        self._seed = seed
        self._entries: list[_Entry] = []
        self._motions: list[PlannedSegment] = []
        self._prepared: dict[int, list[PlannedSegment]] = {}
        self._in_progress: list[PlannedSegment] = []
        self._joints: list[JointPlanning] = []
        self._late_joint_calls_left = MAX_LATE_CALLS
        self._now = GroupState(roster.count)
        self._target = GroupState(roster.count)
        self._boundary = GroupState(roster.count)
        for segment in segments:
            self.add(segment)

    # planning

    @property
    def segments(self) -> tuple[Segment, ...]:
        """All remembered segments, in the order in which they were added."""
        return tuple(entry.segment for entry in self._entries)

    @property
    def repertoire(self) -> Repertoire:
        """Formations, paths and intentions; an assignment reaches every segment that has not begun (T087)."""
        return self._repertoire

    @repertoire.setter
    def repertoire(self, repertoire: Repertoire) -> None:
        self._repertoire = repertoire
        self._prepared.clear()

    def add(self, segment: Segment, *, replace: bool = False) -> None:
        """Plan one more segment for its measure; it replaces what its dancers have then.

        `replace`: replace the segments of the same group expression and measure. PersonError: a name is unknown.
        """
        if replace:
            self._entries = [
                e for e in self._entries if (e.segment.start, e.segment.group) != (segment.start, segment.group)
            ]
        self._repertoire.intention(segment.intention)
        select_dancers(segment.group, self.roster, np.zeros((self.roster.count, 2)), self._half)
        self._entries.append(_Entry(segment, np.zeros(self.roster.count, np.bool_)))
        self._prepared.pop(segment.start, None)

    def remove(self, segments: Iterable[Segment]) -> None:
        """Remove these segment objects, which have not begun."""
        gone = {id(segment) for segment in segments}
        for entry in self._entries:
            if id(entry.segment) in gone:
                self._prepared.pop(entry.segment.start, None)
        self._entries = [entry for entry in self._entries if id(entry.segment) not in gone]

    def resize(self, half: tuple[float, float]) -> None:
        """Set half the stage's width and depth [m] for all segments that begin from now on."""
        self._half = half
        self._prepared.clear()

    def forget(self, measure: int) -> None:
        """Remove the segments of measures before `measure`, so that the list does not grow in a long show."""
        self._entries = [entry for entry in self._entries if entry.segment.start >= measure]

    def clear(self, dancers: Mask) -> None:
        """Remove these dancers (A,) from all segments, now and later; until a new one is added elements move them."""
        self.release(dancers)
        for entry in self._entries:
            entry.excluded |= dancers
        self._prepared.clear()

    def release(self, dancers: Mask) -> None:
        """End the current segments of these dancers (A,): elements move them; later segments stay planned."""
        for motion in (*self._motions, *self._in_progress):
            motion.controlled[dancers[motion.dancers]] = 0

    # running

    @property
    def running(self) -> bool:
        """Whether a segment that has begun, or is still being planned late, may control a dancer."""
        return bool(self._motions or self._in_progress)

    def prepare(
        self, measure: int, positions: npt.ArrayLike, headings: npt.ArrayLike, *, if_controlled: bool = False
    ) -> None:
        """Start to plan the segments of `measure` ahead of time; `write_commands` includes them as soon as they are
        usable.

        `positions` (A, 2) [m] and `headings` (A,) [rad] are the predictions for its line, for dancers without a segment
        then. `if_controlled`: only if segments control every dancer who takes part. Measures without segments cost
        nothing.
        """
        if measure not in self._prepared:
            if if_controlled and not self._all_controlled(measure, positions):
                return
            entries = [entry for entry in self._entries if entry.segment.start == measure]
            motions = self._start_segments(entries, None, np.asarray(positions), np.asarray(headings))
            self._prepared[measure] = motions
            self._plan_together(motions)

    def work(self) -> None:
        """Do one piece (about a millisecond at most) of pending planning, if there is any."""
        if self._in_progress:
            motion = self._in_progress[0]
            if motion in self._motions:
                motion.work_some(late=True)
            else:
                motion.work_some()
                if motion.usable:
                    self._motions.append(motion)
            if motion.done:
                self._in_progress.remove(motion)
            return
        if self._work_on_joint():
            return
        waiting = (motion for coming in self._prepared.values() for motion in coming)
        motion_ahead = next((motion for motion in waiting if not motion.done), None)
        if motion_ahead is not None:
            motion_ahead.work_some()

    def finish(self) -> None:
        """Complete the planning of all segments that have begun. Takes unbounded time: not for use during a show."""
        for motion in self._in_progress:
            motion.finish()
            if motion not in self._motions:
                self._motions.append(motion)
        self._in_progress.clear()
        for joint in self._joints:
            if joint.motions[0] in self._motions:
                if not joint.started:
                    joint.held_until = None
                joint.finish()
        self._joints = [joint for joint in self._joints if not joint.done]

    def drop_incomplete(self) -> None:
        """Drop segments whose planning is incomplete: their dancers are free, and later segments are prepared again."""
        self._motions = [motion for motion in self._motions if motion not in self._in_progress]
        self._in_progress.clear()
        self._joints.clear()
        self._prepared.clear()

    @property
    def idle(self) -> bool:
        """Whether no planning is pending."""
        waiting = any(not motion.done for coming in self._prepared.values() for motion in coming)
        return not (self._in_progress or waiting or self._pending_joints())

    def begin_measure(self, measure: int, positions: npt.ArrayLike, headings: npt.ArrayLike) -> list[PlannedSegment]:
        """Begin the segments of `measure` from where the dancers are now, and return them.

        `positions` (A, 2) [m] and `headings` (A,) [rad] are the actual ones. Planning that `prepare` left incomplete is
        done at once until it is usable.
        """
        where = np.asarray(positions, np.float64)
        self.prepare(measure, where, headings)
        coming = self._prepared.pop(measure)
        if not (coming or self._prepared or self._motions):
            return coming
        line = measure * self.measure_beats
        for motion in coming:
            motion.make_usable()
            if motion.begin <= line:
                motion.start_from(where[motion.dancers])
            if not motion.done:
                self._in_progress.append(motion)
        self._prepared = {number: motions for number, motions in self._prepared.items() if number > measure}
        self._motions.extend(coming)
        self._hold_late_joint(coming, line)
        self._forget(line)
        return coming

    def start_now(
        self, segment: Segment, beat: float, positions: npt.ArrayLike, headings: npt.ArrayLike
    ) -> list[PlannedSegment]:
        """Begin `segment` at `beat`, regardless of its measure; it ends on a measure line, after its `measures`.

        The current measure counts as one if at least half of it is left. A large group's segment begins some ticks
        later, when `work` has planned it.
        """
        self._repertoire.intention(segment.intention)
        entry = _Entry(segment, np.zeros(self.roster.count, np.bool_))
        motions = self._start_segments([entry], beat + segment.delay, np.asarray(positions), np.asarray(headings))
        for motion in motions:
            if len(motion.dancers) <= MAX_IMMEDIATE_DANCERS:
                motion.make_usable()
            if motion.usable:
                self._motions.append(motion)
            if not motion.done:
                self._in_progress.append(motion)
        self._prepared.clear()
        self._plan_together(motions)
        self._hold_late_joint(motions, beat)
        self._forget(beat)
        return motions

    def write_commands(self, commands: AgentCommand, state: HasPosition, beat: float, beats_per_second: float) -> None:
        """Command the dancers under a segment to be at its places at `beat`: desired velocity with full firmness."""
        setting = self.state_at(beat)
        track(
            state.position,
            setting.position,
            setting.velocity,
            setting.controlled,
            beats_per_second,
            CATCH_UP_TIME,
            commands.rows,
        )

    def state_at(self, beat: float) -> GroupState:
        """Return the planned state of the dancers at `beat`; an array of the plan, overwritten by the next call."""
        return self._fill(beat, self._now, False)

    def predicted_state(self, beat: float) -> GroupState:
        """Return the planned state at a future beat, including prepared segments: exact where `under` is 1.

        The array is not that of `at`; the next call of `write_commands` overwrites it.
        """
        return self._fill(beat, self._target, True)

    @property
    def motions(self) -> tuple[PlannedSegment, ...]:
        """The segments that have begun and still control a dancer, in order of precedence."""
        return tuple(self._motions)

    # joint planning (T147)

    def _plan_together(self, motions: list[PlannedSegment]) -> None:
        """Plan the ways of segments that begin together, once each is planned, with all other segments in mind."""
        if motions:
            self._joints = [*self._pending_joints(), JointPlanning(motions, radius=self._radius, fill=self._fill_all)]

    def _fill_all(self, beat: float, out: GroupState) -> GroupState:
        return self._fill(beat, out, True)

    def _hold_late_joint(self, motions: list[PlannedSegment], beat: float) -> None:
        """Hold the ways of segments that begin now, at `beat`, for a while, unless they are being planned together."""
        for joint in self._joints:
            if motions and joint.motions[0] is motions[0]:
                self._late_joint_calls_left = MAX_LATE_CALLS
                if not joint.started:
                    joint.held_until = beat + BEATS_HELD

    def _pending_joints(self) -> list[JointPlanning]:
        """Return joint planning that is not complete, and whose segments have not been dropped."""
        if not self._joints:
            return []
        there = {
            id(motion) for motions in (self._motions, self._in_progress, *self._prepared.values()) for motion in motions
        }
        return [joint for joint in self._joints if not joint.done and any(id(one) in there for one in joint.motions)]

    def _work_on_joint(self) -> bool:
        """Do some pieces of the first joint planning whose segments are planned; return whether there is any."""
        self._joints = self._pending_joints()
        joint = next((joint for joint in self._joints if joint.ready), None)
        if joint is None:
            return False
        if joint.motions[0] in self._motions:
            self._late_joint_calls_left -= 1
            if self._late_joint_calls_left < 0:
                joint.stop()
        for _ in range(JOINT_PIECES_PER_CALL):
            if not joint.done:
                joint.work()
        return True

    # implementation

    def _fill(self, beat: float, out: GroupState, ahead: bool) -> GroupState:
        out.controlled[:] = 0
        for motion in self._motions:
            if motion.begin <= beat:
                motion.write(beat, out)
        if ahead:
            for measure in sorted(self._prepared):
                for motion in self._prepared[measure]:
                    if motion.usable and motion.begin <= beat:
                        motion.write(beat, out)
        return out

    def _start_segments(
        self, entries: list[_Entry], now: float | None, positions: npt.NDArray[np.floating], headings: Float32
    ) -> list[PlannedSegment]:
        motions = []
        for entry in entries:
            segment = entry.segment
            begin = segment.begin_beat(self.measure_beats) if now is None else now
            end = segment.end_beat(self.measure_beats) if now is None else self._end_of(segment, now)
            where, facing = self._boundary_state(begin, positions, headings)
            dancers = select_dancers(segment.group, self.roster, where, self._half) & self.available & ~entry.excluded
            who = np.flatnonzero(dancers).astype(np.int32)
            if not len(who):
                continue
            departure = SegmentStart(
                who,
                where[who],
                facing[who],
                tuple(self.roster.attributes[dancer] for dancer in who),
                begin,
                end,
                self.measure_beats,
                self._radius[who],
                self._half,
                self._seed,
            )
            intention = self._repertoire.intention(segment.intention)
            motions.append(PlannedSegment(segment, intention, self._repertoire, departure))
        motions.sort(key=lambda motion: motion.begin)
        return motions

    def _all_controlled(self, measure: int, positions: npt.ArrayLike) -> bool:
        """Whether segments determine the places of all dancers who take part in those of `measure`."""
        under = self._fill(measure * self.measure_beats, self._boundary, True).controlled == 1
        for entry in self._entries:
            if entry.segment.start == measure:
                where = np.asarray(positions, np.float64)
                who = (
                    select_dancers(entry.segment.group, self.roster, where, self._half)
                    & self.available
                    & ~entry.excluded
                )
                if (who & ~under).any():
                    return False
        return True

    def _end_of(self, segment: Segment, begin: float) -> float:
        line = np.floor(begin / self.measure_beats + 0.5) * self.measure_beats
        return float(line + segment.measures * self.measure_beats)

    def _boundary_state(
        self, beat: float, positions: npt.NDArray[np.floating], headings: npt.NDArray[np.floating]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The setting that other segments leave at `beat`; given places where none holds the dancer."""
        left = self._fill(beat, self._boundary, True)
        under = left.controlled == 1
        where = np.where(under[:, None], left.position, np.asarray(positions, np.float64))
        return where, np.where(under, left.heading, np.asarray(headings, np.float64))

    def _forget(self, beat: float) -> None:
        """Drop motions of which others hold every dancer from now on."""
        held = np.zeros(self.roster.count, np.bool_)
        kept: list[PlannedSegment] = []
        order = sorted(range(len(self._motions)), key=lambda index: (self._motions[index].begin, index))
        for index in reversed(order):
            motion = self._motions[index]
            if motion.begin > beat or (motion.controlled.astype(np.bool_) & ~held[motion.dancers]).any():
                kept.append(motion)
            if motion.begin <= beat:
                held[motion.dancers[motion.controlled == 1]] = True
        self._motions = kept[::-1]
