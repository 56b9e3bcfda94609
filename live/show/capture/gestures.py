"""Gestures and movement of captured performers: signals, and numbers that values follow (`[[gesture]]`, `[[react]]`).

Everything follows from MocapFrame and LearnGesture events, so a replay gives the same signals. Examples are learned in
pieces, one in a tick (`gesture_learning`): four beats can be found about a second later.
"""

from collections import deque
from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.base.errors import PersonError
from live.clock.energy.energy_frames import AdaptiveRange
from live.control.events.capture import LearnGesture
from live.control.events.event import ControlEvent
from live.control.events.events import Signal
from live.motion.recognition.body_stream import BodyStream
from live.motion.recognition.built_in_gestures import BuiltInGestures
from live.motion.recognition.example_follower import ExampleFollower
from live.motion.recognition.gesture_examples import (
    EXAMPLE_RATE,
    MOMENTS_PER_EXAMPLE_MOMENT,
    ExampleBank,
    GestureExample,
    check_length,
    make_examples,
)
from live.motion.recognition.movement import Movement
from live.motion.recognition.recognition_names import LEVELS, MAX_MOMENTS, MIN_MOMENTS
from live.motion.skeleton import JOINT_COUNT
from live.show.capture.gesture_learning import (
    MAX_LESSONS,
    LearnedGesture,
    Lesson,
    Lessons,
    lesson_work,
    step_motions,
)
from live.show.patch.gesture_files import GUARD_S, beats_to_moments, pose_features
from live.show.patch.patch import Patch
from live.show.patch.section_capture import MAX_GESTURES
from live.show.patch.section_music import PERFORMER_PREFIX
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.capture.capture_manager import CaptureManager
    from live.show.capture.performer import CapturedPerformer
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.score.music_reactions import Reactions
    from live.show.score.score_runner import ScoreRunner

SOURCE: Final = "gesture"
TELL_TICKS: Final = 8
"""Ticks between two values that follow a performer: an eighth of a second."""
WIDEN_TICKS: Final = 32
"""Ticks between two updates of the range so far."""
RANGES: Final = ((0.3, 3.0), (0.03, 0.5), (0.3, 4.0), (0.1, 1.0))
"""Narrowest and widest range of each of `LEVELS`, in their units."""
TEMPO_SPAN: Final = (60.0, 180.0)
"""Tempi that give 0 and 1 [bpm]."""
KEPT: Final = 8
"""Last gestures in the status."""
ANYBODY: Final = ""
MAX_BACKGROUND: Final = 64
"""Poses of the background of a learned example: four seconds."""
MAX_PIECES: Final = 1 << 16
"""More pieces than any lesson has."""
Takes = tuple[list[Float64], list[Float64]]
"""Features of the examples of a gesture, and of what is not it."""


