"""What legs tell about the upper body: kernel ridge regression chosen and damped by cross-validation (P023).

Each group of joints gets the drivers, the window and the smoothness that predict it best at takes left out. Then each
frequency band of the prediction is multiplied by the gain that fits takes left out best, from 0 (the mean pose) to 1.
So no band moves that the drivers do not tell. The regression is kernel ridge regression (Saunders, Gammerman and
Vovk, Ridge regression learning algorithm in dual variables, 1998) with a Gaussian kernel on a subset of the samples
(Smola and Schölkopf, Sparse greedy matrix approximation, 2000). Far from everything recorded it returns the mean.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np

from live.base.arrays import Bool, Float64, Int64
from live.motion import quaternion
from live.motion.quaternion import mean_rotation
from live.motion.skeleton import SKELETON
from live.motion.texture.drivers import DRIVER_SETS, REACHES, DriverSet, driver_signals, mirror_sampled, windows_of
from live.motion.texture.frequency_bands import SampledClip, split_bands
from live.motion.texture.take_splits import Choreographies, Fold, choreographies, find_copies, make_folds
from live.motion.texture.texture_settings import JOINT_GROUPS

GROUPS: Final = {
    "trunk": JOINT_GROUPS["trunk"],
    "head": JOINT_GROUPS["head"],
    "upper arms": tuple(n for n, name in enumerate(SKELETON.names) if name.endswith(("Shoulder", "UpperArm"))),
    "lower arms": tuple(n for n, name in enumerate(SKELETON.names) if name.endswith(("LowerArm", "Hand"))),
}
"""Joints that are predicted together."""
BAND_COUNT: Final = 6
"""Bands that get a gain of their own; everything slower, with the mean, gets one more."""
WIDTH: Final = 1.0
"""Width of the kernel, in standard deviations of the drivers: half of the mean distance of two samples."""
RIDGES: Final = (1e-3, 1e-2)
"""Weights of the penalty, for each sample."""
LEAST_GAIN: Final = 0.03
"""A choice must leave this much less squared error than the one before: few takes cannot tell smaller differences."""
BASIS: Final = 400
"""Most samples on which kernels are centred."""
MAX_SAMPLES: Final = 6000
"""Most samples that are learnt from: of longer recordings every second, third ... is taken."""
LEAST_DEVIATION: Final = 0.02
"""A driver that varies less than this is not scaled up further: it stands still."""
KERNEL_FACTOR: Final = -0.5 / WIDTH**2


@dataclass(frozen=True, slots=True)
class Choice:
    """What cross-validation chooses for a group of joints."""

    drivers: DriverSet
    reach: float
    """Reach of the window to both sides [s]."""
    mirrored: bool
    """Whether mirrored takes are learnt from, too."""
    ridge: float


@dataclass(frozen=True, slots=True, eq=False)
class _Basis:
    """Samples on which kernels are centred, and the scaling of windows."""

    middle: Float64
    scale: Float64
    centres: Float64
    """Scaled windows, (M, W D)."""

    def distances(self, windows: Float64) -> Float64:
        """Return the squared distances (T, M) of windows from the centres, in mean variances of a driver."""
        scaled = (windows - self.middle) * self.scale
        squares = (scaled * scaled).sum(axis=1)[:, None] + (self.centres * self.centres).sum(axis=1)
        return np.maximum(squares - 2.0 * scaled @ self.centres.T, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class GroupRegression:
    """The regression of one group of joints, and what it is worth at takes left out."""

    name: str
    joints: tuple[int, ...]
    choice: Choice
    gains: Float64
    """Gain of each band and of all that is slower, (BAND_COUNT + 1,)."""
    told: Float64
    """Share of each band's variance that is predicted at takes left out, (BAND_COUNT + 1,)."""
    mean_error: float
    """Mean squared angle from the mean pose at takes left out [rad²]."""
    error: float
    """Mean squared angle from the damped prediction at takes left out [rad²]."""
    variation: float
    """Mean square of bands 2 to BAND_COUNT of what the prediction leaves [rad²]."""
    _basis: _Basis
    _weights: Float64
    _middle: Float64

    @property
    def told_share(self) -> float:
        """Share of the movement about the mean pose that is told, 0 (nothing) to 1."""
        return max(0.0, 1.0 - self.error / self.mean_error) if self.mean_error > 1e-12 else 0.0

    def spread(self, share: float) -> float:
        """Return the factor by which what is left of a recording may be added.

        Variation that is independent of the truth adds its mean square to the expected squared error. It may use
        `share` (0 to 1) of what the prediction gains over the mean pose, so the result stays nearer than that.
        """
        budget = share * max(self.mean_error - self.error, 0.0)
        return float(min(1.0, np.sqrt(budget / self.variation))) if self.variation > 1e-12 else 0.0

    def predict(self, windows: Float64) -> Float64:
        """Return the damped rotation vectors (T, 3 n) of the group's joints, from their mean rotations."""
        kernel = np.exp(self._basis.distances(windows) * KERNEL_FACTOR)
        return self._middle + damp_bands(kernel @ self._weights, self.gains)


