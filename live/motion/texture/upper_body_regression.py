"""What legs tell about the upper body: kernel ridge regression chosen and damped by cross-validation (P023).

The pose of each group of joints and its movement (bands 2 to 5) are each predicted by the mean of the driver sets, each
with its bands, window and smoothness, that predict takes left out best; see `driver_choice`. Then each frequency band
of the prediction is multiplied by the gain that fits takes left out best, from 0 (the mean pose) to 1. So no band moves
that the drivers do not tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion import quaternion
from live.motion.quaternion import mean_rotation
from live.motion.skeleton import SKELETON
from live.motion.texture.driver_choice import (
    BAND_COUNT,
    PARTS,
    SMOOTHNESS,
    Choice,
    FittedChoices,
    Key,
    LearningData,
    choose,
    driver_windows,
    fit,
    moving_part,
)
from live.motion.texture.drivers import DRIVER_SETS, DriverSet
from live.motion.texture.frequency_bands import SampledClip, split_bands
from live.motion.texture.take_splits import Choreographies, choreographies, find_copies, make_folds


@dataclass(frozen=True, slots=True, eq=False)
class GroupRegression:
    """The regression of one part of a group of joints, and what it is worth at takes left out."""

    name: str
    part: str
    """One of `PARTS`."""
    joints: tuple[int, ...]
    gains: Float64
    """Gain of each band and of all that is slower, (BAND_COUNT + 1,)."""
    told: Float64
    """Share of each band's variance that is predicted at takes left out, (BAND_COUNT + 1,)."""
    mean_error: float
    """Mean squared angle from the mean pose at takes left out [rad²]."""
    error: float
    """Mean squared angle from the damped prediction at takes left out [rad²]."""
    variation: float
    """Mean square of the movement that the prediction leaves [rad²], 0 for poses."""
    spreads: Float64
    """Root mean square of each band's movement that is told, against what is left, at most 1, (BAND_COUNT + 1,)."""
    _fitted: FittedChoices
    _middle: Float64

    @property
    def choices(self) -> tuple[Choice, ...]:
        """Choices whose predictions are averaged, the best first."""
        return self._fitted.choices

    def predict(self, take: SampledClip, reference: Float64) -> Float64:
        """Return the damped rotation vectors (T, 3 n) of the group's joints, from their mean rotations `reference`."""
        windows = [driver_windows(take, choice, reference) for choice in self.choices]
        return self._middle + damp_bands(self._fitted.predict(windows), self.gains)


