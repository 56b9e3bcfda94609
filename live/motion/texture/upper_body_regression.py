"""What legs tell about the upper body: kernel ridge regression chosen and damped by cross-validation (P023).

The pose of each group of joints and its movement (bands 2 to 5) each get the drivers, their bands, the window and the
smoothness that predict them best at takes left out. Then each frequency band of the prediction is multiplied by the
gain that fits takes left out best, from 0 (the mean pose) to 1. So no band moves that the drivers do not tell. The
regression is kernel ridge regression (Saunders, Gammerman and Vovk, Ridge regression learning algorithm in dual
variables, 1998) with a Gaussian kernel on a subset of the samples (Smola and Schölkopf, Sparse greedy matrix
approximation, 2000). Far from everything recorded it returns the mean.
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
PARTS: Final = {"movement": slice(1, 5), "pose": slice(5, None)}
"""Bands, from 0, that are predicted together: slower ones are poses. Band 1 is noise, and dropped (P018)."""
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
    moving: bool
    """Whether only the movement of the drivers counts, not their pose."""
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
        return np.asarray(np.maximum(squares - 2.0 * scaled @ self.centres.T, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class GroupRegression:
    """The regression of one part of a group of joints, and what it is worth at takes left out."""

    name: str
    part: str
    """One of `PARTS`."""
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
    """Mean square of the movement that the prediction leaves [rad²], 0 for poses."""
    _basis: _Basis
    _weights: Float64
    _middle: Float64

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
    """Movement of the rotation vectors of the joints of all takes from their prediction, (S, 3 n)."""
    fold_count: int

    def predict(self, take: SampledClip) -> Float64:
        """Return the rotation vectors (T, 3 n) of `joints`, from `reference`, told by the lower body of `take`."""
        vectors = np.zeros((len(take.root), len(self.joints), 3))
        for group in self.groups:
            rows = [self.joints.index(joint) for joint in group.joints]
            windows = driver_windows(take, group.choice, self.reference)
            vectors[:, rows] += group.predict(windows).reshape(len(vectors), len(rows), 3)
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

    def spreads(self, share: float) -> Float64:
        """Return the factor of each of `joints`, (n,), by which what the prediction leaves of a recording may be added.

        Variation that is independent of the truth adds its mean square to the expected squared error. It may use
        `share` (0 to 1) of what the prediction gains over the mean pose, so the result stays nearer than that.
        """
        out = np.zeros(len(self.joints))
        for parts in self._parts().values():
            budget = share * sum(part.mean_error - part.error for part in parts)
            variation = sum(part.variation for part in parts)
            if variation > 1e-12:
                rows = [self.joints.index(joint) for joint in parts[0].joints]
                out[rows] = min(1.0, float(np.sqrt(max(budget, 0.0) / variation)))
        return out

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
                zip((SKELETON.names[one] for one in self.joints), self.spreads(share).round(3).tolist(), strict=True)
            ),
            "parts": [
                {
                    "joints": group.name,
                    "part": group.part,
                    "drivers": group.choice.drivers.name,
                    "only_their_movement": group.choice.moving,
                    "window_s": group.choice.reach,
                    "mirrored_too": group.choice.mirrored,
                    "gains": [round(float(gain), 3) for gain in group.gains],
                    "told": [round(float(part), 3) for part in group.told],
                    "error_of_mean_pose_deg": round(float(np.degrees(np.sqrt(group.mean_error))), 2),
                    "error_deg": round(float(np.degrees(np.sqrt(group.error))), 2),
                }
                for group in self.groups
            ],
        }


def driver_windows(take: SampledClip, choice: "Choice", reference: Float64) -> Float64:
    """Return the windows (T, W D) of a choice's drivers."""
    signals = driver_signals(take, choice.drivers, reference)
    return windows_of(moving_part(signals) if choice.moving else signals, choice.reach)


def moving_part(signal: Float64) -> Float64:
    """Return the bands of movement of a signal (T, C)."""
    bands = PARTS["movement"]
    return np.asarray(split_bands(signal, bands.stop)[bands].sum(axis=0))


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
    data = _Data(takes, joints, reference, folds, whole_takes=dances.count > 1)
    if folds:
        choices = _choose(data, (drive,) if drive else DRIVER_SETS)
    else:  # too short to leave anything out: nothing is known to be told
        choices = {one: Choice(drive or DRIVER_SETS[0], 0.0, False, False, RIDGES[-1]) for one in data.groups}
    groups, predicted = [], np.zeros((sum(lengths), 3 * len(joints)))
    for key, columns in data.groups.items():
        group, left_out = _learn_group(data, key, choices[key])
        groups.append(group)
        predicted[:, columns % predicted.shape[1]] += left_out
    truth = data.turns(False)
    at = rotations_of(predicted.reshape(len(predicted), -1, 3), reference[list(joints)])
    away = np.asarray(quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(at), truth)), np.float64)
    residuals = np.concatenate([moving_part(part) for part in data.split(away.reshape(predicted.shape))])
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
        self.groups: dict[tuple[str, str], Int64] = {}
        """Columns of the targets of each group and part."""
        for (name, members), (number, part) in product(GROUPS.items(), enumerate(PARTS)):
            some = [n + number * len(joints) for n, joint in enumerate(joints) if joint in members]
            if some:
                self.groups[name, part] = np.array([3 * n + axis for n in some for axis in range(3)], np.int64)
        self._signals: dict[tuple[DriverSet, bool, bool], list[Float64]] = {}

    def split(self, values: Float64) -> list[Float64]:
        """Return the values (S, ...) of each take."""
        return np.split(values, self.starts[1:-1])

    def turns(self, mirrored: bool) -> Float64:
        """Return the rotations of the joints of all takes, (S, n, 4)."""
        takes = self.mirrored if mirrored else self.takes
        return np.concatenate([take.rotation[:, list(self.joints)] for take in takes])

    def _targets(self, mirrored: bool) -> Float64:
        away = quaternion.mul(quaternion.inverse(self.reference[list(self.joints)]), self.turns(mirrored))
        vectors = np.asarray(quaternion.to_rotation_vector(away), np.float64).reshape(len(away), -1)
        takes = [split_bands(part, BAND_COUNT) for part in self.split(vectors)]
        return np.concatenate(
            [np.concatenate([bands[part].sum(axis=0) for bands in takes]) for part in PARTS.values()], 1
        )

    def windows(self, drivers: DriverSet, reach: float, moving: bool, mirrored: bool) -> Float64:
        """Return the windows of all samples, (S, W D)."""
        key = (drivers, moving, mirrored)
        if key not in self._signals:
            takes = self.mirrored if mirrored else self.takes
            signals = [driver_signals(take, drivers, self.reference) for take in takes]
            self._signals[key] = [moving_part(one) for one in signals] if moving else signals
        return np.concatenate([windows_of(one, reach) for one in self._signals[key]])


