"""Which drivers tell an upper body: kernel ridge regressions compared at choreographies left out (P023).

The regression is kernel ridge regression (Saunders, Gammerman and Vovk, Ridge regression learning algorithm in dual
variables, 1998) with a Gaussian kernel on a subset of the samples (Smola and Schölkopf, Sparse greedy matrix
approximation, 2000). Far from everything recorded it returns the mean.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion import quaternion
from live.motion.skeleton import SKELETON
from live.motion.texture.drivers import REACHES, ROTATIONS, DriverSet, driver_signals, mirror_sampled, windows_of
from live.motion.texture.fragment_search import squared_distances
from live.motion.texture.frequency_bands import SampledClip, split_bands
from live.motion.texture.take_splits import Fold
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
SMOOTHNESS: Final = ((1.0, 1e-3), (1.0, 1e-2), (2.0, 1e-3), (2.0, 1e-2))
"""Widths of the kernel, in standard deviations of the drivers (1 is half of the mean distance of two samples), and
weights of the penalty, for each sample."""
LEAST_GAIN: Final = 0.03
"""A choice must leave this much less squared error than the one before: few takes cannot tell smaller differences."""
BASIS: Final = 400
"""Most samples on which kernels are centred."""
CHOOSING_BASIS: Final = 200
"""The same while drivers are compared: an eighth of the time."""
EQUAL_SHARES: Final = 0.3
"""Pull of the driver sets to equal shares in a prediction, against their mean square."""
MAX_SAMPLES: Final = 6000
"""Most samples that are learnt from: of longer recordings every second, third ... is taken."""
LEAST_DEVIATION: Final = 0.02
"""A driver that varies less than this is not scaled up further: it stands still."""

Key = tuple[str, str]
"""Name of a group of joints and of a part of its motion."""


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
    width: float
    ridge: float


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Samples on which kernels are centred, and the scaling of windows."""

    middle: Float64
    scale: Float64
    centres: Float64
    """Scaled windows, (M, W D)."""

    def distances(self, windows: Float64) -> Float64:
        """Return the squared distances (T, M) of windows from the centres, in mean variances of a driver."""
        return squared_distances((windows - self.middle) * self.scale, self.centres)

    def kernel(self, windows: Float64, width: float) -> Float64:
        """Return the kernel (T, M) of windows (T, W D) and centres."""
        return gaussian(self.distances(windows), width)


def gaussian(distances: Float64, width: float) -> Float64:
    """Return the Gaussian kernel of squared distances."""
    return np.asarray(np.exp(distances * (-0.5 / width**2)))


def driver_windows(take: SampledClip, choice: Choice, reference: Float64) -> Float64:
    """Return the windows (T, W D) of a choice's drivers."""
    signals = driver_signals(take, choice.drivers, reference)
    return windows_of(moving_part(signals) if choice.moving else signals, choice.reach)


def moving_part(signal: Float64) -> Float64:
    """Return the bands of movement of a signal (T, C)."""
    bands = PARTS["movement"]
    return np.asarray(split_bands(signal, bands.stop)[bands].sum(axis=0))


class LearningData:
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
        self.groups: dict[Key, Int64] = {}
        """Columns of the targets of each group and part."""
        for (name, members), (number, part) in product(GROUPS.items(), enumerate(PARTS)):
            some = [n + number * len(joints) for n, joint in enumerate(joints) if joint in members]
            if some:
                self.groups[name, part] = np.array([3 * n + axis for n in some for axis in range(3)], np.int64)
        self.fits: dict[Choice, _Fit] = {}
        """Regressions of all columns that were made before."""
        self._signals: dict[tuple[DriverSet, bool, bool], list[Float64]] = {}

    def usable_folds(self) -> list[Fold]:
        """Return the folds that leave samples to learn from."""
        return [fold for fold in self.folds if fold.learnt[self.rows].any()]

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


