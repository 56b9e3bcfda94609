"""Staggered rows that fill a rectangle: the formation "grid" of the first show, place for place."""

import math

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]


def staggered_rows(count: int, size: tuple[float, float]) -> Float64:
    """`count` places around (0, 0), front row first, in a rectangle `size` (width, depth) [m], shape (count, 2)."""
    if count == 0:
        return np.zeros((0, 2))
    rows = min(max(1, round(math.sqrt(count * size[1] / max(size[0], 1e-6)))), count)
    per_row = [count // rows + (1 if row < count % rows else 0) for row in range(rows)]
    places: list[tuple[float, float]] = []
    widest = max(per_row)
    gap = size[0] / widest
    for row, members in enumerate(per_row):
        z = 0.0 if rows == 1 else (0.5 - row / (rows - 1)) * size[1]
        shift = 0.0 if members != widest or row % 2 == 0 else 0.5 * gap
        for member in range(members):
            places.append(((member - (members - 1) / 2) * gap + shift * 0.5 * (1 if row % 4 == 1 else -1), z))
    return np.array(places)
