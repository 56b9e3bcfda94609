"""What a follower does, learnt from recorded pairs: where she is, how she stands and which hands she holds (H018).

Two methods are learnt from the same *moments*, 7.5 a second of each recording, and their mean is used. Kernel ridge
regression predicts the follower from what the leader did in the last three seconds. A forward filter knows at which
recorded moments the couple may be: a moment leads to the next one, or to one at which the recorded follower was alike.
Both are in the frame of the leader's hips, as in C. Saunders et al., *Ridge regression learning algorithm in dual
variables* (1998), and L. Rabiner, *A tutorial on hidden Markov models* (1989).
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from live.base.arrays import Complex128, Float64, Int32, Int64
from live.motion.partner.units import Units
from live.motion.partner_live.example_weights import example_gains, judged_rows, weights_of_gains
from live.motion.partner_live.follower_kernels import (
    advance_posterior,
    solve_positive,
    square_distances,
)
from live.motion.partner_live.follower_moments import (
    END_COLUMNS,
    FACING,
    JOINT_COLUMNS,
    LAGS,
    MAX_MOMENTS,
    MOMENT_RATE,
    Moments,
    joined_moments,
    mirror_moments,
    read_moments,
    root_track,
    rounded,
    selected_moments,
    thinned_moments,
)

LAG_DECAY: Final = 0.3
"""... and how fast they count less [1/s]."""
NEAR_LAGS: Final = 2
"""Number of lags that the filter looks at."""
KERNEL_WIDTH: Final = 0.5
RIDGE: Final = 0.2
"""Width of the Gaussian kernel, in shares of the features' mean square, and variance of what cannot be told."""
MIRROR_GAIN: Final = 1.0
"""Mirror images are learnt from, too, if they lower the error on recordings left out at least to this part."""
JUMP_PROBABILITY: Final = 0.2
"""Probability that a leader jumps from a recorded moment to one that is like it."""
SEEN_WIDTH: Final = 0.4
"""Width of the likeness of what is seen and recorded, in shares of the features' mean square."""
BEAT_SHARPNESS: Final = (0.0, 0.7, 2.0, 5.0)
"""Concentrations of recorded units about the beats that are tried (von Mises); 0 leaves the beats out."""
BEAT_GAIN: Final = 0.99
"""The beats count if they lower the error on recordings left out at least to this part."""
BASIC_WIDTH: Final = 0.2
"""Width of the density of places [m]."""
BASIC_COSINE: Final = 0.7
"""Cosine of the largest angle at which a follower faces the leader."""
ARM_LENGTH: Final = 0.65
"""Least distance of the hips in a basic step [m]."""
JUMPS: Final = 48
"""Number of moments that a moment may jump to."""
JUMP_WIDTH: Final = 0.3
"""Width of the likeness of two moments of followers, in weighted metres."""
JUMP_WEIGHTS: Final = (1.5, 1.5, 0.3, 0.15)
"""Weights of place [1/m], facing, hands [1/m] and of the change of place and facing per second."""
SHOWN_COLUMNS: Final = (0, 2, FACING.start, FACING.start + 1, *END_COLUMNS)
"""Columns by which a moment to dance is chosen: hips, facing, hands and feet."""
PLACE_WEIGHT: Final = 0.5
FACING_WEIGHT: Final = 0.35
ENDS_WEIGHT: Final = 0.35
"""Factors of the hips' place, facing, hands and feet [m] in the leader's frame, ..."""
CHANGE_WEIGHT: Final = 2.0
"""... and of how they change in a moment, ..."""
BODY_WEIGHT: Final = 0.1
BODY_CHANGE_WEIGHT: Final = 0.2
"""... and of hands and feet in the follower's own frame."""
SHOWN_WEIGHTS: Final = np.array((PLACE_WEIGHT, PLACE_WEIGHT, FACING_WEIGHT, FACING_WEIGHT, *(12 * (ENDS_WEIGHT,))))


EXAMPLE_COST: Final = 0.1
"""Cost of dancing a moment of a take whose weight is 1/e [m²]."""


