"""Learning of gestures in small pieces, one in a tick, so that no frame waits for it.

The pieces of a lesson follow from the show's state alone. So a replay does the same piece in the same tick, and a show
that goes on from a snapshot first repeats those that were done.
"""

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.graph.step_library import StepLibrary
from live.motion.capture.packed_pose import pack_poses
from live.motion.clip import read_clip
from live.motion.editing.path_bend import source_name
from live.motion.recognition.gesture_examples import EXAMPLE_RATE, GestureExample, example_work
from live.motion.step_clip import StepClip
from live.show.patch.gesture_files import feature_work, features_of

POSES_PER_PIECE: Final = 12
"""Poses that are packed in a piece: about 0.1 ms."""
MAX_LESSONS: Final = 8
"""Most gestures that are learned at a time."""
MAX_STEPS: Final = 32
"""Steps of the library that are compared with an example, at most; evenly drawn from more."""
MAX_STEP_MOMENTS: Final = 128
"""Moments of a step, at most: eight seconds."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """A gesture that is being learned, or whose examples are prepared anew."""

    name: str
    hips: Float32
    """Hips of its poses [m] at `EXAMPLE_RATE`, background first, (P, 3); none if nothing is new."""
    rotation: Float32
    """Their local rotations, (P, J, 4)."""
    background: int
    """How many of them are background."""

    @property
    def is_new(self) -> bool:
        """Whether it has an example that is not known yet."""
        return len(self.hips) > 0


Lessons = Generator[None, None, tuple[LearnedGesture | None, list[GestureExample]]]
"""Pieces of a lesson; what was learned, if it was new, and all examples of the gesture."""


def lesson_work(lesson: Lesson, known: Iterable[LearnedGesture], library: Sequence[Float64]) -> Lessons:
    """Learn a lesson in pieces of about 0.1 ms. `known`: the gesture's other examples; `library`: see
    `step_motions`."""
    found, learned = list(known), None
    if lesson.is_new:
        packed: list[str] = []
        for first in range(0, len(lesson.hips), POSES_PER_PIECE):
            last = first + POSES_PER_PIECE
            packed += pack_poses(lesson.hips[first:last], lesson.rotation[first:last])
            yield
        learned = LearnedGesture(lesson.name, tuple(packed[lesson.background :]), tuple(packed[: lesson.background]))
        found.append(learned)
    takes: list[Float64] = []
    background: list[Float64] = []
    for one in found:
        takes.append((yield from feature_work(one.poses)))
        if one.background:
            background.append((yield from feature_work(one.background)))
    return learned, (yield from example_work(takes, background, library))


def step_motions(library: StepLibrary, clips: int) -> list[Float64]:
    """Return the features of the steps among the first `clips` clips of a library, (M, FEATURES) each, one clip of each
    step: what other dance looks like."""
    found: dict[str, StepClip] = {}
    for clip in library.clips[:clips]:
        if not (clip.unjoined or clip.mirrored or source_name(clip.clip.name) != clip.clip.name):
            found.setdefault(clip.step, clip)
    steps = list(found.values())
    every = max(len(steps) / MAX_STEPS, 1.0)
    return [step_features(steps[int(number * every)]) for number in range(min(len(steps), MAX_STEPS))]


def step_features(step: StepClip) -> Float64:
    """Return the features of a step, (M, FEATURES)."""
    samples = step.samples_per_measure * step.measures
    moments = min(max(round(samples / step.clip.sample_rate * EXAMPLE_RATE), 1), MAX_STEP_MOMENTS)
    at = step.first + np.arange(moments) * (step.clip.sample_rate / EXAMPLE_RATE)
    root, rotation, _ = read_clip(step.clip, at)
    return features_of(zip(root.astype(np.float32), rotation.astype(np.float32), strict=True))
