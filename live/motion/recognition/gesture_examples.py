"""Gestures from examples: one or a few spans of poses, found again in a motion as it goes on.

An example is the features of a body (`body_stream`) 16 times a second, so its place, heading and body do not matter.
The joints that move in it, or are away from a standing body's, count more (weighted dynamic time warping, Celebi et al.
2013); `follow_examples` matches all of them at once, at half to twice their speed. The threshold of an example follows
from the steps of the library: how near other dance comes to it, and from background motion in which the gesture is not
made. It is where its limit begins, which then follows how near the performer's own dance usually comes to it.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int64
from live.motion.recognition.body_stream import RATE, BodyStream
from live.motion.recognition.gesture_kernels import COST, FEATURES, KEY_JOINTS, follow_examples
from live.motion.recognition.recognition_names import MAX_MOMENTS, MIN_MOMENTS
from live.motion.skeleton import JOINT_COUNT, SKELETON

EXAMPLE_RATE: Final = 16.0
"""Moments of an example per second."""
MOMENTS_PER_EXAMPLE_MOMENT: Final = round(RATE / EXAMPLE_RATE)
EVEN_SHARE: Final = 0.25
"""Share of the weight that all features have alike, whether they move in the example or not."""
POSE_SHARE: Final = 0.15
"""Weight of being away from a standing body's pose, against moving."""
START: Final = 0.026
"""Threshold of an example that is compared with no library [m²], the mean squared distance of a joint."""
LIBRARY_FACTOR: Final = 0.1
LIBRARY_POWER: Final = 0.35
"""A threshold is `LIBRARY_FACTOR` times the best match in the library [m²] to the power of `LIBRARY_POWER`."""
SAME_STEP: Final = 0.5
"""The nearest step of the library is taken for the gesture itself if it is nearer than this share of the next one."""
BACKGROUND_FACTOR: Final = 0.75
"""A threshold is at most this share of the best match in the background …"""
BACKGROUND_LIMIT: Final = 0.8
"""… but not lowered beyond this share of itself, because the gesture may be in the background after all."""
CELLS_PER_PIECE: Final = 3000
"""Work of a piece, in moments of an example that are compared with one moment of a motion: about 0.1 ms."""
STEP_CELLS: Final = 60
"""What a further moment of a motion costs besides, in the same unit."""
FAR: Final = 1e6
"""A sum that no match has."""


def rest_features() -> Float64:
    """Return the features of a standing body with its arms down, (FEATURES,)."""
    rotation = np.zeros((JOINT_COUNT, 4), np.float32)
    rotation[:, 0] = 1.0
    half = 0.5 * 1.35
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotation[SKELETON.index(f"{side}UpperArm")] = (np.cos(half), 0.0, 0.0, sign * np.sin(half))
    stream = BodyStream()
    for _ in stream.feed(SKELETON.offsets[0].astype(np.float32), rotation, 0.0):
        pass
    return stream.feature.copy()


@dataclass(frozen=True, slots=True, eq=False)
class GestureExample:
    """One example, ready to be found (M moments, F features)."""

    moment: Float32
    """Features of its moments, (M, F)."""
    weight: Float32
    """Weight of each feature, (F,); those of one joint are the same, and the sum over joints is 1."""
    threshold: float
    """Mean cost of a match at most [m²], until more is known of the motion."""


def _weights(moments: Float64, rest: Float64) -> Float64:
    spread = moments.var(axis=0) + POSE_SHARE * ((moments - rest) ** 2).mean(axis=0)
    joints = np.concatenate([spread[: 3 * KEY_JOINTS].reshape(-1, 3).sum(axis=1), spread[3 * KEY_JOINTS :]])
    share = (1.0 - EVEN_SHARE) * joints / max(joints.sum(), 1e-9) + EVEN_SHARE / len(joints)
    return np.concatenate([np.repeat(share[:KEY_JOINTS], 3), share[KEY_JOINTS:]])


def check_length(moments: int) -> None:
    """Raise ValueError, in words, for an example of too few or too many moments."""
    if not MIN_MOMENTS <= moments <= MAX_MOMENTS:
        shortest, longest = MIN_MOMENTS / EXAMPLE_RATE, MAX_MOMENTS / EXAMPLE_RATE
        raise ValueError(f"{moments / EXAMPLE_RATE:.2g} s; an example has {shortest:.2g} to {longest:g} s")


Made = TypeVar("Made")
Motions = Sequence[npt.NDArray[np.floating]]
"""Features of motions, (M, F) each, at `EXAMPLE_RATE`."""


def make_examples(takes: Motions, background: Motions = (), library: Motions = ()) -> list[GestureExample]:
    """Return the examples of one gesture, see `example_work`, at once."""
    return at_once(example_work(takes, background, library))


