"""Formations to begin with: places on the stage for a number of dancers (T090, T091: grid, line, circle)."""

import math

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]


def formation_grid(count: int, *, centre: tuple[float, float], size: tuple[float, float]) -> Float64:
    """Staggered rows that fill a rectangle `size` (width, depth) [m] around `centre`, shape (count, 2)."""
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
    return np.asarray(np.array(places) + np.array(centre), np.float64)


def formation_line(count: int, *, centre: tuple[float, float], size: tuple[float, float]) -> Float64:
    """One line across the width of `size` [m], shape (count, 2)."""
    across = np.zeros(1) if count == 1 else np.linspace(-0.5, 0.5, count)
    places = np.stack([across[:count] * size[0], np.zeros(count)], axis=1)
    return np.asarray(places + np.array(centre), np.float64)


def formation_circle(count: int, *, centre: tuple[float, float], size: tuple[float, float]) -> Float64:
    """An ellipse that touches the sides of `size` [m], the first dancer nearest to the public, shape (count, 2)."""
    angle = 2.0 * math.pi * np.arange(count) / max(count, 1)
    places = np.stack([np.sin(angle) * size[0] / 2, np.cos(angle) * size[1] / 2], axis=1)
    return np.asarray(places + np.array(centre), np.float64)


FORMATIONS = {"grid": formation_grid, "line": formation_line, "circle": formation_circle}
"""The shapes a patch may name."""