class _Design:
    """Windows of one choice of drivers, reach, bands and mirroring, and their distances from the basis."""

    def __init__(self, data: _Data, drivers: DriverSet, reach: float, moving: bool, mirrored: bool) -> None:
        self.data = data
        parts = [data.windows(drivers, reach, moving, False)[data.rows]]
        targets = [data.targets[0][data.rows]]
        if mirrored:
            parts.append(data.windows(drivers, reach, moving, True)[data.rows])
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


def _choose(data: _Data, driver_sets: Sequence[DriverSet]) -> dict[tuple[str, str], Choice]:
    """Return the choice with the least squared error at samples left out, for each group, common ones first."""
    least = dict.fromkeys(data.groups, np.inf)
    found: dict[tuple[str, str], Choice] = {}
    for mirrored, moving, drivers, reach in product((False, True), (False, True), driver_sets, REACHES):
        errors = _errors_left_out(data, _Design(data, drivers, reach, moving, mirrored))
        for name, columns in data.groups.items():
            for ridge, error in zip(RIDGES, errors[:, columns].sum(axis=1).tolist(), strict=True):
                if error < (1.0 - LEAST_GAIN) * least[name]:
                    least[name], found[name] = error, Choice(drivers, reach, moving, mirrored, ridge)
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


def _learn_group(data: _Data, key: tuple[str, str], choice: Choice) -> tuple[GroupRegression, Float64]:
    """Return the regression of a group, and its damped predictions of all samples, (S, C).

    These leave out the sample's own take where whole takes were left out. Elsewhere they would jump between the parts
    left out, so there they are the final regression's.
    """
    columns, part = data.groups[key], PARTS[key[1]]
    design = _Design(data, choice.drivers, choice.reach, choice.moving, choice.mirrored)
    kernel, centres = design.kernels()
    targets, truth = design.targets[:, columns], data.targets[0][:, columns]
    windows = data.windows(choice.drivers, choice.reach, choice.moving, False)
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
    gains, told = _fit_gains(data, truth - means, raw, part)
    left_out = means + _damp_takes(data, raw, gains)
    mean_error, error = _mean_square(truth - plain), _mean_square(truth - left_out)
    if error >= mean_error:  # nothing is told: the mean pose it is
        gains, told, error = np.zeros_like(gains), np.zeros_like(told), mean_error
        middle, left_out = truth.mean(axis=0), plain
    if not data.whole_takes:
        left_out = middle + _damp_takes(data, evaluate(slice(None), weights), gains)
    members = tuple(data.joints[int(n) % len(data.joints)] for n in columns[::3] // 3)
    variation = _mean_square(truth - left_out) if key[1] == "movement" else 0.0
    group = GroupRegression(
        *key, members, choice, gains, told, mean_error, error, variation, design.basis, weights, middle
    )
    return group, left_out


def _fit_gains(data: _Data, truth: Float64, predicted: Float64, part: slice) -> tuple[Float64, Float64]:
    """Return the gain of each band that leaves the least squared error, 0 to 1, and the share of variance it tells."""
    products, squares, whole = (np.zeros(BAND_COUNT + 1) for _ in range(3))
    for real, made in zip(data.split(truth), data.split(predicted), strict=True):
        a, b = split_bands(real, BAND_COUNT), split_bands(made, BAND_COUNT)
        products += (a * b).sum(axis=(1, 2))
        squares += (b * b).sum(axis=(1, 2))
        whole += (a * a).sum(axis=(1, 2))
    gains = np.zeros(BAND_COUNT + 1)
    gains[part] = np.clip(products[part] / np.maximum(squares[part], 1e-12), 0.0, 1.0)
    told = (2.0 * gains * products - gains**2 * squares) / np.maximum(whole, 1e-12)
    return gains, told


def _damp_takes(data: _Data, predicted: Float64, gains: Float64) -> Float64:
    return np.concatenate([damp_bands(part, gains) for part in data.split(predicted)])


def _mean_square(vectors: Float64) -> float:
    """Return the mean squared length of rotation vectors (S, 3 n)."""
    return float(3.0 * (vectors * vectors).mean())
