"""Complete-linkage clustering: of units that say nearly the same only one stays (H011)."""

import numpy as np
import numpy.typing as npt
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from live.motion.partner.fit import stretched
from live.motion.partner.units import Units

Float64 = npt.NDArray[np.float64]

SAMPLES = 8
"""Steps in which two units are compared, stretched to each other."""


def unit_distances(units: Units) -> Float64:
    """Distances (1) of all units from each other [m], rms over points and samples of controls and targets, (N, N).

    One motion M, that of the controls, lies on both: units whose leaders do the same and whose followers do not are
    far from each other. Units whose lengths differ are compared at one length.
    """
    pairs = [
        (
            stretched(of.control, float(start), float(length), SAMPLES),
            stretched(of.target, float(start), float(length), SAMPLES),
        )
        for of, start, length in (
            (units.examples[int(units.example[n])], units.start[n], units.length[n]) for n in range(units.count)
        )
    ]
    control = np.array([a.floor.ravel() for a, _ in pairs])
    middle = control.mean(axis=1)
    control = control - middle[:, None]
    product = control @ control.conj().T  # x conj(a): a is laid on x
    norm = np.abs(product)
    turn = np.where(norm > 1e-12, product / np.maximum(norm, 1e-12), 1.0)
    height = np.array([a.height.ravel() for a, _ in pairs])
    target = np.array([b.floor.ravel() for _, b in pairs]) - middle[:, None]
    target_height = np.array([b.height.ravel() for _, b in pairs])
    size = (np.abs(control) ** 2).sum(axis=1)
    size_b = (np.abs(target) ** 2).sum(axis=1)
    square = size[:, None] + size[None] - 2.0 * norm + _squares(height)
    across = (target @ target.conj().T) * turn.conj()
    square += size_b[:, None] + size_b[None] - 2.0 * across.real + _squares(target_height)
    count = control.shape[1] + target.shape[1]
    root = np.sqrt(np.maximum(square, 0.0) / count)
    np.fill_diagonal(root, 0.0)
    return np.asarray(0.5 * (root + root.T))


def _squares(rows: Float64) -> Float64:
    size = (rows**2).sum(axis=1)
    return np.asarray(size[:, None] + size[None] - 2.0 * rows @ rows.T)


def thin_out(units: Units, threshold: float, *, seed: int) -> Units:
    """One unit, drawn by `seed`, of each cluster in which no two are farther apart than `threshold` [m]."""
    if units.count < 2 or threshold <= 0.0:
        return units
    tree = linkage(squareform(unit_distances(units), checks=False), method="complete")
    cluster = fcluster(tree, threshold, criterion="distance")
    chance = np.random.default_rng(seed)
    kept = [int(chance.choice(np.flatnonzero(cluster == one))) for one in np.unique(cluster)]
    return units.kept(np.sort(kept))
