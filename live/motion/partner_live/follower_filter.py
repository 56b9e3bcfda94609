"""Causal filter: reads a leader frame by frame and says where the follower is, and at which recorded moments (H024)."""

from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Complex128, Float64, Int64
from live.motion.partner.point_clouds import LEADER_JOINTS, Cloud, cloud_of
from live.motion.partner.units import Units
from live.motion.partner_live.follower_kernels import (
    advance_posterior,
    danced_costs,
    posterior_means,
    regress,
    square_distances,
    write_features,
)
from live.motion.partner_live.follower_model import (
    CHANGE_WEIGHT,
    JUMP_PROBABILITY,
    KERNEL_WIDTH,
    SEEN_WIDTH,
    SHOWN_COLUMNS,
    SHOWN_WEIGHTS,
    FollowerModel,
    beat_density,
    learn_follower,
)
from live.motion.partner_live.follower_moments import FACING, JOINT_COLUMNS, TARGET_COLUMNS, leader_frame

IMPROBABILITY: Final = 0.02
"""Cost [m²] of dancing a moment whose probability is 1/e of the most probable one's, ..."""
MAX_IMPROBABILITY: Final = 6.0
"""... which grows up to this many times."""
OUTSIDE_COST: Final = 0.1
"""Cost of a moment before the first unit of its recording or after the last [m²]: the recording only runs out there."""
SURE_LIKENESS: Final = 0.3
LOST_LIKENESS: Final = 0.12
"""If no moment is as like the leader as this, the follower is unsure, and from here on lost ..."""
UNSURE_SECONDS: Final = 0.6
"""... with this time constant [s]."""
BASIC_COST: Final = 0.3
"""Cost of a moment away from the basic step for a follower who is lost, times its square distance [m²]."""
BEAT_MEMORY: Final = 0.97
"""Share of the evidence for the beats that is left after a moment, ..."""
MAX_BEAT_EVIDENCE: Final = 4.0
"""... and its limit: a logarithm of odds."""
LOST_SHARE: Final = 0.01
"""Least part of the posterior that another model's moments get, all together."""
NEAREST_PERCENTILE: Final = 1.0
"""Percentile of the recorded distances to the leader that defines the minimum distance, ..."""
KEY_RANGE: Final = 1 << 40
TRUSTED_WEIGHT: Final = 0.5
"""... in recordings of at least this weight."""


def _moment_keys(example: Int64, sample: Float64, mirrored: Bool) -> Int64:
    """Return a number for each moment by which it is found in another model, (M,); samples count to a thousandth."""
    return np.asarray((2 * example + mirrored) * KEY_RANGE + np.round(sample * 1000.0).astype(np.int64), np.int64)