@dataclass(frozen=True, slots=True, eq=False)
class UpperBodyRegression:
    """Regression of upper joints on legs and pelvis."""

    joints: tuple[int, ...]
    reference: Float64
    """Mean rotation of every joint, (J, 4)."""
    groups: tuple[GroupRegression, ...]
    dances: Choreographies
    residuals: Float64
    """Bands 2 to BAND_COUNT of the rotation vectors of the joints of all takes from their prediction, (S, 3 n)."""
    fold_count: int

    def predict(self, take: SampledClip) -> Float64:
        """Return the rotation vectors (T, 3 n) of `joints`, from `reference`, told by the lower body of `take`."""
        vectors = np.zeros((len(take.root), len(self.joints), 3))
        windows: dict[tuple[DriverSet, float], Float64] = {}
        for group in self.groups:
            key = (group.choice.drivers, group.choice.reach)
            if key not in windows:
                windows[key] = windows_of(driver_signals(take, key[0], self.reference), key[1])
            rows = [self.joints.index(joint) for joint in group.joints]
            vectors[:, rows] = group.predict(windows[key]).reshape(len(vectors), len(rows), 3)
        return vectors.reshape(len(vectors), -1)

    def rotations(self, vectors: Float64, variation: Float64) -> Float64:
        """Return the rotations (T, n, 4) at `vectors` (T, 3 n) from the mean, turned by `variation` (T, 3 n)."""
        shape = (len(vectors), len(self.joints), 3)
        at = rotations_of(vectors.reshape(shape), self.reference[list(self.joints)])
        return rotations_of(variation.reshape(shape), at)

    def spreads(self, share: float) -> Float64:
        """Return the factor of variation of each of `joints`, (n,)."""
        out = np.zeros(len(self.joints))
        for group in self.groups:
            out[[self.joints.index(joint) for joint in group.joints]] = group.spread(share)
        return out

    def report(self, share: float) -> dict[str, Any]:
        """Return what the drivers tell of each group and band, as JSON values."""
        return {
            "choreographies": self.dances.number.tolist(),
            "splits": self.fold_count,
            "left_out": "whole choreographies" if self.dances.count > 1 else "parts of the only choreography",
            "groups": {
                group.name: {
                    "drivers": group.choice.drivers.name,
                    "window_s": group.choice.reach,
                    "mirrored_too": group.choice.mirrored,
                    "gains": [round(float(gain), 3) for gain in group.gains],
                    "told": [round(float(part), 3) for part in group.told],
                    "error_of_mean_pose_deg": round(float(np.degrees(np.sqrt(group.mean_error))), 2),
                    "error_deg": round(float(np.degrees(np.sqrt(group.error))), 2),
                    "spread": round(group.spread(share), 3),
                }
                for group in self.groups
            },
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
    reference = mean_rotation(np.concatenate([take.rotation for take in takes]))
    data = _Data(takes, joints, reference, folds, whole_takes=dances.count > 1)
    if folds:
        choices = _choose(data, (drive,) if drive else DRIVER_SETS)
    else:  # too short to leave anything out: nothing is known to be told
        choices = {name: Choice(drive or DRIVER_SETS[0], 0.0, False, RIDGES[-1]) for name in data.groups}
    groups, predicted = [], np.zeros((sum(lengths), 3 * len(joints)))
    for name, columns in data.groups.items():
        group, left_out = _learn_group(data, name, columns, choices[name])
        groups.append(group)
        predicted[:, columns] = left_out
    truth = data.turns(False)
    at = rotations_of(predicted.reshape(len(predicted), -1, 3), reference[list(joints)])
    away = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(at), truth))
    residuals = np.concatenate([_moving(part) for part in data.split(away.reshape(predicted.shape))])
    return UpperBodyRegression(joints, reference, tuple(groups), dances, residuals, len(folds))


