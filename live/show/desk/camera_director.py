"""Camera director: frames the dancers, chooses shots with the score, and moves or cuts on the lines of phrases.

It leads the camera while the switch `/dance/camera/director` is on: it writes the camera's numbers of the picture's row
at every tick, so all windows and films have one camera. Whoever sets one of them has the camera from there on
(`Parameters.fade`); switched on again, the director goes on from that camera within a measure.

Rules of film that it keeps (Mascelli 1965; He, Cohen and Salesin 1996): a change comes on the first beat of a phrase
and not within a step of several measures; a cut changes the direction by 30 degrees or the size of the shot by more
than half; a cut does not cross the line of action, between the public and the stage or between two partners; a near
shot is followed by a wide one or by another subject; a section begins with a total.
"""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base import picture_parameters
from live.base.arrays import Bool, Float64
from live.base.errors import PersonError
from live.base.scalar_kernels import damper, ease
from live.clock.ticks import TICK
from live.control.events.event import ControlEvent
from live.control.events.parameters import SetParameter
from live.show.dancers.rng import Purpose, generator_for
from live.show.desk.camera_directions import DIRECTIONS, HIDDEN, NOT_COMPARED, SUBJECTS, Stand, ViewComparison
from live.show.desk.camera_framing import Frame, Framing, direction, turn_between
from live.show.desk.camera_kernels import keep_clear, spring
from live.show.desk.camera_shots import KINDS, MOODS, TOTAL, CameraMood, ShotKind
from live.show.desk.camera_subjects import Subjects, choose
from live.show.score.playhead import END
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.desk.parameters import Parameters
    from live.show.score.score_runner import ScoreRunner

DIRECTOR_ADDRESS: Final = "/dance/camera/director"
FRAME_TICKS: Final = 8
"""The frame is checked every so many ticks."""
AHEAD_S: Final = 1.0
"""How far ahead whole bodies are framed [s]: about the lag of the spring."""
AHEAD_NEAR_S: Final = 0.25
"""The same for near shots [s]."""
MANY: Final = 100
"""Up to so many dancers two directions are compared in a tick, otherwise one."""
FIRST_COMPARED: Final = 6
"""Directions that are compared at once when the director begins; the others come with the next phrase."""
CLEARANCE: Final = 1.1
"""The eye keeps so far from every body's axis [m]."""
CATCH_UP: Final = 1.5
CATCH_UP_SPEED: Final = 2.0
"""An eye that bodies hold up follows this much faster than its goal, and so much [m/s] besides."""
LOWEST_EYE: Final = 0.3
"""Least height of the eye above the floor [m]."""
IN_THE_WAY: Final = 0.5
"""A shot is out of the question if bodies would push its camera farther than this [m]."""
NEAR_BEST: Final = 0.06
"""Directions that are so little worse than the best one are as good."""
GOOD_ENOUGH: Final = 0.2
"""The same for a cut that finds no such direction 30 degrees away."""
LEAST_TURN: Final = math.radians(30.0)
"""Least change of direction in a cut (the 30 degree rule)."""
SIZE_RATIO: Final = 1.6
"""A cut may keep its direction if the shot becomes so many times smaller or larger."""
FARTHEST_MOVE: Final = math.radians(50.0)
"""Largest change of direction in a move."""
NO_CHANGE: Final = math.radians(6.0)
"""A move below this is none: the camera stays."""
NEUTRAL: Final = math.radians(12.0)
"""On the line of action itself, give or take this, a camera is on neither side of it."""
SOFTENING_S: Final = 0.25
"""Time constant of the aim that the camera's spring follows [s]: a new frame is no jerk."""
BUILD_HALFLIFE: Final = 1.5
"""Half-life of the push in a build-up [s]."""
STEP_SHARE: Final = 0.5
"""A change waits for a measure in which so many dancers begin a step, ..."""
LATEST: Final = 2
"""... but no longer than so many measures."""
GIVE_BACK_MEASURES: Final = 1.0
"""Length of the move from the operator's camera to the director's [measures]."""
LENS: Final = slice(picture_parameters.ROLL, picture_parameters.ROLL + 5)
NEUTRAL_LENS: Final = np.array([0.0, 0.0, 0.0, 1.0, 0.0])
"""Roll, lens shift, stretch and skew of the director's lens."""