class FollowerFilter:
    """Filter of one leader. Deterministic; one call per frame, bounded memory."""

    def __init__(self, units: Units, *, rate: float, weighs: bool = True) -> None:
        """`rate` [Hz] of the frames; `weighs`: see `learn_follower`."""
        self.units, self.rate = units, rate
        self.model: FollowerModel = learn_follower(units, rate, weighs=weighs)
        points = units.examples[0].live_control.floor.shape[1]
        ring, count = int(self.model.lags[-1]) + 1, self.model.count
        self._ring = ring
        self._at = -1
        self._x, self._x_height = np.zeros((ring, points), np.complex128), np.zeros((ring, points))
        self.posterior: Float64 = np.full(count, 1.0 / count)
        """Probability of each moment, (M,)."""
        self._now, self._soon = np.zeros(TARGET_COLUMNS), np.zeros(TARGET_COLUMNS)
        self._feature = np.zeros(len(self.model.scale))
        self._near_square, self._square, self._scratch = np.zeros(count), np.zeros(count), np.zeros(count)
        self._cost = np.zeros(count)
        self.expected: Float64 = np.zeros(TARGET_COLUMNS)
        """The follower as expected now, in the frame of the leader's hips; columns as in `follower_model`."""
        self._beat_evidence = 0.0
        self.unsure = 0.0
        """How much a safe basic step is danced instead, because the leader does what no example has, 0 to 1."""
        self.nearest = 0.0
        """How like the leader is to the most similar recorded moment, 0 to 1."""
        self.place, self.facing = complex(0.0), complex(1.0)
        """The leader's hips on the floor and their facing."""
        self.min_distance = 0.0
        """Minimum distance of the follower's hips from the leader's [m]; 0 without a second body."""
        if points > 2:
            trusted = self.model.example_weight[self.model.moments.example] >= TRUSTED_WEIGHT
            target = self.model.moments.target[trusted if trusted.any() else slice(None)]
            apart = np.hypot(target[:, 0], target[:, 2])
            self.min_distance = float(np.percentile(apart, NEAREST_PERCENTILE))

    @property
    def frame_index(self) -> int:
        """Number of the latest frame, -1 before the first."""
        return self._at

    @property
    def point_count(self) -> int:
        """Number of points of the leader's cloud."""
        return int(self._x.shape[1])

    def point(self, index: int) -> tuple[complex, float] | None:
        """Return a point of the leader's cloud on the floor and its height [m], None where it is not seen."""
        slot = self._at % self._ring
        if index >= self.point_count or not np.isfinite(self._x[slot, index]):
            return None
        return complex(self._x[slot, index]), float(self._x_height[slot, index])

    @property
    def frames_since_moment(self) -> int:
        """Frames since the posterior was advanced, 0 in the frame in which it is."""
        return self._at % self.model.stride

    def process_frame(self, floor: Complex128, height: Float64, phase: float | None = None) -> None:
        """Process the leader's next frame, points (P,) [m]; the hips must be finite, other points may be missing.

        `phase`: share of a unit that has passed by the leader's beats, None if they are unknown.
        """
        self._at += 1
        model, slot = self.model, self._at % self._ring
        self._x[slot], self._x_height[slot] = floor, height
        place, facing = leader_frame(self._x[slot])
        self.place, self.facing = complex(place), complex(facing)
        self._look()
        if self.frames_since_moment == 0:
            self._advance(phase)
            posterior_means(
                self.posterior, model.moments.target, model.moments.follows, FACING.start, self._now, self._soon
            )
        self._expect()
        lost = min(max((SURE_LIKENESS - self.nearest) / (SURE_LIKENESS - LOST_LIKENESS), 0.0), 1.0)
        if self.point_count > 2:
            self.unsure += (lost - self.unsure) * (1.0 - float(np.exp(-1.0 / (self.rate * UNSURE_SECONDS))))

    def _look(self) -> None:
        """Compare what the leader does with all moments."""
        at, model = self._at, self.model
        write_features(at, max(0, at - self._ring + 1), self._x, self._x_height, model.lags, self._feature)
        self._feature *= model.scale
        square_distances(self._feature, model.rows, model.share, model.near, self._near_square, self._square)

    def _expect(self) -> None:
        """Write the mean of both predictions to `expected`."""
        model = self.model
        self.nearest = regress(self._square, KERNEL_WIDTH, model.weights, model.mean, self.expected)
        part = self.frames_since_moment / model.stride
        self.expected += (1.0 - part) * self._now + part * self._soon
        self.expected *= 0.5

    def take_over(self, other: "FollowerFilter") -> None:
        """Continue after the latest frame of `other`, which reads the same leader with another model.

        What it saw and thinks of the beats is kept; its posterior, as far as both have learnt from the same recordings.
        Raises ValueError for a filter of another rate or other points.
        """
        if (other.rate, other.point_count, other._ring) != (self.rate, self.point_count, self._ring):
            raise ValueError("a filter of the same rate and of as many points expected")
        self._at = other._at
        self._x[:], self._x_height[:] = other._x, other._x_height
        self._beat_evidence, self.unsure = other._beat_evidence, other.unsure
        self.place, self.facing = other.place, other.facing
        self.posterior[:] = self._known_probabilities(other)
        if self._at >= 0:
            self._look()
            model = self.model
            posterior_means(
                self.posterior, model.moments.target, model.moments.follows, FACING.start, self._now, self._soon
            )
            self._expect()

    def _known_probabilities(self, other: "FollowerFilter") -> Float64:
        """Return the posterior of `other` at this model's moments; what is left is spread over all of them, (M,)."""
        mine, theirs = self.model.moments, other.model.moments
        number = {one.name: n for n, one in enumerate(self.units.examples)}
        names = np.array([number.get(one.name, -1) for one in other.units.examples])
        own = _moment_keys(mine.example, mine.sample, mine.mirrored)
        order = np.argsort(own, kind="stable")
        keys = _moment_keys(names[theirs.example], theirs.sample, theirs.mirrored)
        at = order[np.minimum(np.searchsorted(own[order], keys), len(own) - 1)]
        found = (own[at] == keys) & (names[theirs.example] >= 0)
        known = np.zeros(len(own))
        np.add.at(known, at[found], other.posterior[found])
        return np.asarray(known + max(1.0 - float(known.sum()), LOST_SHARE) / len(own))

    def _advance(self, phase: float | None) -> None:
        """Advance the posterior by a moment, and believe the beats as far as they make what is seen likelier."""
        model = self.model
        density = np.zeros(0)
        if phase is not None and model.beat_sharpness > 0.0:
            density = beat_density(model.moments.phase - phase, model.beat_sharpness)
        evidence = advance_posterior(
            self.posterior, model.moments.follows, model.jump_to, model.jump_share, JUMP_PROBABILITY, self._near_square,
            SEEN_WIDTH, density, self.beat_trust, self._scratch,
        )  # fmt: skip
        if len(density):
            said = BEAT_MEMORY * self._beat_evidence + float(np.log(max(evidence, 1e-6)))
            self._beat_evidence = min(max(said, -MAX_BEAT_EVIDENCE), MAX_BEAT_EVIDENCE)

    @property
    def beat_trust(self) -> float:
        """Probability that the leader dances on the given beats, 0 to 1; 0 where beats do not help to predict."""
        return float(1.0 / (1.0 + np.exp(-self._beat_evidence))) if self.model.beat_sharpness > 0.0 else 0.0

    @property
    def change(self) -> Float64:
        """How the filter expects `expected` to change until the next moment, (TARGET_COLUMNS,)."""
        return np.asarray(self._soon - self._now)

    def moment_costs(self, row: int) -> Float64:
        """Return what it costs to go on from each moment [m²], (M,), if the moment `row` is danced now; -1: none is.

        Costs are how far the follower there is from the expected one, how unlike the body is, and how improbable.
        """
        model, columns = self.model, list(SHOWN_COLUMNS)
        own = model.body[:, row] if row >= 0 else np.zeros(0)
        danced_costs(
            self.expected[columns] * SHOWN_WEIGHTS, self.change[columns] * SHOWN_WEIGHTS * CHANGE_WEIGHT, model.shown,
            np.ascontiguousarray(own), model.body, self._cost,
        )  # fmt: skip
        worth = np.log(np.maximum(self.posterior / self.posterior.max(), 1e-12))
        self._cost += BASIC_COST * self.unsure * model.basic_square
        self._cost += IMPROBABILITY * np.minimum(-worth, MAX_IMPROBABILITY)
        self._cost += model.example_cost
        self._cost[(model.moments.phase < 0.0) | (model.moments.phase >= 1.0)] += OUTSIDE_COST
        self._cost[model.moments.mirrored] = np.inf
        return self._cost

    def recorded_root(self, example: int, sample: float) -> tuple[complex, complex]:
        """Return the recorded follower's hips on the floor and their facing at a sample of a recording."""
        root, front = self.model.roots[example], self.model.facings[example]
        place = min(max(sample, 0.0), len(root) - 1.0)
        low = min(int(place), max(len(root) - 2, 0))
        high, w = min(low + 1, len(root) - 1), place - low
        facing = complex((1.0 - w) * front[low] + w * front[high])
        here = complex((1.0 - w) * root[low] + w * root[high])
        return here, facing / abs(facing) if abs(facing) > 1e-9 else complex(1.0)

    def expected_root(self) -> tuple[complex, complex]:
        """Return the follower's expected hip position on the floor and facing (unit complex number)."""
        values = self.expected
        facing = complex(*values[FACING])
        facing = facing / abs(facing) if abs(facing) > 1e-9 else complex(1.0)
        place, u = complex(values[0], values[2]), self.unsure
        if u > 0.0:
            place += u * (self.model.basic[0] - place)
            facing *= complex(np.exp(1j * u * np.angle(self.model.basic[1] / facing)))
        return self.place + self.facing * place, self.facing * facing

    def keep_distance(self, place: complex) -> complex:
        """Return `place`, moved away from the leader to the minimum distance if it is too near."""
        if self.min_distance <= 0.0:
            return place
        away = place - self.place
        far = abs(away)
        return place if far >= self.min_distance or far < 1e-9 else self.place + away * (self.min_distance / far)


EXPECTED_RATE: Final = 30.0
"""Frames per second at which a whole leader is read [Hz]."""


def expected_follower(leader: Cloud, units: Units) -> Cloud:
    """Return where the hip joints, hands and feet of the follower of a whole leader are expected, (T, 6).

    `leader` (T, 6): hip joints, hands and feet. The filter looks back only.
    """
    known = FollowerFilter(units, rate=EXPECTED_RATE)
    thin = leader.resampled(EXPECTED_RATE)
    places = np.zeros((thin.count, len(LEADER_JOINTS), 3))
    for n in range(thin.count):
        known.process_frame(thin.floor[n], thin.height[n])
        joints = known.expected[:JOINT_COLUMNS].reshape(-1, 3)[list(LEADER_JOINTS)]
        place = known.place + known.facing * (joints[:, 0] + 1j * joints[:, 2])
        places[n] = np.stack((place.imag, joints[:, 1], place.real), axis=1)
    at = np.arange(leader.count) * (EXPECTED_RATE / leader.rate)
    return replace(cloud_of(places, EXPECTED_RATE).at(np.asarray(at, np.float64)), rate=leader.rate)
