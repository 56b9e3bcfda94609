"""Decision which gesture of several examples is made, and when: a match is told at its best end, once."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.recognition.gesture_examples import EXAMPLE_RATE, ExampleBank, ExampleMatcher
from live.motion.recognition.gesture_kernels import FEATURES, USUAL_FACTOR, USUAL_POWER, tell_gestures

WAIT_S: Final = 0.19
"""Time [s] without a better end after which a match is told."""
LONGEST_WAIT_S: Final = 0.5
"""Time [s] after which it is told even if its end still gets better."""
OVERLAP: Final = 0.1
"""A gesture may begin before the last told one of the same kind has ended, by this share of its own length."""
NONE_WAITS: Final = 1e6
"""A cost in thresholds that no match has."""
_WAIT: Final = round(WAIT_S * EXAMPLE_RATE)
_LONGEST_WAIT: Final = round(LONGEST_WAIT_S * EXAMPLE_RATE)


class ExampleFollower:
    """Gestures of one body that have examples (G gestures, E examples). Thread: one at a time."""

    def __init__(self, bank: ExampleBank, gesture: Sequence[int]) -> None:
        """`gesture` (E,): the number of the gesture of which each is an example, from 0."""
        self._bank = bank
        self._gesture: Int64 = np.array(gesture, np.int64)
        self._matcher = ExampleMatcher(bank)
        count = 1 + max(gesture, default=-1)
        self._best: Float64 = np.full(count, NONE_WAITS)
        """Of the waiting match of each gesture its cost in limits; `NONE_WAITS` if none waits, (G,)."""
        self._times: Int64 = np.zeros((3, count), np.int64)
        """Its beginning, when its best end was, and when it was first found [moments], (3, G)."""
        self._ended: Int64 = np.full(count, -1000, np.int64)
        """When the last told match of each gesture ended [moment], (G,)."""
        examples = np.maximum(np.bincount(self._gesture, minlength=count), 1)
        mean = np.bincount(self._gesture, bank.threshold, minlength=count) / examples
        self._scale: Float64 = USUAL_FACTOR * np.maximum(mean, 1e-6) ** (USUAL_POWER - 1.0)
        self.limit: Float64 = np.ones(count)
        """Limit of each gesture's matches, in the thresholds of its examples, (G,)."""
        self._usual: Float64 = -np.log(self._scale) / USUAL_POWER
        """What `tell_gestures` knows of the motion, (G,)."""
        self._before: Float64 = np.zeros(FEATURES)
        self._told: Int64 = np.zeros(count, np.int64)
        self._least: Float64 = np.zeros(count)

    def reset(self) -> None:
        """Begin anew after a gap; what is usual stays."""
        self._matcher.reset()
        self._best[:] = NONE_WAITS

    def step(self, feature: Float64) -> list[int]:
        """Take the features (F,) of the next moment, at `EXAMPLE_RATE`; return the gestures that are told now."""
        if not len(self._gesture):
            return []
        matcher = self._matcher
        matcher.step(feature)
        count = tell_gestures(
            self._told, self._least, self._best, self._times, self._ended, self._usual, self.limit, self._scale,
            matcher.mean, matcher.begun, self._bank.threshold, self._gesture, feature, self._before, matcher.now, _WAIT,
            _LONGEST_WAIT, OVERLAP, NONE_WAITS,
        )  # fmt: skip
        return self._told[:count].tolist() if count else []
