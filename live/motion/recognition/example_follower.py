"""Decision which gesture of several examples is made, and when: a match is told at its best end, once."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.recognition.gesture_examples import EXAMPLE_RATE, ExampleBank, ExampleMatcher

WAIT_S: Final = 0.19
"""Time [s] without a better end after which a match is told."""
LONGEST_WAIT_S: Final = 0.5
"""Time [s] after which it is told even if its end still gets better."""
OVERLAP: Final = 0.25
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
        """Of the waiting match of each gesture its cost in thresholds; `NONE_WAITS` if none waits, (G,)."""
        self._times: Int64 = np.zeros((3, count), np.int64)
        """Its beginning, when its best end was, and when it was first found [moments], (3, G)."""
        self._ended: Int64 = np.full(count, -1000, np.int64)
        """When the last told match of each gesture ended [moment], (G,)."""
        self._waiting = 0
        """Number of gestures with a waiting match."""

    def reset(self) -> None:
        """Begin anew after a gap."""
        self._matcher.reset()
        self._best[:] = NONE_WAITS
        self._waiting = 0

    def step(self, feature: Float64) -> list[int]:
        """Take the features (F,) of the next moment, at `EXAMPLE_RATE`; return the gestures that are told now."""
        matcher = self._matcher
        matcher.step(feature)
        now, told = matcher.now, list[int]()
        if not (matcher.near or self._waiting):
            return told
        for example in np.flatnonzero(matcher.mean <= self._bank.threshold).tolist():
            gesture, begun = int(self._gesture[example]), int(matcher.begun[example])
            if begun < self._ended[gesture] - OVERLAP * (now - begun):
                continue
            share = float(matcher.mean[example] / self._bank.threshold[example])
            if share < self._best[gesture]:
                is_first = self._best[gesture] == NONE_WAITS
                self._waiting += int(is_first)
                first = now if is_first else int(self._times[2, gesture])
                self._best[gesture], self._times[:, gesture] = share, (begun, now, first)
        for gesture in np.flatnonzero(self._best < NONE_WAITS).tolist():
            begun, end, first = self._times[:, gesture].tolist()
            if now - end < _WAIT and now - first < _LONGEST_WAIT:
                continue
            self._waiting -= 1
            if self._is_better_elsewhere(gesture, begun, end):
                self._best[gesture] = NONE_WAITS
                continue
            self._best[gesture], self._ended[gesture] = NONE_WAITS, now
            told.append(gesture)
        return told

    def _is_better_elsewhere(self, gesture: int, begun: int, end: int) -> bool:
        """Whether another gesture's waiting match at the same time is nearer to its example."""
        overlap = np.minimum(self._times[1], end) - np.maximum(self._times[0], begun)
        other = (self._best < self._best[gesture]) & (overlap > 0.5 * (end - begun))
        return bool(other.any())