@dataclass(frozen=True, slots=True, eq=False)
class UpperBodyRegression:
    """Regression of upper joints on legs and pelvis."""

    joints: tuple[int, ...]
    reference: Float64
    """Mean rotation of every joint, (J, 4)."""
    groups: tuple[GroupRegression, ...]
    dances: Choreographies
    residuals: Float64
    """Movement of the rotation vectors of the joints of all takes from their prediction, (S, 3 n)."""
    starts: Int64
    """First sample of each take and the end of the last."""
    fold_count: int

    def predict(self, take: SampledClip) -> Float64:
        """Return the rotation vectors (T, 3 n) of `joints`, from `reference`, told by the lower body of `take`."""
        vectors = np.zeros((len(take.root), len(self.joints), 3))
        for group in self.groups:
            rows = [self.joints.index(joint) for joint in group.joints]
            vectors[:, rows] += group.predict(take, self.reference).reshape(len(vectors), len(rows), 3)
        return vectors.reshape(len(vectors), -1)

    def rotations(self, vectors: Float64, variation: Float64) -> Float64:
        """Return the rotations (T, n, 4) at `vectors` (T, 3 n) from the mean, turned by `variation` (T, 3 n)."""
        shape = (len(vectors), len(self.joints), 3)
        at = rotations_of(vectors.reshape(shape), self.reference[list(self.joints)])
        return rotations_of(variation.reshape(shape), at)

    def told_shares(self) -> dict[str, float]:
        """Return the share of each group's movement about the mean pose that is told, 0 (nothing) to 1."""
        found = {}
        for name, parts in self._parts().items():
            whole = sum(part.mean_error for part in parts)
            found[name] = 1.0 - sum(part.error for part in parts) / whole if whole > 1e-12 else 0.0
        return found

    def variation(self, share: float, told: Float64 | None = None) -> Float64:
        """Return what the prediction leaves of the movement of all takes, as far as it may be added, (S, 3 n).

        Variation that is independent of the truth adds its mean square to the expected squared error. In each band it
        may use `share` (0 to 1) of what the prediction gains there over the mean pose, and that share of the mean
        square of the prediction `told` (T, 3 n) itself. So the result stays nearer to the truth than the mean pose, and
        nothing moves at a rhythm at which the lower body tells nothing.
        """
        count, joints = len(self.residuals), len(self.joints)
        residuals = [self.residuals[a:b].reshape(-1, joints, 3) for a, b in pairwise(self.starts.tolist())]
        bands = np.concatenate([split_bands(one, BAND_COUNT) for one in residuals], axis=1)
        factors = np.zeros((BAND_COUNT + 1, 1, joints, 1))
        for group in self.groups:
            if group.part == "movement":
                rows = [self.joints.index(joint) for joint in group.joints]
                factor = group.spreads
                if told is not None:
                    moves = split_bands(told.reshape(-1, joints, 3)[:, rows], BAND_COUNT)
                    left = (bands[:, :, rows] ** 2).mean(axis=(1, 2, 3))
                    factor = np.minimum(factor, np.sqrt((moves**2).mean(axis=(1, 2, 3)) / np.maximum(left, 1e-12)))
                factors[:, :, rows] = np.sqrt(share) * factor[:, None, None, None]
        out = (factors * bands).sum(axis=0)
        for parts in self._parts().values():  # bands overlap: their sum may exceed what they may use together
            rows = [self.joints.index(joint) for joint in parts[0].joints]
            budget = share * max(sum(part.mean_error - part.error for part in parts), 0.0)
            used = _mean_square(out[:, rows])
            if used > budget:
                out[:, rows] *= np.sqrt(budget / used)
        return np.asarray(out.reshape(count, -1))

    def liveliness(self, share: float) -> Float64:
        """Return the root mean square of the most variation of each of `joints` against all that is left, (n,)."""
        shape = (len(self.residuals), len(self.joints), 3)
        added, left = ((one.reshape(shape) ** 2).mean(axis=(0, 2)) for one in (self.variation(share), self.residuals))
        return np.asarray(np.sqrt(added / np.maximum(left, 1e-12)))

    def _parts(self) -> dict[str, list[GroupRegression]]:
        found: dict[str, list[GroupRegression]] = {}
        for group in self.groups:
            found.setdefault(group.name, []).append(group)
        return found

    def report(self, share: float) -> dict[str, Any]:
        """Return what the drivers tell of each group and band, as JSON values."""
        return {
            "choreographies": self.dances.number.tolist(),
            "splits": self.fold_count,
            "left_out": "whole choreographies" if self.dances.count > 1 else "parts of the only choreography",
            "told": {name: round(part, 3) for name, part in self.told_shares().items()},
            "spread": dict(
                zip((SKELETON.names[one] for one in self.joints), self.liveliness(share).round(3).tolist(), strict=True)
            ),
            "parts": [
                {
                    "joints": group.name,
                    "part": group.part,
                    "averaged": [
                        {
                            "drivers": choice.drivers.name,
                            "only_their_movement": choice.moving,
                            "window_s": choice.reach,
                            "mirrored_too": choice.mirrored,
                        }
                        for choice in group.choices
                    ],
                    "gains": [round(float(gain), 3) for gain in group.gains],
                    "told": [round(float(part), 3) for part in group.told],
                    "error_of_mean_pose_deg": round(float(np.degrees(np.sqrt(group.mean_error))), 2),
                    "error_deg": round(float(np.degrees(np.sqrt(group.error))), 2),
                }
                for group in self.groups
            ],
        }


def rotations_of(vectors: Float64, reference: Float64) -> Float64:
    """Return the rotations (T, n, 4) at rotation vectors (T, n, 3) from `reference` (n, 4)."""
    return np.asarray(quaternion.mul(reference, quaternion.from_rotation_vector(vectors)))


def damp_bands(signal: Float64, gains: Float64) -> Float64:
    """Return the signal (T, C) with each band multiplied by its gain (BAND_COUNT + 1,)."""
    return np.asarray(np.tensordot(gains, split_bands(signal, len(gains) - 1), axes=1))