class CameraDirector:
    """The director of one show. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(
        self,
        parameters: "Parameters",
        subjects: Subjects,
        score_runner: "ScoreRunner",
        framing: Framing,
        *,
        locked: bool,
        seed: int,
        beats: int,
    ) -> None:
        """`locked`: it never leads; `beats` per measure."""
        self._parameters, self._subjects, self._score_runner = parameters, subjects, score_runner
        self._framing, self._seed, self._beats = framing, seed, beats
        self.locked = locked
        """Whether the camera has to match the hall, so that the director never leads it."""
        self.running = False
        """Whether it leads the camera."""
        self._age = 0
        self._kind = KINDS.index(TOTAL)
        self._chosen: Bool = np.zeros_like(subjects.present())
        self._frame = Frame(np.array([0.0, 1.0, 0.0]), 10.0, 0.0, 0.2, TOTAL.field_of_view_deg)
        self._comparison: ViewComparison | None = None
        self._pose, self._speed = self._frame.numbers, np.zeros(7)
        self._aim: Float64 = self._pose.copy()
        self._from: Float64 = self._pose.copy()
        self._moved, self._length = 1.0, 1.0  # beats of the running move, and its length
        self._lens: Float64 = NEUTRAL_LENS.copy()  # the operator's, from which a move to the director's begins
        self._eye, self._target = np.zeros(3), np.zeros(3)
        self._eye_goal = np.zeros(3)  # of the last tick, without bodies in the way
        self._way: Float64 = np.zeros(6)  # of eye and target [m/s]
        self._has_cut = False  # in this tick: a cut has no speed
        self._drift = 0.0  # [rad/beat]
        self._push = 0.0
        self._shot_s = 0.0  # length of the present shot until now
        self._due = -1  # the last measure in which a change that waits may come, -1: none waits
        self.cuts = 0
        """Cuts so far."""

    def apply_patch(self, fresh: "CameraDirector") -> None:
        """Adopt lock and picture of an edited patch."""
        self.locked, self._framing = fresh.locked, fresh._framing

    def check(self, event: ControlEvent) -> None:
        """Raise PersonError for an event that would have it lead a camera that is locked."""
        if self.locked and isinstance(event, SetParameter) and event.address == DIRECTOR_ADDRESS and any(event.value):
            raise PersonError("the camera is locked: it matches the hall", "see lock in [camera], and [projector]")

    @property
    def kind(self) -> ShotKind:
        """The kind of the present shot."""
        return KINDS[self._kind]

    @property
    def chosen(self) -> Bool:
        """The dancers of the present shot, (A,)."""
        return self._chosen

    @property
    def mood(self) -> CameraMood:
        """The present mood."""
        number = round(float(self._parameters.picture[picture_parameters.DIRECTOR_MOOD]))
        return MOODS[min(max(number, 0), len(MOODS) - 1)]

    # -- time --------------------------------------------------------------------------------------------------------

    def tick(self, now: Now, ticks: int = 1) -> None:
        """Advance by `ticks`."""
        first, self._age = self._age == 0, self._age + ticks
        if self.locked or self._parameters.picture[picture_parameters.DIRECTOR] < 0.5:
            self.running = False
            return
        seconds = ticks * TICK
        beats = seconds * now.timeline.tempo / 60.0
        if not self.running:
            self._begin(now, cut=first)
        elif self._comparison is not None and not self._comparison.finished:
            self._comparison.work(2 if len(self._chosen) <= MANY else 1)
        self._shot_s += seconds
        self._turn(beats)
        if (self._age // FRAME_TICKS) != (self._age - ticks) // FRAME_TICKS:
            self._reframe(now)
        self._move(seconds, beats)

    def begin_measure(self, measure: int, now: Now) -> None:
        """Begin `measure` (from 0): change the shot on the line of a phrase, and compare directions before the next."""
        if not self.running or self._parameters.held:
            return
        mood, present = self.mood, self._subjects.present()
        if self._begins_phrase(measure, mood) and self._shot_s >= mood.shortest_s:
            self._due = measure + LATEST
        if self._due >= measure and (self._due == measure or self._subjects.begins_step(present) >= STEP_SHARE):
            self._due = -1
            self._change(measure, mood)
        if self._begins_phrase(measure + 1, mood):
            self._compare(measure, now)

    def _begins_phrase(self, measure: int, mood: CameraMood) -> bool:
        """Whether a phrase begins with a measure: a section, or every `mood.measures` within it."""
        place = self._score_runner.playhead.ahead(measure)
        return (measure if place.section == END else place.measure) % mood.measures == 0

    # -- shots -------------------------------------------------------------------------------------------------------

    def _begin(self, now: Now, *, cut: bool) -> None:
        """Take over the camera, at once or with a move from where it is."""
        self.running = True
        self._stand_for(now.span.number, now.danced_beats)
        assert self._comparison is not None
        self._comparison.work(FIRST_COMPARED if len(self._chosen) <= MANY else FIRST_COMPARED // 3)
        row = self._parameters.picture
        if not cut:
            self._pose = pose_of_camera(row)
            self._eye, self._target = row[picture_parameters.EYE].copy(), row[picture_parameters.TARGET].copy()
            self._eye_goal = self._eye
            self._aim = self._pose.copy()
            self._lens = row[LENS].copy()
        self._speed = np.zeros(7)
        frames = self._directions(TOTAL, self.mood)
        kind_frame = self._fit(TOTAL, *DIRECTIONS[frames[0]].tolist())
        self._take(TOTAL, kind_frame, 0.0 if cut else GIVE_BACK_MEASURES * self._beats)

    def _compare(self, measure: int, now: Now) -> None:
        """Begin to compare the directions for the phrase after `measure`, from where all will be a measure into it."""
        self._stand_for(measure + 1, (measure + 2) * float(self._beats))

    def _stand_for(self, measure: int, beat: float) -> None:
        subjects, present = self._subjects, self._subjects.present()
        draw = generator_for(self._seed, Purpose.SHOT, measure).uniform(0.0, 1.0, 2)
        chosen = np.stack([choose(subject, subjects, present, draw) for subject in SUBJECTS])
        if np.array_equal(chosen[1], present):
            chosen[1] = False  # one dancer alone is the formation
        place = subjects.coming_places(beat, 0.0, planned=True)
        self._comparison = ViewComparison(self._framing, Stand(place, subjects.headings(), present, chosen))

    def _change(self, measure: int, mood: CameraMood) -> None:
        """Choose the next shot, and cut or move to it."""
        if self._comparison is None or not self._comparison.done:
            return
        chance = generator_for(self._seed, Purpose.SHOT, measure)
        chance.uniform(0.0, 1.0, 2)  # those of the subjects
        place = self._score_runner.playhead.ahead(measure)
        kind = self._next_kind(mood, float(chance.uniform()), opens=place.measure == 0)
        good = self._directions(kind, mood)
        order = [good[at] for at in chance.permutation(len(good)).tolist()]
        cut = float(chance.uniform()) < mood.cuts
        drift = float(chance.uniform(0.5, 1.0)) * math.radians(mood.drift_deg) / self._beats
        frame = self._pick(kind, order, cut=cut)
        if frame is None and cut:
            frame = self._pick(kind, self._directions(kind, mood, GOOD_ENOUGH), cut=True)
        if frame is None and cut:
            cut, frame = False, self._pick(kind, order, cut=False)
        if frame is None:
            return
        same = kind is self.kind and np.array_equal(self._chosen_for(kind), self._chosen)
        if same and not cut and turn_between(frame, self._frame) < NO_CHANGE:
            return
        self._take(kind, frame, 0.0 if cut else mood.move_beats)
        self.cuts += cut
        self._drift = -math.copysign(drift, frame.bearing)

    def _next_kind(self, mood: CameraMood, draw: float, *, opens: bool) -> ShotKind:
        """Return the kind of the next shot, drawn with a number from 0 to 1."""
        assert self._comparison is not None
        weights = []
        for kind, weight in mood.weights:
            if not self._comparison.is_seen(kind.subject):
                weight = 0.0
            elif kind.subject == "all":
                weight *= 3.0 if opens and kind is TOTAL else 1.0
            elif opens or (not self.kind.whole and kind.subject == self.kind.subject):
                weight = 0.0
            if kind is self.kind and mood.cuts:
                weight *= 0.4
            weights.append(weight)
        total = sum(weights)
        if total <= 0.0:
            return TOTAL
        at = int(np.searchsorted(np.cumsum(weights), draw * total, side="right"))
        return mood.weights[min(at, len(weights) - 1)][0]

    def _directions(self, kind: ShotKind, mood: CameraMood, tolerance: float = NEAR_BEST) -> list[int]:
        """Return the directions from which a shot is read best, or worse by at most `tolerance`: the best one first, at
        least one."""
        assert self._comparison is not None
        score = self._comparison.score[SUBJECTS.index(kind.subject)].copy()
        bearing, elevation = np.degrees(DIRECTIONS).T
        low, high = kind.elevation_deg
        out = (elevation < low - 0.5) | (elevation > high + 0.5) | (np.abs(bearing) > mood.widest_deg + 0.5)
        score[out] = NOT_COMPARED
        best = float(score.max())
        if best < -HIDDEN:
            return [0]
        good = np.flatnonzero(score >= best - tolerance)
        return [int(at) for at in good[np.argsort(-score[good], kind="stable")]]

    def _pick(self, kind: ShotKind, order: list[int], *, cut: bool) -> Frame | None:
        """Return the first frame that may follow the present one with a cut, or with a move; None if there is none."""
        present, places, there = self._present_frame(), self._subjects.places(), self._subjects.present()
        for at in order:
            frame = self._fit(kind, *DIRECTIONS[at].tolist())
            if keep_clear(frame.eye, places, there, CLEARANCE, LOWEST_EYE) > IN_THE_WAY:
                continue
            turn, ratio = turn_between(frame, present), frame.extent / present.extent
            if not cut:
                if turn <= FARTHEST_MOVE:
                    return frame
            elif (turn >= LEAST_TURN or max(ratio, 1.0 / ratio) >= SIZE_RATIO) and self._keeps_line(kind, frame):
                return frame
        return None

    def _keeps_line(self, kind: ShotKind, frame: Frame) -> bool:
        """Whether a cut to a frame stays on its side of the line of action.

        Between the public and the stage all directions do. Two partners have a line of their own.
        """
        chosen = self._chosen_for(kind)
        if np.count_nonzero(chosen) != 2 or not np.array_equal(chosen, self._chosen):
            return True
        one, other = self._subjects.places()[chosen]
        line = math.atan2(other[0] - one[0], other[1] - one[1])
        before, after = math.sin(self._present_frame().bearing - line), math.sin(frame.bearing - line)
        return before * after > 0.0 or min(abs(before), abs(after)) < math.sin(NEUTRAL)

    def _present_frame(self) -> Frame:
        pose = self._pose
        return Frame(pose[:3].copy(), math.exp(pose[3]), float(pose[4]), float(pose[5]), float(pose[6]))

    def _chosen_for(self, kind: ShotKind) -> Bool:
        assert self._comparison is not None
        return self._comparison.stand.of(kind.subject)

    def _fit(self, kind: ShotKind, bearing: float, elevation: float) -> Frame:
        """Return the frame of a shot in the direction of a comparison, of its subject now."""
        if kind.aimed_deg is not None:
            elevation = math.radians(kind.aimed_deg)
        chosen = self._chosen_for(kind) & self._subjects.present()
        return self._framing.fit(kind, self._subjects.places(), chosen, bearing, elevation, self._subjects.top(chosen))

    def _take(self, kind: ShotKind, frame: Frame, beats: float) -> None:
        """Begin a shot, with a cut or with a move of so many beats."""
        self._kind, self._frame, self._chosen = KINDS.index(kind), frame, self._chosen_for(kind).copy()
        self._shot_s, self._drift = 0.0, 0.0
        self._moved, self._length = 0.0, max(beats, 1e-9)
        if beats > 0.0:
            self._from = self._pose.copy()
            return
        self._pose, self._aim, self._speed, self._moved = frame.numbers, frame.numbers, np.zeros(7), 1.0
        self._lens[:] = NEUTRAL_LENS
        self._has_cut = True

    # -- motion ------------------------------------------------------------------------------------------------------

    def _turn(self, beats: float) -> None:
        """Turn slowly around the dancers."""
        if self._drift and abs(self._frame.bearing + self._drift * beats) < math.radians(70.0):
            self._frame = replace(self._frame, bearing=self._frame.bearing + self._drift * beats)

    def _reframe(self, now: Now) -> None:
        """Frame the dancers anew if the present frame does not show them well now and soon."""
        subjects, kind, present = self._subjects, self.kind, self._subjects.present()
        if kind.subject == "all":
            self._chosen = present
        chosen = self._chosen & present
        if not chosen.any() and present.any():  # whom it showed has left
            self._kind, self._chosen, kind, chosen = KINDS.index(TOTAL), present, TOTAL, present
            self._from, self._moved, self._length = self._pose.copy(), 0.0, float(self._beats)
        ahead = AHEAD_S if kind.whole else AHEAD_NEAR_S
        beat = now.danced_beats + ahead * now.timeline.tempo / 60.0
        places = np.concatenate([subjects.places(), subjects.coming_places(beat, ahead, planned=False)])
        both = np.concatenate([chosen, chosen])
        build = self._score_runner.mood.value("build") if self.mood.push else 0.0
        self._push = damper(self._push, self.mood.push * build, BUILD_HALFLIFE, FRAME_TICKS * TICK)
        pushed = replace(self._frame, distance=self._frame.distance * (1.0 - self._push))
        top = subjects.top(chosen)
        if not self._framing.stands(kind, places, both, pushed, top):
            self._frame = self._framing.fit(kind, places, both, self._frame.bearing, self._frame.elevation, top)

    def _move(self, seconds: float, beats: float) -> None:
        """Move towards the frame, keep away from bodies, and write the camera."""
        goal = self._frame.numbers
        goal[3] += math.log(1.0 - self._push)
        stiffness = self.kind.stiffness
        if self._moved < self._length:
            self._moved += beats
            share = ease(self._moved / self._length)
            goal[4] = self._from[4] + math.remainder(goal[4] - self._from[4], math.tau)
            goal, stiffness = self._from + (goal - self._from) * share, max(stiffness, 4.0)
        self._aim += (goal - self._aim) * (1.0 - math.exp(-seconds / SOFTENING_S))  # frames change in steps
        spring(self._pose, self._speed, self._aim, stiffness, seconds)
        pose = self._pose
        target = pose[:3].copy()
        eye = self._clear_eye(target + math.exp(pose[3]) * direction(pose[4], pose[5]), seconds)
        if self._has_cut:
            self._way[:], self._has_cut = 0.0, False
        else:
            self._way[:3], self._way[3:] = (eye - self._eye) / seconds, (target - self._target) / seconds
        self._eye, self._target = eye, target
        share = ease(self._moved / self._length) if self._length > 1e-6 else 1.0
        lens = self._lens + (NEUTRAL_LENS - self._lens) * share
        if share >= 1.0:
            self._lens[:] = NEUTRAL_LENS
        self._parameters.direct_camera(np.array([*eye, *target, pose[6], *lens, 0.0, 0.0, 0.0], np.float64))

    def _clear_eye(self, goal: Float64, seconds: float) -> Float64:
        """Return the eye on its way to `goal` [m], out of all bodies: it goes on from where it was, so that it slides
        around a body instead of jumping to its other side."""
        eye, before = goal.copy(), self._eye_goal
        if not self._has_cut:
            way = goal - self._eye
            step, most = math.dist(goal, self._eye), CATCH_UP * math.dist(goal, before) + CATCH_UP_SPEED * seconds
            eye = self._eye + way * min(1.0, most / max(step, 1e-9))
        self._eye_goal = goal
        keep_clear(eye, self._subjects.places(), self._subjects.present(), CLEARANCE, LOWEST_EYE)
        if not self._has_cut:
            rise = eye[1] - self._eye[1]
            eye[1] = self._eye[1] + min(rise, abs(goal[1] - before[1]) * CATCH_UP + CATCH_UP_SPEED * seconds)
        return eye

    def place(self, row: Float64, seconds: float) -> None:
        """Move the camera of a picture's `row` to its position this long after the last tick."""
        if self.running:
            row[picture_parameters.EYE] += self._way[:3] * seconds
            row[picture_parameters.TARGET] += self._way[3:] * seconds

    # -- reports -----------------------------------------------------------------------------------------------------

    def hashed(self) -> tuple[Float64, ...]:
        """Return the arrays that belong to the state hash; none while it does not lead."""
        return (self._pose, self._speed) if self.running else ()

    def status_lines(self) -> tuple[str, ...]:
        """Return the overlay's line: the shot, or that the camera is locked."""
        if self.locked:
            return ("camera locked: it matches the hall",)
        return (f"camera: director, {self.mood.name}, {self.kind.name}",) if self.running else ()

    def facts(self) -> dict[str, Any]:
        """Return mood, shot and its dancers, by number from 1, for the status."""
        shown = {
            "mood": self.mood.name,
            "shot": self.kind.name,
            "dancers": (np.flatnonzero(self._chosen) + 1).tolist() if self.kind.subject != "all" else "*",
            "cuts": self.cuts,
        }
        return {"camera": {"locked": self.locked, "director": shown if self.running else None}}


def pose_of_camera(row: Float64) -> Float64:
    """Return target, logarithm of the distance, bearing, elevation and field of view of a row's camera, shape (7,)."""
    eye, target = row[picture_parameters.EYE], row[picture_parameters.TARGET]
    x, y, z = (eye - target).tolist()
    far = max(math.sqrt(x * x + y * y + z * z), 1e-3)
    bearing, elevation = math.atan2(x, z), math.asin(min(max(y / far, -1.0), 1.0))
    return np.array([*target, math.log(far), bearing, elevation, row[picture_parameters.FIELD_OF_VIEW]], np.float64)