class Design:
    """Windows of one choice of drivers, reach, bands and mirroring, and their distances from the basis."""

    def __init__(
        self,
        data: LearningData,
        drivers: DriverSet,
        reach: float,
        moving: bool,
        mirrored: bool,
        centres: int = BASIS,
    ) -> None:
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
        taken = np.unique(np.linspace(0, len(windows) - 1, min(centres, len(windows))).astype(np.int64))
        self.basis = Basis(middle, scale, (windows[taken] - middle) * scale)
        self._far = self.basis.distances(windows)
        self._near = self.basis.distances(windows[taken])

    def kernels(self, width: float) -> tuple[Float64, Float64]:
        """Return the kernel of samples and centres, (N, M), and that of the centres, (M, M)."""
        return gaussian(self._far, width), gaussian(self._near, width)


def solve_sums(products: Float64, sums: Float64, centres: Float64, penalty: float) -> Float64:
    """Return the weights (M, C) from KᵀK (M, M), KᵀY (M, C), the kernel of the centres (M, M) and the penalty."""
    from scipy.linalg import cho_factor, cho_solve

    size = len(centres)
    matrix = products + penalty * centres
    matrix[np.arange(size), np.arange(size)] += 1e-3 * penalty + 1e-9 * max(float(np.trace(products)) / size, 1e-12)
    return np.asarray(cho_solve(cho_factor(matrix, overwrite_a=True, check_finite=False), sums, check_finite=False))


def choose(data: LearningData, driver_sets: Sequence[DriverSet]) -> dict[Key, tuple[Choice, ...]]:
    """Return the choices that predict each group with the least squared error at samples left out, common ones first.

    There is one for each driver set, the best first.
    """
    least: dict[tuple[Key, DriverSet], float] = {}
    found: dict[tuple[Key, DriverSet], Choice] = {}
    for mirrored, moving, drivers, reach in product((False, True), (False, True), driver_sets, REACHES):
        if moving and drivers.measured != ROTATIONS:
            continue
        errors = _errors_left_out(data, Design(data, drivers, reach, moving, mirrored, CHOOSING_BASIS))
        for name, columns in data.groups.items():
            for (width, ridge), error in zip(SMOOTHNESS, errors[:, columns].sum(axis=1).tolist(), strict=True):
                if error < (1.0 - LEAST_GAIN) * least.get((name, drivers), np.inf):
                    least[name, drivers] = error
                    found[name, drivers] = Choice(drivers, reach, moving, mirrored, width, ridge)
    return {
        name: tuple(found[key] for key in sorted((one for one in found if one[0] == name), key=lambda one: least[one]))
        for name in data.groups
    }


def _errors_left_out(data: LearningData, design: Design) -> Float64:
    """Return the squared errors of all columns at the samples left out, for each smoothness, (len(SMOOTHNESS), C)."""
    real = np.arange(len(design.row)) < len(data.rows)
    errors = np.zeros((len(SMOOTHNESS), data.targets[0].shape[1]))
    for width in dict.fromkeys(width for width, _ in SMOOTHNESS):
        kernel, centres = design.kernels(width)
        whole = kernel.T @ kernel
        for fold in data.folds:
            learnt, tested = fold.learnt[design.row], fold.tested[design.row] & real
            if not learnt.any():
                continue
            left, rest = kernel[~learnt], kernel[learnt]
            middle = design.targets[learnt].mean(axis=0)
            products, sums = whole - left.T @ left, rest.T @ (design.targets[learnt] - middle)
            for n, (wide, ridge) in enumerate(SMOOTHNESS):
                if wide == width:
                    away = design.targets[tested] - middle
                    away -= kernel[tested] @ solve_sums(products, sums, centres, ridge * len(rest))
                    errors[n] += (away * away).sum(axis=0)
    return errors