@dataclass(frozen=True, slots=True, eq=False)
class FollowerModel:
    """What is learnt from the moments."""

    moments: Moments
    lags: Int64
    """[frames]"""
    stride: int
    """Frames from a moment to the next one."""
    scale: Float64
    """Factor of each feature, (D,)."""
    rows: Float64
    """Scaled features of all moments, (D, M)."""
    share: Float64
    """Share of each feature in the mean square of all, (D,)."""
    near: int
    """Number of features that the filter looks at, the first ones."""
    weights: Float64
    """Of the regression, (M, TARGET_COLUMNS) ..."""
    mean: Float64
    """... and its constant term, (TARGET_COLUMNS,)."""
    jump_to: Int32
    jump_share: Float64
    """Moments to which each one jumps, and with which probabilities, (M, JUMPS)."""
    shown: Float64
    """The follower's SHOWN_COLUMNS in the leader's frame, and how they change in a moment, (2 · 16, M)."""
    body: Float64
    """Hands and feet in the frame of the follower's own hips, and how they change in a moment, (24, M)."""
    remaining: Int64
    """How many moments follow in the same recording without a gap, (M,)."""
    beat_sharpness: float
    """How narrowly recorded units keep to the beats as far as that helps; 0: it does not."""
    basic: tuple[complex, complex]
    """Where a follower stands most often who faces the leader, and her facing, in the leader's frame."""
    basic_square: Float64
    """How far each moment is from there, (M,)."""
    rows_of: Int64
    units_of: Int64
    """First and last + 1 moment and unit of each recording, (E, 2) each."""
    roots: tuple[Complex128, ...]
    facings: tuple[Complex128, ...]
    """The follower's hips and facing in each recording, see `root_track`."""
    example_weight: Float64
    """How much each recording counts, (E,), see `example_weights`."""
    example_cost: Float64
    """What it costs to dance each moment because of that [m²], (M,)."""

    @property
    def count(self) -> int:
        """Number of moments M."""
        return len(self.moments.sample)


def learn_follower(units: Units, rate: float, *, weighs: bool = True) -> FollowerModel:
    """Return what is learnt from the examples of `units`, for a leader who is read at `rate` [Hz].

    Unless it `weighs` them, all recordings count alike. Raises ValueError for a leader's cloud that does not begin with
    the hips.
    """
    if units.examples[0].live_control.floor.shape[1] not in (2, 6):
        raise ValueError("two hip joints, or hip joints, hands and feet expected")
    stride = max(1, round(rate / MOMENT_RATE))
    lags = np.round(np.array(LAGS) * rate).astype(np.int64)
    moments = thinned_moments(
        joined_moments([read_moments(units, n, rate, stride, lags) for n in range(len(units.examples))])
    )
    count = len(moments.sample)
    example_weight = _example_weights(moments, len(units.examples)) if weighs else np.ones(len(units.examples))
    if 2 * count <= MAX_MOMENTS and _mirror_helps(moments):
        moments = joined_moments([moments, mirror_moments(moments)])
    features = _scale_features(moments.feature)
    weight = example_weight[moments.example]
    weights, mean = _regression(features, moments.target, weight)
    jump_to, jump_share = _weighted_jumps(*_jumps(moments), weight)
    shown, body = _shown(moments)
    basic, basic_square = _basic(moments)
    tracks = [root_track(one.follower) for one in units.examples]
    return FollowerModel(
        moments, lags, stride, features.scale, features.rows, features.share, features.near, weights, mean, jump_to,
        jump_share, shown, body, _remaining(moments.follows), _beat_sharpness(moments), basic, basic_square,
        _limits(moments.example[:count], len(units.examples)), _limits(units.example, len(units.examples)),
        tuple(one for one, _ in tracks), tuple(one for _, one in tracks),
        example_weight, -EXAMPLE_COST * np.log(weight),
    )  # fmt: skip


def _example_weights(moments: Moments, count: int) -> Float64:
    """Return the weights of `count` recordings from their `moments`, none of them mirrored, (count,)."""
    weight, rows = np.ones(count), judged_rows(moments.example)
    if rows is None:
        return weight
    judged = np.isin(np.arange(len(moments.sample)), rows)
    seen = selected_moments(moments, judged)
    features = _scale_features(seen.feature)
    kernel = _similarity(features, features.rows)
    kernel[np.diag_indices(len(kernel))] += RIDGE
    gains = example_gains(kernel, np.ascontiguousarray(seen.target[:, :JOINT_COLUMNS]), seen.example)
    weight[np.unique(seen.example)] = weights_of_gains(gains)
    return weight


def _weighted_jumps(to: Int32, share: Float64, weight: Float64) -> tuple[Int32, Float64]:
    """Return the jumps with probabilities that also follow the `weight` (M,) of the moments to which they lead."""
    weighted = share * weight[to]
    return to, rounded(weighted / weighted.sum(axis=1, keepdims=True))


