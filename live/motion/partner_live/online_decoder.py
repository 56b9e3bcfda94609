"""Causal decoder: reads a leader frame by frame and reports each unit as early as it is clear (H024).

Units that end now are finished as in the offline search, with the K best paths kept at each boundary. Running units are
scored by their observed part. If the clock provides beats, units begin and end on them.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Complex128, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.partner.decoder_kernels import SAMPLE_SIZE
from live.motion.partner.time_scaled_units import Stretches, make_stretches
from live.motion.partner.units import Units
from live.motion.partner_live.online_kernels import expect_root, finish_units, score_running

PATH_COUNT: Final = 32
"""Paths kept at each boundary."""
BEAM: Final = 6.0
"""A boundary is dropped when all its units are worse than the best by this [m²]."""
SCORE_SPREAD: Final = 0.5
"""In the follower's expected position a unit worse than the best by this [m²] has the weight 1/e."""
MIN_FRAMES: Final = 6.0
"""Frames observed before a unit counts for the follower's expected position."""
NEAREST_PERCENTILE: Final = 1.0
"""Percentile of the recorded distances to the leader that defines the minimum distance."""
LIMB_POINTS: Final = 4
"""Points of a leader that is another body: hands, then feet. Other clouds come from the follower's own hips."""


def root_track(clip: Clip) -> tuple[Complex128, Complex128]:
    """Return the hips of a clip on the floor (z + i x) and their facing as unit complex numbers, (T,) each."""
    front = quaternion.rotate(clip.rotation[:, 0].astype(np.float64), np.array((0.0, 0.0, 1.0)))
    facing = front[:, 2] + 1j * front[:, 0]
    root = clip.root_position.astype(np.float64)
    return np.asarray(root[:, 2] + 1j * root[:, 0]), np.asarray(facing / np.maximum(np.abs(facing), 1e-9))


@dataclass(frozen=True, slots=True)
class UnitHypothesis:
    """Hypothesis of the unit danced now."""

    unit: int
    begin: int
    """Frame at which it began."""
    step: float
    """Samples of its recording per frame."""
    progress: float
    """Share of it that has passed, 0 to 1."""
    score: float
    """Its score [m²], lower is better."""
    turn: complex
    """Rigid motion M estimated from the observed part."""
    shift: complex


