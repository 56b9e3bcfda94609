"""Where dancers are on their paths, by numpy."""

import numpy as np

from live.agents.separation.path_separation import MOMENTS, Paths

MOMENT = np.linspace(0.0, 1.0, MOMENTS)


def places_at(paths: Paths, place: float, goal: np.ndarray, aimed: np.ndarray) -> np.ndarray:
    """Places (A, 2) [m] after the share `place` of the measure; `goal` (A, 2), `aimed` (A, 3) as in `Danced`."""

    def at(values):
        return np.array([np.interp(place, MOMENT, one) for one in values])

    weight = np.maximum(at(paths.share) - aimed[:, 2], 0.0) / np.maximum(1.0 - aimed[:, 2], 1e-9)
    path = np.stack([at(paths.path[:, :, 0]), at(paths.path[:, :, 1])], axis=1)
    return path + aimed[:, :2] + weight[:, None] * (goal - aimed[:, :2])