class _Data:
    """Takes as windows and targets, with the folds, for all choices."""

    def __init__(
        self,
        takes: Sequence[SampledClip],
        joints: tuple[int, ...],
        reference: Float64,
        folds: Sequence[Fold],
        *,
        whole_takes: bool,
    ) -> None:
        self.takes, self.whole_takes = takes, whole_takes
        self.mirrored = [mirror_sampled(take) for take in takes]
        self.joints, self.reference, self.folds = joints, reference, folds
        self.starts = np.cumsum([0, *(len(take.root) for take in takes)])
        step = max(1, -(-int(self.starts[-1]) // MAX_SAMPLES))
        self.rows: Int64 = np.arange(0, int(self.starts[-1]), max(step, 2))
        self.targets = [self._targets(mirrored) for mirrored in (False, True)]
        self.groups: dict[str, Int64] = {}
        for name, members in GROUPS.items():
            some = [n for n, joint in enumerate(joints) if joint in members]
            if some:
                self.groups[name] = np.array([3 * n + axis for n in some for axis in range(3)], np.int64)
        self._signals: dict[tuple[DriverSet, bool], list[Float64]] = {}

    def split(self, values: Float64) -> list[Float64]:
        """Return the values (S, ...) of each take."""
        return np.split(values, self.starts[1:-1])

    def turns(self, mirrored: bool) -> Float64:
        """Return the rotations of the joints of all takes, (S, n, 4)."""
        takes = self.mirrored if mirrored else self.takes
        return np.concatenate([take.rotation[:, list(self.joints)] for take in takes])

    def _targets(self, mirrored: bool) -> Float64:
        away = quaternion.mul(quaternion.inverse(self.reference[list(self.joints)]), self.turns(mirrored))
        return np.asarray(quaternion.to_rotation_vector(away).reshape(len(away), -1))

    def windows(self, drivers: DriverSet, reach: float, mirrored: bool) -> Float64:
        """Return the windows of all samples, (S, W D)."""
        if (drivers, mirrored) not in self._signals:
            takes = self.mirrored if mirrored else self.takes
            self._signals[drivers, mirrored] = [driver_signals(take, drivers, self.reference) for take in takes]
        return np.concatenate([windows_of(one, reach) for one in self._signals[drivers, mirrored]])


class _Design:
    """Windows of one choice of drivers, reach and mirroring, and their distances from the basis."""

    def __init__(self, data: _Data, drivers: DriverSet, reach: float, mirrored: bool) -> None:
        self.data = data
        parts = [data.windows(drivers, reach, False)[data.rows]]
        targets = [data.targets[0][data.rows]]
        if mirrored:
            parts.append(data.windows(drivers, reach, True)[data.rows])
            targets.append(data.targets[1][data.rows])
        self.row = np.concatenate([data.rows] * len(parts))
        windows, self.targets = np.concatenate(parts), np.concatenate(targets)
        middle = windows.mean(axis=0)
        scale = 1.0 / (np.maximum(windows.std(axis=0), LEAST_DEVIATION) * np.sqrt(windows.shape[1]))
        taken = np.unique(np.linspace(0, len(windows) - 1, min(BASIS, len(windows))).astype(np.int64))
        self.basis = _Basis(middle, scale, (windows[taken] - middle) * scale)
        self._far = self.basis.distances(windows)
        self._near = self.basis.distances(windows[taken])

    def kernels(self) -> tuple[Float64, Float64]:
        """Return the kernel of samples and centres, (N, M), and that of the centres, (M, M)."""
        return np.exp(self._far * KERNEL_FACTOR), np.exp(self._near * KERNEL_FACTOR)


def _solve(kernel: Float64, centres: Float64, targets: Float64, ridge: float) -> tuple[Float64, Float64]:
    """Return the weights (M, C) and the mean (C,) of a fit."""
    middle = targets.mean(axis=0)
    return _solve_sums(kernel.T @ kernel, kernel.T @ (targets - middle), centres, ridge * len(kernel)), middle


def _solve_sums(products: Float64, sums: Float64, centres: Float64, penalty: float) -> Float64:
    from scipy.linalg import cho_factor, cho_solve

    size = len(centres)
    matrix = products + penalty * centres
    matrix[np.arange(size), np.arange(size)] += 1e-3 * penalty + 1e-9 * max(float(np.trace(products)) / size, 1e-12)
    return np.asarray(cho_solve(cho_factor(matrix, overwrite_a=True, check_finite=False), sums, check_finite=False))


def _choose(data: _Data, driver_sets: Sequence[DriverSet]) -> dict[str, Choice]:
    """Return the choice with the least squared error at samples left out, for each group, common ones first."""
    least = dict.fromkeys(data.groups, np.inf)
    found: dict[str, Choice] = {}
    for mirrored, drivers, reach in product((False, True), driver_sets, REACHES):
        errors = _errors_left_out(data, _Design(data, drivers, reach, mirrored))
        for name, columns in data.groups.items():
            for ridge, error in zip(RIDGES, errors[:, columns].sum(axis=1).tolist(), strict=True):
                if error < (1.0 - LEAST_GAIN) * least[name]:
                    least[name], found[name] = error, Choice(drivers, reach, mirrored, ridge)
    return found


def _errors_left_out(data: _Data, design: _Design) -> Float64:
    """Return the squared errors of all columns at the samples left out, for each ridge, (len(RIDGES), C)."""
    kernel, centres = design.kernels()
    whole = kernel.T @ kernel
    real = np.arange(len(design.row)) < len(data.rows)
    errors = np.zeros((len(RIDGES), data.targets[0].shape[1]))
    for fold in data.folds:
        learnt, tested = fold.learnt[design.row], fold.tested[design.row] & real
        if not learnt.any():
            continue
        left, rest = kernel[~learnt], kernel[learnt]
        middle = design.targets[learnt].mean(axis=0)
        products, sums = whole - left.T @ left, rest.T @ (design.targets[learnt] - middle)
        for n, ridge in enumerate(RIDGES):
            away = design.targets[tested] - middle
            away -= kernel[tested] @ _solve_sums(products, sums, centres, ridge * len(rest))
            errors[n] += (away * away).sum(axis=0)
    return errors


def _learn_group(data: _Data, name: str, columns: Int64, choice: Choice) -> tuple[GroupRegression, Float64]:
    """Return the regression of a group, and its damped predictions of all samples, (S, C).

    These leave out the sample's own take where whole takes were left out. Elsewhere they would jump between the parts
    left out, so there they are the final regression's.
    """
    design = _Design(data, choice.drivers, choice.reach, choice.mirrored)
    kernel, centres = design.kernels()
    targets, truth = design.targets[:, columns], data.targets[0][:, columns]
    windows = data.windows(choice.drivers, choice.reach, False)
    weights, middle = _solve(kernel, centres, targets, choice.ridge)

    def evaluate(rows: Bool | slice, some: Float64) -> Float64:
        return np.asarray(np.exp(design.basis.distances(windows[rows]) * KERNEL_FACTOR) @ some)

    raw = np.zeros_like(truth)
    means, plain = np.broadcast_to(truth.mean(axis=0), truth.shape).copy(), np.empty_like(truth)
    plain[:] = truth.mean(axis=0)
    for fold in data.folds:
        learnt = fold.learnt[design.row]
        if learnt.any():
            some, means[fold.tested] = _solve(kernel[learnt], centres, targets[learnt], choice.ridge)
            raw[fold.tested] = evaluate(fold.tested, some)
            plain[fold.tested] = truth[fold.learnt].mean(axis=0)
    gains, told = _fit_gains(data, truth - means, raw)
    left_out = means + _damp_takes(data, raw, gains)
    mean_error, error = _mean_square(truth - plain), _mean_square(truth - left_out)
    if error >= mean_error:  # nothing is told: the mean pose it is
        gains, told, error = np.zeros_like(gains), np.zeros_like(told), mean_error
        middle, left_out = truth.mean(axis=0), plain
    if not data.whole_takes:
        left_out = middle + _damp_takes(data, evaluate(slice(None), weights), gains)
    members = tuple(data.joints[int(n)] for n in columns[::3] // 3)
    variation = _mean_square(np.concatenate([_moving(part) for part in data.split(truth - left_out)]))
    group = GroupRegression(
        name, members, choice, gains, told, mean_error, error, variation, design.basis, weights, middle
    )
    return group, left_out


def _fit_gains(data: _Data, truth: Float64, predicted: Float64) -> tuple[Float64, Float64]:
    """Return the gain of each band that leaves the least squared error, 0 to 1, and the share of variance it tells."""
    products, squares, whole = (np.zeros(BAND_COUNT + 1) for _ in range(3))
    for real, made in zip(data.split(truth), data.split(predicted), strict=True):
        a, b = split_bands(real, BAND_COUNT), split_bands(made, BAND_COUNT)
        products += (a * b).sum(axis=(1, 2))
        squares += (b * b).sum(axis=(1, 2))
        whole += (a * a).sum(axis=(1, 2))
    gains = np.clip(products / np.maximum(squares, 1e-12), 0.0, 1.0)
    gains[0] = 0.0  # band 1 is noise, and dropped as in the published method (P018)
    told = (2.0 * gains * products - gains**2 * squares) / np.maximum(whole, 1e-12)
    return gains, told


def _damp_takes(data: _Data, predicted: Float64, gains: Float64) -> Float64:
    return np.concatenate([damp_bands(part, gains) for part in data.split(predicted)])


def _moving(signal: Float64) -> Float64:
    """Return bands 2 to BAND_COUNT of a signal (T, C): variation without the pose it is about."""
    return np.asarray(split_bands(signal, BAND_COUNT)[1:BAND_COUNT].sum(axis=0))


def _mean_square(vectors: Float64) -> float:
    """Return the mean squared length of rotation vectors (S, 3 n)."""
    return float(3.0 * (vectors * vectors).mean())