def _limits(example: Int64, count: int) -> Int64:
    """Return the first and last + 1 row of each of `count` recordings, (count, 2), of ascending indices `example`."""
    sides: tuple[Literal["left", "right"], ...] = ("left", "right")
    return np.stack([np.searchsorted(example, np.arange(count), side=side) for side in sides], axis=1).astype(np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class _Features:
    """Scaled features, see `FollowerModel`."""

    scale: Float64
    rows: Float64
    share: Float64
    near: int


def _scale_features(feature: Float64) -> _Features:
    """Weigh features (M, D) by their lags, so that the mean square of all together is 1."""
    size, columns = len(LAGS), feature.shape[1] // len(LAGS)
    weight = np.repeat(np.exp(-LAG_DECAY * np.array(LAGS)), columns)
    weight = np.where(np.tile(np.arange(columns) >= columns - 2, size), 1.0, weight)
    spread = (((feature - feature.mean(axis=0)) * weight) ** 2).mean(axis=0)
    total = max(float(spread.sum()), 1e-9)
    scale = rounded(weight / np.sqrt(total))
    rows = np.ascontiguousarray(rounded(feature * scale).T)
    return _Features(scale, rows, rounded(np.maximum(spread / total, 1e-6)), NEAR_LAGS * columns)


def _similarity(features: _Features, rows: Float64) -> Float64:
    """Return the kernel between scaled features (D, N) and all moments, (N, M)."""
    kernel, unused = np.empty((rows.shape[1], features.rows.shape[1])), np.empty(features.rows.shape[1])
    for row, feature in zip(kernel, np.ascontiguousarray(rows.T), strict=True):
        square_distances(feature, features.rows, features.share, features.near, unused, row)
    return np.asarray(np.exp(kernel / (-2.0 * KERNEL_WIDTH**2)))


def _regression(features: _Features, target: Float64, weight: Float64 | None = None) -> tuple[Float64, Float64]:
    """Return weights and constant term of the regression; moments with a `weight` (M,) below 1 are trusted less."""
    weight = np.ones(len(target)) if weight is None else weight
    kernel = _similarity(features, features.rows)
    kernel[np.diag_indices(len(kernel))] += RIDGE / weight
    mean = rounded((target * weight[:, None]).sum(axis=0) / weight.sum())
    weights = np.ascontiguousarray(target - mean)
    solve_positive(kernel, weights)
    return rounded(weights), mean


def _mirror_helps(moments: Moments) -> bool:
    """Whether mirror images of some recordings help to predict the others: one half is left out in turn.

    Of a single recording it is the first and the second half.
    """
    example = moments.example
    half = example % 2 == 0 if len(np.unique(example)) > 1 else np.arange(len(example)) < len(example) // 2
    errors = [0.0, 0.0]
    for known in (half, ~half):
        seen, unseen = selected_moments(moments, known), selected_moments(moments, ~known)
        for n, learnt in enumerate((seen, joined_moments([seen, mirror_moments(seen)]))):
            features = _scale_features(learnt.feature)
            weights, mean = _regression(features, learnt.target)
            rows = np.ascontiguousarray(rounded(unseen.feature * features.scale).T)
            away = _similarity(features, rows) @ weights + mean - unseen.target
            errors[n] += float(np.linalg.norm(away[:, :JOINT_COLUMNS].reshape(len(away), -1, 3), axis=-1).sum())
    return errors[1] < MIRROR_GAIN * errors[0]


def beat_density(phase: Float64, sharpness: float) -> Float64:
    """Return the density of a unit's phase off the beats (n,), in shares of a unit, over that of any phase."""
    return np.asarray(np.exp(sharpness * np.cos(2.0 * np.pi * phase)) / np.i0(sharpness))


def _beat_sharpness(moments: Moments) -> float:
    """Return the concentration of BEAT_SHARPNESS with which the filter predicts recordings left out best."""
    example = moments.example
    if len(np.unique(example)) < 2 or moments.feature.shape[1] == 5 * len(LAGS):
        return 0.0
    errors = np.zeros(len(BEAT_SHARPNESS))
    for known in (example % 2 == 0, example % 2 == 1):
        seen, unseen = (
            selected_moments(moments, known & ~moments.mirrored),
            selected_moments(moments, ~known & ~moments.mirrored),
        )
        features = _scale_features(seen.feature)
        rows = np.ascontiguousarray(rounded(unseen.feature * features.scale))
        near, square, scratch = np.empty((len(rows), len(seen.sample))), *np.empty((2, len(seen.sample)))
        for row, into in zip(rows, near, strict=True):
            square_distances(row, features.rows, features.share, features.near, into, square)
        jump_to, jump_share = _jumps(seen)
        for n, sharpness in enumerate(BEAT_SHARPNESS):
            posterior = np.full(len(square), 1.0 / len(square))
            for m in range(len(rows)):
                beats = beat_density(seen.phase - unseen.phase[m], sharpness)
                advance_posterior(
                    posterior, seen.follows, jump_to, jump_share, JUMP_PROBABILITY, near[m], SEEN_WIDTH, beats, 1.0,
                    scratch,
                )  # fmt: skip
                away = posterior @ seen.target[:, :JOINT_COLUMNS] - unseen.target[m, :JOINT_COLUMNS]
                errors[n] += float(np.linalg.norm(away.reshape(-1, 3), axis=-1).sum())
    best = int(np.argmin(errors))
    return BEAT_SHARPNESS[best] if errors[best] < BEAT_GAIN * errors[0] else 0.0


def _jumps(moments: Moments) -> tuple[Int32, Float64]:
    """Return to which moments each moment jumps: those at which the follower is alike, in place and motion."""
    target, count = moments.target, len(moments.sample)
    after = np.minimum(np.arange(count) + np.minimum(moments.follows, 1), count - 1)
    root = np.column_stack((target[:, (0, 2)], target[:, FACING]))
    weights = JUMP_WEIGHTS
    hands = target[:, END_COLUMNS[:6]]
    state = np.column_stack(
        (
            root[:, :2] * weights[0], root[:, 2:] * weights[1], hands * weights[2],
            (root[after] - root) * (MOMENT_RATE * weights[3]),
        )
    )  # fmt: skip
    keep = min(JUMPS, count)
    to, share = np.zeros((count, keep), np.int32), np.zeros((count, keep))
    for m in range(count):
        square = rounded(((state - state[m]) ** 2).sum(axis=1))
        best = np.argsort(square, kind="stable")[:keep]
        like = np.exp(square[best] / (-2.0 * JUMP_WIDTH**2))
        to[m], share[m] = best, rounded(like / like.sum())
    return to, share


def _basic(moments: Moments) -> tuple[tuple[complex, complex], Float64]:
    """Return the place of the safe basic step: the densest one of those at which the follower faces the leader."""
    target = moments.target
    place, facing = target[:, 0] + 1j * target[:, 2], target[:, FACING.start] + 1j * target[:, FACING.start + 1]
    facing = facing / np.maximum(np.abs(facing), 1e-9)
    near = np.exp(np.abs(place[:, None] - place) ** 2 / (-2.0 * BASIC_WIDTH**2)).sum(axis=1)
    to_leader = -place / np.maximum(np.abs(place), 1e-9)
    seen = (facing * to_leader.conj()).real > BASIC_COSINE
    most = int(np.argmax(np.round(near * (seen if seen.any() else 1.0), 6)))
    there = complex(place[most]) * max(1.0, ARM_LENGTH / max(abs(complex(place[most])), 1e-9))
    towards = complex(-there / abs(there)) if abs(there) > 1e-9 else complex(1.0)
    return (there, towards), rounded(np.abs(place - there) ** 2 + np.abs(facing - towards) ** 2)


def _shown(moments: Moments) -> tuple[Float64, Float64]:
    """Return SHOWN_COLUMNS and the body of all moments, each with its change until the next one."""
    target, count = moments.target, len(moments.sample)
    shown = target[:, SHOWN_COLUMNS] * SHOWN_WEIGHTS
    body = own_body(target)
    after = np.minimum(np.arange(count) + np.minimum(moments.follows, 1), count - 1)
    return (
        np.ascontiguousarray(np.concatenate((shown, CHANGE_WEIGHT * (shown[after] - shown)), axis=1).T),
        np.ascontiguousarray(
            rounded(np.concatenate((BODY_WEIGHT * body, BODY_CHANGE_WEIGHT * (body[after] - body)), axis=1)).T
        ),
    )


def own_body(target: Float64) -> Float64:
    """Return hands and feet in the frame of the follower's own hips, (n, 12), from targets (n, TARGET_COLUMNS)."""
    ends = target[:, END_COLUMNS].reshape(len(target), -1, 3)
    facing = target[:, FACING.start] + 1j * target[:, FACING.start + 1]
    facing = facing / np.maximum(np.abs(facing), 1e-9)
    place = (ends[..., 0] - target[:, :1] + 1j * (ends[..., 2] - target[:, 2:3])) * facing.conj()[:, None]
    return np.asarray(np.stack((place.real, ends[..., 1], place.imag), axis=-1).reshape(len(target), -1))


def _remaining(follows: Int64) -> Int64:
    found = np.zeros(len(follows), np.int64)
    for m in range(len(follows) - 2, -1, -1):
        found[m] = found[m + 1] + 1 if follows[m] else 0
    return found