class PerformerMovement:
    """What one performer does. Thread: the show's."""

    def __init__(self, bank: ExampleBank, gesture: list[int]) -> None:
        self.stream = BodyStream()
        self.built_in = BuiltInGestures()
        self.movement = Movement()
        self.examples = ExampleFollower(bank, gesture)
        self.ranges = [AdaptiveRange(*limits, first=0.0) for limits in RANGES]
        self._hips: Float32 = np.zeros((MAX_MOMENTS, 3), np.float32)
        self._rotation: Float32 = np.zeros((MAX_MOMENTS, JOINT_COUNT, 4), np.float32)
        self._kept = 0

    def follow(
        self, captured: "CapturedPerformer", likely_bpm: float, wanted: Container[str]
    ) -> tuple[list[str], list[int]]:
        """Take the newest pose, if there is a new one; return the known gestures by name, and those with examples by
        number, that are made now. `wanted`: the known ones that matter."""
        poses = captured.poses
        last = poses.last
        if last <= self.stream.time:
            return [], []
        hips, rotation = poses.newest
        known: list[str] = []
        told: list[int] = []
        for _ in self.stream.feed(hips, rotation, last):
            known += self.built_in.follow(self.stream.measure, wanted)
            self.movement.follow(self.stream.measure, likely_bpm)
            if self.stream.count % MOMENTS_PER_EXAMPLE_MOMENT == 0:
                told += self.examples.step(self.stream.feature)
                row = self._kept % MAX_MOMENTS
                self._hips[row], self._rotation[row] = hips, rotation
                self._kept += 1
        if not self.stream.count:  # after a gap
            self.built_in.reset()
            self.movement.reset()
            self.examples.reset()
            self._kept = 0
        return known, told

    def lesson(self, name: str, moments: int) -> Lesson:
        """Return a lesson of the last so many poses and the kept ones before them; PersonError if there are fewer."""
        kept = min(self._kept, MAX_MOMENTS)
        if kept < max(moments, MIN_MOMENTS):
            raise PersonError(
                f"the performer was seen for {kept / EXAMPLE_RATE:.1f} s only", "show the gesture first, then learn it"
            )
        before = min(max(kept - moments - round(GUARD_S * EXAMPLE_RATE), 0), MAX_BACKGROUND)
        before = before if before > moments else 0
        first = self._kept - moments - round(GUARD_S * EXAMPLE_RATE) - before
        numbers = np.concatenate([np.arange(first, first + before), np.arange(self._kept - moments, self._kept)])
        rows = numbers % MAX_MOMENTS
        return Lesson(name, self._hips[rows], self._rotation[rows], before)

    def values(self) -> dict[str, float]:
        """Return the numbers of the movement, 0 to 1."""
        found = {}
        for name, value, span in zip(LEVELS, self.movement.level.tolist(), self.ranges, strict=True):
            width = span.high - span.low
            found[name] = min(max((value - span.low) / width, 0.0), 1.0) if width > 0.0 else 0.0
        if self.movement.tempo:
            low, high = TEMPO_SPAN
            found["tempo"] = min(max((self.movement.tempo - low) / (high - low), 0.0), 1.0)
        return found

    def widen_ranges(self) -> None:
        """Update the ranges by the present movement."""
        for span, value in zip(self.ranges, self.movement.level.tolist(), strict=True):
            span.add(value)