def learn_upper_body(
    takes: Sequence[SampledClip], joints: Sequence[int], drive: DriverSet | None = None
) -> UpperBodyRegression:
    """Learn `joints` from what legs and pelvis do in `takes`, at least one; `drive` names the drivers, None: chosen.

    Deterministic. Takes seconds for some minutes of recordings. Choreographies, not takes, are left out: see
    `take_splits`.
    """
    joints = tuple(joints)
    lengths = [len(take.root) for take in takes]
    dances = choreographies(len(takes), find_copies(takes))
    folds = make_folds(lengths, dances)
    reference = np.asarray(mean_rotation(np.concatenate([take.rotation for take in takes])), np.float64)
    data = LearningData(takes, joints, reference, folds, whole_takes=dances.count > 1)
    if folds:
        choices = choose(data, (drive,) if drive else DRIVER_SETS)
    else:  # too short to leave anything out: nothing is known to be told
        only = Choice(drive or DRIVER_SETS[0], 0.0, False, False, *SMOOTHNESS[-1])
        choices = dict.fromkeys(data.groups, (only,))
    groups, predicted = [], np.zeros((sum(lengths), 3 * len(joints)))
    for key, columns in data.groups.items():
        group, left_out = _learn_group(data, key, choices[key])
        groups.append(group)
        predicted[:, columns % predicted.shape[1]] += left_out
    truth = data.turns(False)
    at = rotations_of(predicted.reshape(len(predicted), -1, 3), reference[list(joints)])
    away = np.asarray(quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(at), truth)), np.float64)
    residuals = np.concatenate([moving_part(part) for part in data.split(away.reshape(predicted.shape))])
    return UpperBodyRegression(joints, reference, tuple(groups), dances, residuals, data.starts, len(folds))


def _learn_group(data: LearningData, key: Key, choices: tuple[Choice, ...]) -> tuple[GroupRegression, Float64]:
    """Return the regression of a group, and its damped predictions of all samples, (S, C).

    These leave out the sample's own take where whole takes were left out. Elsewhere they would jump between the parts
    left out, so there they are the final regression's.
    """
    columns, part = data.groups[key], PARTS[key[1]]
    truth = data.targets[0][:, columns]
    fitted = fit(data, columns, choices)
    middle, means = fitted.middle, fitted.means
    gains, told, spreads = _fit_gains(data, truth - means, fitted.left_out, part)
    left_out = means + _damp_takes(data, fitted.left_out, gains)
    mean_error, error = _mean_square(truth - means), _mean_square(truth - left_out)
    if error >= mean_error:  # nothing is told: the mean pose it is
        gains, told, spreads, error = np.zeros_like(gains), np.zeros_like(told), np.zeros_like(spreads), mean_error
        middle, left_out = truth.mean(axis=0), means
    if not data.whole_takes:
        windows = [data.windows(one.drivers, one.reach, one.moving, False) for one in fitted.choices]
        left_out = middle + _damp_takes(data, fitted.predict(windows), gains)
    members = tuple(data.joints[int(n) % len(data.joints)] for n in columns[::3] // 3)
    variation = _mean_square(truth - left_out) if key[1] == "movement" else 0.0
    group = GroupRegression(*key, members, gains, told, mean_error, error, variation, spreads, fitted, middle)
    return group, left_out


def _fit_gains(data: LearningData, truth: Float64, predicted: Float64, part: slice) -> tuple[Float64, Float64, Float64]:
    """Return of each band the gain that leaves the least squared error, 0 to 1, and the share of variance it tells.

    Third, the square root of what it tells over what it leaves, 0 to 1.
    """
    products, squares, whole = (np.zeros(BAND_COUNT + 1) for _ in range(3))
    for real, made in zip(data.split(truth), data.split(predicted), strict=True):
        a, b = split_bands(real, BAND_COUNT), split_bands(made, BAND_COUNT)
        products += (a * b).sum(axis=(1, 2))
        squares += (b * b).sum(axis=(1, 2))
        whole += (a * a).sum(axis=(1, 2))
    gains = np.zeros(BAND_COUNT + 1)
    gains[part] = np.clip(products[part] / np.maximum(squares[part], 1e-12), 0.0, 1.0)
    gained = 2.0 * gains * products - gains**2 * squares
    spreads = np.sqrt(np.clip(gained / np.maximum(whole - gained, 1e-12), 0.0, 1.0))
    return gains, gained / np.maximum(whole, 1e-12), spreads


def _damp_takes(data: LearningData, predicted: Float64, gains: Float64) -> Float64:
    return np.concatenate([damp_bands(part, gains) for part in data.split(predicted)])


def _mean_square(vectors: Float64) -> float:
    """Return the mean squared length of rotation vectors (S, 3 n)."""
    return float(3.0 * (vectors * vectors).mean())
