"""Gestures and movement of captured performers: signals, and numbers that values follow (`[[gesture]]`, `[[react]]`).

Everything follows from MocapFrame and LearnGesture events, so a replay gives the same signals. Examples are learned
within a tick: an example of 16 beats takes a few milliseconds, once.
"""

from collections import deque
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.base.errors import PersonError
from live.clock.energy.energy_frames import AdaptiveRange
from live.control.events.capture import LearnGesture
from live.control.events.event import ControlEvent
from live.control.events.events import Signal
from live.motion.capture.packed_pose import pack_pose
from live.motion.recognition.body_stream import BodyStream
from live.motion.recognition.built_in_gestures import BuiltInGestures
from live.motion.recognition.example_follower import ExampleFollower
from live.motion.recognition.gesture_examples import (
    EXAMPLE_RATE,
    MOMENTS_PER_EXAMPLE_MOMENT,
    ExampleBank,
    check_length,
    make_examples,
)
from live.motion.recognition.movement import Movement
from live.motion.recognition.recognition_names import LEVELS, MAX_MOMENTS, MIN_MOMENTS
from live.motion.skeleton import JOINT_COUNT
from live.show.patch.gesture_files import beats_to_moments, pose_features
from live.show.patch.patch import Patch
from live.show.patch.section_capture import MAX_GESTURES
from live.show.patch.section_music import PERFORMER_PREFIX
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.capture.capture_manager import CaptureManager
    from live.show.capture.performer import CapturedPerformer
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
"""Poses of the background of a learned example: four seconds, so that learning takes a few milliseconds."""
Takes = tuple[list[Float64], list[Float64]]
"""Features of the examples of a gesture, and of what is not it."""


@dataclass(frozen=True, slots=True)
class LearnedGesture:
    """An example that was learned in this show."""

    name: str
    poses: tuple[str, ...]
    """Packed poses at `EXAMPLE_RATE`."""
    background: tuple[str, ...]
    """What she did before it."""

    @property
    def table(self) -> dict[str, Any]:
        """As a `[[gesture]]` of the patch."""
        rows = {"name": self.name, "poses": list(self.poses)}
        return rows | ({"background": list(self.background)} if self.background else {})


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
        if not poses.count or poses.last <= self.stream.time:
            return [], []
        hips, rotation = poses.newest
        known: list[str] = []
        told: list[int] = []
        for _ in self.stream.feed(hips, rotation, poses.last):
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

    def last_poses(self, moments: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return the last so many poses, packed, and the kept ones before them; PersonError if there are fewer."""
        kept = min(self._kept, MAX_MOMENTS)
        if kept < max(moments, MIN_MOMENTS):
            raise PersonError(
                f"the performer was seen for {kept / EXAMPLE_RATE:.1f} s only", "show the gesture first, then learn it"
            )
        rows = [number % MAX_MOMENTS for number in range(self._kept - kept, self._kept)]
        rows = rows[-(moments + MAX_BACKGROUND + round(0.5 * EXAMPLE_RATE)) :]
        kept = len(rows)
        packed = [pack_pose(self._hips[row], self._rotation[row]) for row in rows]
        before = packed[: max(kept - moments - round(0.5 * EXAMPLE_RATE), 0)][-MAX_BACKGROUND:]
        return tuple(packed[kept - moments :]), tuple(before if len(before) > moments else ())

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
    ) -> None:
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
            made = make_examples(found, back)
            examples += made
            self._gesture += [number] * len(made)
        self._bank = ExampleBank.of(examples)

    def _add(self, name: str) -> None:
        """Prepare the examples of one gesture of anybody anew; those of the others stay, because that takes long."""
        if (name, ANYBODY) not in zip(self._names, self._performers, strict=True):
            self._names.append(name)
            self._performers.append(ANYBODY)
        number = list(zip(self._names, self._performers, strict=True)).index((name, ANYBODY))
        written = [one for one in self._patch.gesture if one.poses and not one.performer]
        takes = [(one.name, one.poses, one.background) for one in written]
        takes += [(one.name, one.poses, one.background) for one in self.learned]
        back = [pose_features(background) for known, _, background in takes if known == name and background]
        made = make_examples([pose_features(poses) for known, poses, _ in takes if known == name], back)
        kept = [example for example, of in zip(self._bank.examples(), self._gesture, strict=True) if of != number]
        self._gesture = [of for of in self._gesture if of != number] + [number] * len(made)
        self._bank = ExampleBank.of([*kept, *made])

    def apply_patch(self, fresh: "Gestures") -> None:
        """Adopt the gestures of an edited patch; what was learned and is not in it stays."""
        written = {(one.name, one.poses) for one in fresh._patch.gesture}
        self.learned = [one for one in self.learned if (one.name, one.poses) not in written]
        for one in self.learned:
            self._score_runner.add_signal(one.name)
        if fresh._patch.gesture == self._patch.gesture:
            return
        self._patch = fresh._patch
        self._prepare()
        self._restart()

    def _restart(self) -> None:
        for each in self._followers.values():
            each.examples = ExampleFollower(self._bank, self._gesture)

    def handle(self, event: LearnGesture, now: Now) -> None:
        """Learn the last beats of a performer as an example; PersonError if there is no such performer or motion."""
        follower = self._follower(event.performer)
        if len(self._patch.gesture) + len(self.learned) >= MAX_GESTURES:
            raise PersonError(f"there are {MAX_GESTURES} gestures already", "take some out of the patch")
        poses, before = follower.last_poses(beats_to_moments(event.beats, now.timeline.tempo))
        name = event.name.strip()
        if not name:
            raise PersonError("the gesture has no name", "/dance/gesture/learn NAME")
        self.learned.append(LearnedGesture(name, poses, before))
        self.learned_count += 1
        self._score_runner.add_signal(name)
        self._add(name)
        self._restart()

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
            "movement": {
                name: {"bpm": round(each.movement.tempo, 1)}
                | {key: round(value, 2) for key, value in each.values().items()}
                for name, each in self._followers.items()
            },
        }