class Gestures:
    """Gestures and movement of all performers of one show. Thread: the show's."""

    EVENTS = (LearnGesture,)

    def __init__(
        self,
        patch: Patch,
        mocap: "CaptureManager",
        reactions: "Reactions",
        score_runner: "ScoreRunner",
        motion: "GroupMotion",
        dancers: "Dancers",
    ) -> None:
        self._dancers = dancers
        self._mocap, self._reactions = mocap, reactions
        self._score_runner, self._motion = score_runner, motion
        self._patch = patch
        self.learned: list[LearnedGesture] = []
        """Examples learned in this show that its patch does not have yet."""
        self.learned_count = 0
        """Number of examples learned so far."""
        self._followers: dict[str, PerformerMovement] = {}
        self._ticks = 0
        self.last: deque[tuple[str, str, float]] = deque(maxlen=KEPT)
        """The last gestures: name, performer and time [s]."""
        self._names: list[str] = []
        self._performers: list[str] = []
        self._known: dict[str, list[tuple[str, str]]] = {}
        self._gesture: list[int] = []
        self._bank = ExampleBank.of([])
        self._clips_read = 0
        """Clips of the library with which examples are compared: those at the last start or edit of the patch."""
        self._library: list[Float64] = []
        if patch.mocap or patch.gesture:
            self._clips_read = len(dancers.graph.library.clips)
        self._lessons: list[Lesson] = []
        self._pieces = 0
        """Pieces of the first lesson that are done."""
        self._work: Lessons | None = None
        self.repeat_work()
        self._prepare()

    def _prepare(self) -> None:
        """Prepare the gestures of patch and learned examples; PersonError, with its place, for damaged poses."""
        takes: dict[tuple[str, str], Takes] = {}
        self._known = {}
        tables = [(one.name, one.performer or ANYBODY, one.poses, one.background) for one in self._patch.gesture]
        for index, (name, performer, poses, background) in enumerate(
            [*tables, *((one.name, ANYBODY, one.poses, one.background) for one in self.learned)]
        ):
            movement = self._patch.gesture[index].movement if index < len(tables) else None
            if movement is not None:
                self._known.setdefault(movement, []).append((name, performer.casefold()))
                continue
            found, back = takes.setdefault((name, performer.casefold()), ([], []))
            try:
                found.append(pose_features(poses))
                back += [pose_features(background)] if background else []
                check_length(len(found[-1]))
            except ValueError as error:
                words = f"gesture {name!r}: the example cannot be read: {error}"
                raise PersonError(words, "learn it again", ("gesture", index, "poses")) from None
        self._names, self._performers = [name for name, _ in takes], [performer for _, performer in takes]
        examples, self._gesture = [], []
        for number, (found, back) in enumerate(takes.values()):
            made = make_examples(found, back, self._library)
            examples += made
            self._gesture += [number] * len(made)
        self._bank = ExampleBank.of(examples)

    def _examples_of(self, name: str) -> list[LearnedGesture]:
        """Return the known examples of a gesture of anybody: those of the patch, then those learned since."""
        written = [one for one in self._patch.gesture if one.poses and not one.performer]
        every = [*(LearnedGesture(one.name, one.poses, one.background) for one in written), *self.learned]
        return [one for one in every if one.name == name]

    def _replace(self, name: str, made: Sequence[GestureExample]) -> None:
        """Use these examples of a gesture of anybody; those of the others stay."""
        keys = list(zip(self._names, self._performers, strict=True))
        if (name, ANYBODY) not in keys:
            keys.append((name, ANYBODY))
            self._names.append(name)
            self._performers.append(ANYBODY)
        number = keys.index((name, ANYBODY))
        kept = [example for example, of in zip(self._bank.examples(), self._gesture, strict=True) if of != number]
        self._gesture = [of for of in self._gesture if of != number] + [number] * len(made)
        self._bank = ExampleBank.of([*kept, *made])

    def _present(self, name: str) -> list[GestureExample]:
        """Return the examples of a gesture of anybody that are in use."""
        keys = list(zip(self._names, self._performers, strict=True))
        return [
            example for example, of in zip(self._bank.examples(), self._gesture, strict=True)
            if keys[of] == (name, ANYBODY)
        ]  # fmt: skip

    def apply_patch(self, fresh: "Gestures") -> None:
        """Adopt the gestures of an edited patch; what was learned and is not in it stays, and lessons begin anew."""
        written = {(one.name, one.poses) for one in fresh._patch.gesture}
        self.learned = [one for one in self.learned if (one.name, one.poses) not in written]
        kept = {one.name: self._present(one.name) for one in self.learned}
        same = fresh._patch.gesture == self._patch.gesture
        self._patch, self._library, self._clips_read = fresh._patch, fresh._library, fresh._clips_read
        self._pieces, self._work = 0, None
        for name in dict.fromkeys([*kept, *(lesson.name for lesson in self._lessons if lesson.is_new)]):
            self._score_runner.add_signal(name)
        if same:
            return
        self._known, self._bank = fresh._known, fresh._bank
        self._names, self._performers = list(fresh._names), list(fresh._performers)
        self._gesture = list(fresh._gesture)
        for name, examples in kept.items():
            self._replace(name, examples)
        none = np.zeros((0, 3), np.float32), np.zeros((0, JOINT_COUNT, 4), np.float32)
        new = [lesson for lesson in self._lessons if lesson.is_new]
        self._lessons = new + [Lesson(name, *none, 0) for name in kept]
        self._restart()

    def _restart(self) -> None:
        for each in self._followers.values():
            each.examples = ExampleFollower(self._bank, self._gesture)

    def repeat_work(self) -> None:
        """Read the library's steps, and do the pieces of the first lesson again, after a snapshot was read."""
        self._library, self._work = [], None
        if self._clips_read:
            self._library = step_motions(self._dancers.graph.library, self._clips_read)
        if self._pieces:
            self._work = self._new_work()
            for _ in range(self._pieces):
                next(self._work)

    def _new_work(self) -> Lessons:
        lesson = self._lessons[0]
        return lesson_work(lesson, self._examples_of(lesson.name), self._library)

    def _go_on_learning(self) -> None:
        """Do the next piece of the first lesson."""
        if self._work is None:
            self._work = self._new_work()
        try:
            next(self._work)
        except StopIteration as over:
            learned, examples = over.value
            lesson = self._lessons.pop(0)
            self._pieces, self._work = 0, None
            if learned is not None:
                self.learned.append(learned)
                self.learned_count += 1
            self._replace(lesson.name, examples)
            self._restart()
        else:
            self._pieces += 1

    def handle(self, event: LearnGesture, now: Now) -> None:
        """Begin to learn the last beats of a performer as an example; PersonError if there is no such performer or
        motion."""
        follower = self._follower(event.performer)
        lessons = sum(lesson.is_new for lesson in self._lessons)
        if len(self._patch.gesture) + len(self.learned) + lessons >= MAX_GESTURES:
            raise PersonError(f"there are {MAX_GESTURES} gestures already", "take some out of the patch")
        if lessons >= MAX_LESSONS:
            raise PersonError(f"{MAX_LESSONS} gestures are being learned", "wait until they can be found")
        name = event.name.strip()
        if not name:
            raise PersonError("the gesture has no name", "/dance/gesture/learn NAME")
        self._lessons.append(follower.lesson(name, beats_to_moments(event.beats, now.timeline.tempo)))
        self._score_runner.add_signal(name)

    def _follower(self, name: str) -> PerformerMovement:
        seen = {key.casefold(): each for key, each in self._followers.items()}
        if not seen:
            raise PersonError("no performer is seen", "a camera or a suit: see `live docs mocap`")
        if not name.strip():
            return max(seen.values(), key=lambda each: each.stream.time)
        if name.strip().casefold() not in seen:
            raise PersonError(f"no performer is called {name[:60]!r}", f"there are: {', '.join(self._followers)}")
        return seen[name.strip().casefold()]

    def tick(self, now: Now) -> list[ControlEvent]:
        """Follow all performers to this tick; return the signals of their gestures, and values that follow them."""
        self._ticks += 1
        if self._lessons:
            self._go_on_learning()
        signals: list[str] = []
        for name, captured in self._mocap.performers.items():
            if not captured.poses.count:
                continue
            follower = self._followers.get(name)
            if follower is None:
                follower = self._followers[name] = PerformerMovement(self._bank, self._gesture)
            known, told = follower.follow(captured, now.timeline.tempo, self._known)
            folded = name.casefold()
            made = [gesture for movement in known for gesture, whose in self._known.get(movement, ())
                    if whose in (ANYBODY, folded)]  # fmt: skip
            made += [self._names[number] for number in told if self._performers[number] in (ANYBODY, folded)]
            for gesture in dict.fromkeys(made):
                self.last.append((gesture, name, now.time))
                signals.append(gesture)
            if self._ticks % WIDEN_TICKS == 0:
                follower.widen_ranges()
        events: list[ControlEvent] = [
            Signal(time=now.time, source=SOURCE, name=name) for name in dict.fromkeys(signals)
        ]
        if self._followers and self._ticks % TELL_TICKS == 0 and self._reactions.follows_performers:
            beats = TELL_TICKS / 64.0 * now.timeline.tempo / 60.0
            events += self._reactions.handle_movement(now.time, self._levels(), beats)
            self._motion.elements.gain = self._reactions.strength
        return events

    def _levels(self) -> Mapping[str, float]:
        """Return the numbers of all performers, by the words of `[[react]] to`; without a name the highest."""
        found: dict[str, float] = {}
        for performer, follower in self._followers.items():
            for name, value in follower.values().items():
                found[f"{PERFORMER_PREFIX}{performer.casefold()}/{name}"] = value
                whole = PERFORMER_PREFIX + name
                found[whole] = max(value, found.get(whole, 0.0))
        return found

    def facts(self) -> dict[str, Any]:
        """Return for the status: the last gestures, newest first, and each performer's movement."""
        return {
            "last": [
                {"name": name, "performer": who, "time": round(time, 2)} for name, who, time in reversed(self.last)
            ],
            "learned": self.learned_count,
            "learning": [lesson.name for lesson in self._lessons if lesson.is_new],
            "movement": {
                name: {"bpm": round(each.movement.tempo, 1)}
                | {key: round(value, 2) for key, value in each.values().items()}
                for name, each in self._followers.items()
            },
        }