@dataclass(frozen=True, slots=True, eq=False)
class FittedChoices:
    """The regression of a group, the mean of that of several choices, and what it predicts of samples left out."""

    choices: tuple[Choice, ...]
    fitted: tuple[tuple[Basis, Float64], ...]
    """Of each choice the basis and the weights (M, C) of its share."""
    middle: Float64
    """Mean of what was learnt from, (C,)."""
    means: Float64
    """Of each sample the mean of what was learnt from without it, (S, C)."""
    left_out: Float64
    """What was predicted of it then, as deviations from that, (S, C)."""

    def predict(self, windows: Sequence[Float64]) -> Float64:
        """Return the deviations (T, C) from the mean at windows (T, W D), one array for each choice."""
        parts = zip(self.choices, self.fitted, windows, strict=True)
        made = [basis.kernel(some, choice.width) @ weights for choice, (basis, weights), some in parts]
        return np.asarray(np.sum(made, axis=0))


def fit(data: LearningData, columns: Int64, choices: Sequence[Choice]) -> FittedChoices:
    """Return the regression of the group with `columns`: the mean of those of `choices`, which err in different ways.

    Each has the share that fits samples left out best; those with none are dropped.
    """
    truth = data.targets[0][:, columns]
    means = np.broadcast_to(truth.mean(axis=0), truth.shape).copy()
    folds = data.usable_folds()
    for fold in folds:
        means[fold.tested] = truth[fold.learnt].mean(axis=0)
    fits = [_fit_one(data, choice, folds) for choice in choices]
    left_out = [one.made[:, columns] - means for one in fits]
    shares = _shares(truth - means, left_out)
    used = np.flatnonzero(shares > 0.0).tolist()
    return FittedChoices(
        tuple(choices[n] for n in used),
        tuple((fits[n].basis, shares[n] * fits[n].weights[:, columns]) for n in used),
        np.asarray(np.tensordot(shares, [one.middle[columns] for one in fits], axes=1)),
        means,
        np.asarray(np.tensordot(shares, left_out, axes=1)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """The regression of all columns by one choice, and what it predicts of samples left out, (S, C)."""

    basis: Basis
    weights: Float64
    middle: Float64
    made: Float64


def _fit_one(data: LearningData, choice: Choice, folds: Sequence[Fold]) -> _Fit:
    """Groups share choices, so each is kept."""
    if choice not in data.fits:
        design = Design(data, choice.drivers, choice.reach, choice.moving, choice.mirrored)
        kernel, centres = design.kernels(choice.width)
        whole, targets = kernel.T @ kernel, design.targets
        windows = data.windows(choice.drivers, choice.reach, choice.moving, False)
        middle = targets.mean(axis=0)
        weights = solve_sums(whole, kernel.T @ (targets - middle), centres, choice.ridge * len(kernel))
        made = np.broadcast_to(data.targets[0].mean(axis=0), data.targets[0].shape).copy()
        for fold in folds:
            learnt = fold.learnt[design.row]
            left, rest = kernel[~learnt], kernel[learnt]
            mean = targets[learnt].mean(axis=0)
            sums = rest.T @ (targets[learnt] - mean)
            some = solve_sums(whole - left.T @ left, sums, centres, choice.ridge * len(rest))
            made[fold.tested] = mean + design.basis.kernel(windows[fold.tested], choice.width) @ some
        data.fits[choice] = _Fit(design.basis, weights, middle, made)
    return data.fits[choice]


def _shares(truth: Float64, predicted: Sequence[Float64]) -> Float64:
    """Return the shares, from 0, with sum 1, of predictions (S, C) in their mean: stacked regression (Breiman 1996).

    They fit samples left out best, but are drawn to equal shares, because takes are few.
    """
    from scipy.optimize import nnls

    count = len(predicted)
    products = np.array([[float((a * b).sum()) for b in predicted] for a in predicted])
    sums = np.array([float((a * truth).sum()) for a in predicted])
    pull = EQUAL_SHARES * float(np.trace(products)) / count
    if not pull > 1e-12:
        return np.full(count, 1.0 / count)
    products += pull * np.eye(count)
    root = np.linalg.cholesky(products)
    found, _ = nnls(root.T, np.linalg.solve(root, sums + pull / count))
    return np.asarray(found / found.sum()) if found.sum() > 0.0 else np.full(count, 1.0 / count)