class OnlineDecoder:
    """Decoder from frames to guesses. Deterministic; one call per frame, bounded memory."""

    def __init__(self, units: Units, *, rate: float, stretch: float, k: float, path_count: int = PATH_COUNT) -> None:
        """`rate` [Hz] of the frames; `k` for that rate (the factor of a search grows with its rate)."""
        self.units, self.rate, self.k = units, rate, k
        self._stretches = made = make_stretches(units, rate, stretch)
        self._longest = int(made.duration[-1])
        points = units.examples[0].control.floor.shape[1]
        ring = self._longest + 2
        self._ring = ring
        self._at = -1
        self._x, self._x_height = np.zeros((ring, points), np.complex128), np.zeros((ring, points))
        self._score = np.full((ring, path_count), np.inf)
        self._end = np.full((ring, path_count, SAMPLE_SIZE), np.nan)
        self._cell, self._before = np.full((ring, path_count), -1, np.int64), np.full((ring, path_count), -1, np.int64)
        self._flatten(made)
        count = units.count
        self._step = np.zeros((ring, count))
        self._sums, self._squares = np.zeros((ring, count, 2), np.complex128), np.zeros((ring, count, 2))
        self._input_sum, self._input_square = np.zeros(ring, np.complex128), np.zeros((ring, 1))
        self._frames = np.full((ring, 1), -1.0)
        self._value = np.full((ring, count), np.inf)
        self._expected = np.zeros(2, np.complex128)
        self._shortest_units = np.array([made.duration[made.unit == n].min() for n in range(count)], np.float64)
        self._longest_units = np.array([made.duration[made.unit == n].max() for n in range(count)], np.float64)

    def _flatten(self, made: Stretches) -> None:
        """Flatten all data that the kernels need."""
        self._first = np.array([first for _, first, _ in made.groups] + [made.count], np.int64)
        self._offset = np.concatenate(([0], np.cumsum([one.size for one in made.real])))[:-1].astype(np.int64)
        self._real = np.concatenate([one.ravel() for one in made.real])
        self._imaginary = np.concatenate([one.ravel() for one in made.imaginary])
        self._heights = np.concatenate([one.ravel() for one in made.control_height])
        self._work = np.zeros((4, made.count))
        examples = self.units.examples
        self._control = np.concatenate([one.control.floor for one in examples])
        self._control_height = np.concatenate([one.control.height for one in examples])
        starts = np.concatenate(([0], np.cumsum([one.control.count for one in examples])))
        self._record_first = np.ascontiguousarray(starts[self.units.example], np.int64)
        self._record_stop = np.ascontiguousarray(starts[self.units.example + 1], np.int64)
        heads = [
            examples[int(of)].target.at(np.array([float(start)]))
            for of, start in zip(self.units.example, self.units.start, strict=True)
        ]
        self._head = np.concatenate([one.floor for one in heads])
        self._head_height = np.concatenate([one.height for one in heads])
        self._root = np.concatenate([root_track(one.follower)[0] for one in examples])
        self._facing = np.concatenate([root_track(one.follower)[1] for one in examples])
        self.min_distance = 0.0
        """Minimum distance of the follower's hips from the middle between the leader's feet [m]; 0 without a second
        body."""
        if self._control.shape[1] == LIMB_POINTS:
            apart = np.abs(self._root - self._control[:, 2:].mean(axis=1))
            self.min_distance = float(np.percentile(apart, NEAREST_PERCENTILE))

    @property
    def frame_index(self) -> int:
        """Number of the latest frame, -1 before the first."""
        return self._at

    @property
    def point_count(self) -> int:
        """Number of points of the leader's cloud."""
        return int(self._x.shape[1])

    def process_frame(self, floor: Complex128, height: Float64, *, boundary: bool, unit_frames: float | None) -> None:
        """Process the leader's next frame, points (P,) [m].

        `boundary`: whether a unit may begin and end now (always true without beats). `unit_frames`: length by the clock
        of a unit that begins now [frames]; None: the recorded length.
        """
        self._at += 1
        at, made = self._at, self._stretches
        slot = at % self._ring
        self._x[slot], self._x_height[slot] = floor, height
        self._score[slot], self._cell[slot], self._before[slot] = np.inf, -1, -1
        self._end[slot] = np.nan
        self._frames[slot, 0] = -1.0
        if boundary:
            finish_units(
                at, self.k, self._x, self._x_height, made.duration, self._offset, self._real, self._imaginary,
                self._heights, made.size, made.head, made.head_height, made.tail, made.tail_height, self._first,
                self._score, self._end, self._cell, self._before, self._work,
            )  # fmt: skip
            if at <= self._longest and not np.isfinite(self._score[slot, 0]):
                self._score[slot, 0] = 0.0  # the dance may start here
            if np.isfinite(self._score[slot, 0]):
                self._begin(slot, unit_frames)
        score_running(
            at, self.k, self._x, self._x_height, self._control, self._control_height, self._record_first,
            self._record_stop, self.units.start, self._step, self._head, self._head_height, self._score, self._end,
            self._sums, self._squares, self._input_sum, self._input_square, self._frames, self._value,
            BEAM,
        )  # fmt: skip

    def expected_root(self) -> tuple[complex, complex] | None:
        """Return the follower's expected hip position on the floor and facing (unit complex number), or None.

        It is the mean over all running units, weighted by likelihood. None if no unit runs.
        """
        count = expect_root(
            SCORE_SPREAD, MIN_FRAMES, self._at, self._x, self._root, self._facing, self._record_first,
            self._record_stop, self.units.start, self.units.length, self._step, self._sums, self._input_sum,
            self._frames, self._value, self._expected,
        )  # fmt: skip
        if count == 0:
            return None
        facing = complex(self._expected[1])
        return complex(self._expected[0]), facing / abs(facing) if abs(facing) > 1e-9 else complex(1.0)

    def keep_distance(self, place: complex) -> complex:
        """Return `place`, moved away from the leader to the minimum distance if it is too near."""
        if self.min_distance <= 0.0:
            return place
        middle = complex(self._x[self._at % self._ring, 2:].mean())
        away = place - middle
        far = abs(away)
        return place if far >= self.min_distance or far < 1e-9 else middle + away * (self.min_distance / far)

    def recorded_root(self, unit: int, place: float) -> tuple[complex, complex]:
        """Return the recorded follower's hips on the floor and their facing at sample `place` of a unit's recording."""
        first, stop = int(self._record_first[unit]), int(self._record_stop[unit])
        place = min(max(place, 0.0), stop - first - 1.0)
        low = min(int(place), max(stop - first - 2, 0))
        one, other, w = first + low, min(first + low + 1, stop - 1), place - low
        facing = complex((1.0 - w) * self._facing[one] + w * self._facing[other])
        here = complex((1.0 - w) * self._root[one] + w * self._root[other])
        return here, facing / abs(facing) if abs(facing) > 1e-9 else complex(1.0)

    def unit_score(self, unit: int, begin: int) -> float:
        """Return the score of a unit that began at frame `begin` [m²], from its observed part; infinite if it no longer
        runs."""
        row = begin % self._ring
        frames = int(self._frames[row, 0])
        if frames < 1 or self._at - frames + 1 != begin:
            return np.inf
        return float(self._value[row, unit])

    def unit_transform(self, unit: int, begin: int) -> tuple[complex, complex]:
        """Return M of a unit running since frame `begin`, from its observed part."""
        row = begin % self._ring
        n = self._x.shape[1] * int(self._frames[row, 0])
        middle, own = self._input_sum[row] / n, self._sums[row, unit, 1] / n
        product = complex(self._sums[row, unit, 0] - n * np.conj(own) * middle)
        turn = product / abs(product) if abs(product) > 1e-12 else complex(1.0)
        return turn, complex(middle + self._x[begin % self._ring, 0] - turn * own)

    def _begin(self, slot: int, unit_frames: float | None) -> None:
        own = self.units.seconds * self.rate
        frames = own if unit_frames is None else np.clip(unit_frames, self._shortest_units, self._longest_units)
        self._step[slot] = self.units.length / np.maximum(frames, 1.0)
        self._sums[slot], self._squares[slot] = 0.0, 0.0
        self._input_sum[slot], self._input_square[slot] = 0.0, 0.0
        self._frames[slot, 0] = 0.0

    def best_hypothesis(self, first_frame: int = -1) -> UnitHypothesis | None:
        """Return the best running unit among those that began at frame `first_frame` or later, or None."""
        seen = np.maximum(self._frames[:, 0] - 1.0, 0.0)
        began = self._at - seen
        running = np.isfinite(self._score[:, 0]) & (self._frames[:, 0] > 1.0) & (began >= first_frame)
        rows = np.flatnonzero(running)
        if not len(rows):
            return None
        value = self._value[rows].copy()
        value[seen[rows, None] * self._step[rows] > self.units.length * (1.0 + 1e-9)] = np.inf
        place, unit = np.unravel_index(int(np.argmin(value)), value.shape)
        best, row = float(value[place, unit]), int(rows[place])
        if not np.isfinite(best):
            return None
        begin = int(began[row])
        turn, shift = self.unit_transform(int(unit), begin)
        part = float(seen[row] * self._step[row, unit] / self.units.length[unit])
        return UnitHypothesis(int(unit), begin, float(self._step[row, unit]), part, best, turn, shift)
