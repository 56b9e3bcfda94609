"""Drawn lines: simplified to the kernels' size, and as flow fields along the line (T082: the tangent of a field)."""

from typing import Final

import numpy as np
from shapely import LineString, simplify

from live.agents.elements.element import Points
from live.base.arrays import Float32, Float64
from live.base.element_kinds import OUTLINE_VERTICES

GRID_ROWS: Final = 24
GRID_COLUMNS: Final = 32
FLOW_REACH: Final = 1.0
"""Distance [m] within which the flow follows the line; farther away it leads back to the line."""


def simplified_vertices(points: Points, most: int) -> Float32:
    """Return the drawn points, shape (V, 2), or at most `most` that approximate them (Douglas & Peucker 1973)."""
    corners: Float64 = np.array(points, np.float64)
    tolerance = 0.002
    while len(corners) > most:
        corners = np.array(simplify(LineString(points), tolerance, preserve_topology=False).coords)
        tolerance *= 1.5
    return corners.astype(np.float32)


def flow_grid_along(points: Points, half_width: float, half_depth: float) -> Float32:
    """Return the flow along a drawn line at the nodes of a grid over the stage, shape (24, 32, 2), lengths at most 1.

    On the line it is the tangent; with distance it increasingly leads towards the line. Where the line crosses itself
    the tangents of near segments are blended by distance.
    """
    corners = simplified_vertices(points, OUTLINE_VERTICES).astype(np.float64)
    start, way = corners[:-1], np.diff(corners, axis=0)
    length = np.hypot(*way.T)
    start, way, length = start[length > 1e-6], way[length > 1e-6], length[length > 1e-6]
    x, z = np.meshgrid(
        np.linspace(-half_width, half_width, GRID_COLUMNS), np.linspace(-half_depth, half_depth, GRID_ROWS)
    )
    node = np.stack([x, z], axis=-1)[:, :, np.newaxis]
    t = np.clip(((node - start) * way).sum(-1) / length**2, 0.0, 1.0)
    to_line = start + t[..., np.newaxis] * way - node
    distance = np.hypot(to_line[..., 0], to_line[..., 1])
    nearest = distance.min(-1)
    weight = np.exp(-((distance - nearest[..., np.newaxis]) / 0.3))
    tangent = (weight[..., np.newaxis] * (way / length[:, np.newaxis])).sum(2)
    tangent /= np.maximum(np.hypot(tangent[..., 0], tangent[..., 1]), 1e-9)[..., np.newaxis]
    index = distance.argmin(-1)[..., np.newaxis, np.newaxis]
    back = np.take_along_axis(to_line, index, axis=2)[:, :, 0] / FLOW_REACH
    flow = tangent + back
    flow /= np.maximum(np.hypot(flow[..., 0], flow[..., 1]), 1.0)[..., np.newaxis]
    return np.ascontiguousarray(flow, np.float32)
