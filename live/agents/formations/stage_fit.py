"""Check whether a formation fits on a stage, with a suggested correction (T090)."""

from dataclasses import dataclass

import numpy as np

from live.agents.formations.formation import Formation


@dataclass(frozen=True, slots=True)
class StageFit:
    """Result of `fit_stage`."""

    outside: tuple[int, ...]
    """Places (from 0) beyond an edge of the stage."""
    scale: float
    """Scale factor needed, 1 if the size fits."""
    offset: tuple[float, float]
    """Displacement of the centre needed after scaling (x, z) [m]."""
    remedy: str
    """The correction in words; empty if it fits."""

    @property
    def fits(self) -> bool:
        """Whether all places lie on the stage."""
        return not self.outside


def fit_stage(formation: Formation, width: float, depth: float, *, radius: float = 0.25) -> StageFit:
    """Check bodies of `radius` [m] on all places of a formation against a stage of `width` and `depth` [m]."""
    half = np.array([width, depth]) / 2 - radius
    if not len(formation.slots) or (np.abs(formation.slots) <= half + 1e-9).all():
        return StageFit((), 1.0, (0.0, 0.0), "")
    outside = np.flatnonzero((np.abs(formation.slots) > half + 1e-9).any(axis=1))
    low, high = formation.slots.min(axis=0), formation.slots.max(axis=0)
    extent = np.maximum(high - low, 1e-9)
    factor = float(min(1.0, (np.maximum(2.0 * half, 0.0) / extent).min()))
    middle, reach = (low + high) / 2, factor * extent / 2
    target = np.clip(middle, -(half - reach), half - reach)
    move = target - middle
    words = []
    if factor < 1.0:
        words.append(f"make it {factor:.2f} times as large ({factor * extent[0]:.1f} x {factor * extent[1]:.1f} m)")
    if np.abs(move).max() > 0.005:
        words.append(f"move its centre by {move[0]:+.2f} m in x and {move[1]:+.2f} m in z")
    return StageFit(tuple(int(each) for each in outside), factor, (float(move[0]), float(move[1])), " and ".join(words))