def at_once(work: Generator[None, None, Made]) -> Made:
    """Do all pieces of work; return what it makes."""
    while True:
        try:
            next(work)
        except StopIteration as over:
            made: Made = over.value
            return made


def example_work(
    takes: Motions, background: Motions = (), library: Motions = ()
) -> Generator[None, None, list[GestureExample]]:
    """Make the examples of one gesture from the features `takes` of each, in pieces of about `CELLS_PER_PIECE`.

    `background`: motions in which the gesture is not made; `library`: steps, each repeated without end, of which one
    may be the gesture; fewer than two tell nothing. Raises ValueError, in words, for a take that is too short or too
    long.
    """
    rest = rest_features()
    made: list[GestureExample] = []
    for take in takes:
        check_length(len(take))
    for take in takes:
        moments = np.ascontiguousarray(take, np.float32)
        weight = _weights(moments.astype(np.float64), rest).astype(np.float32)
        example = GestureExample(moments, weight, START)
        nearest = next_one = FAR
        for step in library:
            match = yield from _best_match(example, repeated(step, len(moments)))
            nearest, next_one = sorted((nearest, next_one, match))[:2]
        threshold = START
        if next_one < FAR:
            nearest = next_one if nearest < SAME_STEP * next_one else nearest
            threshold = LIBRARY_FACTOR * nearest**LIBRARY_POWER
        best = FAR
        for motion in background:
            best = min(best, (yield from _best_match(example, motion)))
        if best < FAR:
            threshold = min(threshold, max(BACKGROUND_FACTOR * best, BACKGROUND_LIMIT * threshold))
        made.append(GestureExample(moments, weight, threshold))
    return made


def repeated(step: npt.NDArray[np.floating], moments: int) -> npt.NDArray[np.floating]:
    """Return a step that goes on for so many moments more, at most three times."""
    return np.take(step, np.arange(len(step) + min(moments, 3 * len(step))) % len(step), axis=0)


def _best_match(example: GestureExample, motion: npt.NDArray[np.floating]) -> Generator[None, None, float]:
    """Find the mean cost of the best match of an example in a motion (M, F)."""
    matcher = ExampleMatcher(ExampleBank.of([example]))
    best = FAR
    every = max(CELLS_PER_PIECE // (len(example.moment) + STEP_CELLS), 1)
    for number, moment in enumerate(np.ascontiguousarray(motion, np.float64), 1):
        matcher.step(moment)
        best = min(best, float(matcher.mean[0]))
        if number % every == 0:
            yield
    yield
    return best


@dataclass(frozen=True, slots=True, eq=False)
class ExampleBank:
    """Examples in arrays, as the kernel takes them (E examples, N moments of all together)."""

    moment: Float32
    """(N, F)."""
    weight: Float32
    """(E, F)."""
    first: Int64
    """First moment of each, and the end, (E + 1,)."""
    threshold: Float64
    """(E,)."""

    @classmethod
    def of(cls, examples: Sequence[GestureExample]) -> "ExampleBank":
        """Return the arrays of some examples."""
        none = np.zeros((0, FEATURES), np.float32)
        return cls(
            np.concatenate([none, *(one.moment for one in examples)]),
            np.concatenate([none, *(one.weight[None] for one in examples)]),
            np.cumsum([0, *(len(one.moment) for one in examples)], dtype=np.int64),
            np.array([one.threshold for one in examples], np.float64),
        )

    def examples(self) -> list[GestureExample]:
        """Return the examples, as views."""
        return [
            GestureExample(self.moment[self.first[row] : self.first[row + 1]], self.weight[row], float(threshold))
            for row, threshold in enumerate(self.threshold)
        ]


class ExampleMatcher:
    """Matches of all examples of a bank with one motion. Thread: one at a time."""

    def __init__(self, bank: ExampleBank) -> None:
        self._bank = bank
        count, moments = len(bank.threshold), len(bank.moment)
        self.mean: Float64 = np.full(count, FAR)
        """Mean cost of the best match of each example that ends now [m²], (E,)."""
        self.begun: Int64 = np.zeros(count, np.int64)
        """The moment at which it began, (E,)."""
        self._memory: Float64 = np.full((3, moments), FAR)
        self._memory[COST] = 0.0
        self._begun: Int64 = np.zeros((2, moments), np.int64)
        self.now = 0
        """Number of moments so far."""

    def step(self, feature: Float64) -> None:
        """Take the features (F,) of the next moment."""
        self.now += 1
        bank = self._bank
        follow_examples(
            self.mean, self.begun, self._memory, self._begun, feature, bank.moment, bank.weight, bank.first, self.now
        )  # fmt: skip

    def reset(self) -> None:
        """Begin anew after a gap."""
        self.mean[:] = FAR
        self._memory[COST + 1 :] = FAR
