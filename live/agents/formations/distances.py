"""Distances between the places of a formation, by a sweep along its longer side."""

import math

import numpy as np

from live.base.arrays import Float64, Int64


def closest_distance(places: Float64) -> float:
    """Return the smallest distance [m] between two of `places` (S, 2); infinite for fewer than two."""
    if len(places) < 2:
        return math.inf
    ordered, side, _ = _sorted_along(places)
    closest = math.inf
    for apart in range(1, len(places)):  # each with the next, then with the one after it …
        between = ordered[apart:] - ordered[:-apart]
        if between[:, side].min() >= closest:  # one side alone is as long
            break
        closest = min(closest, math.sqrt((between * between).sum(axis=1).min()))
    return closest


def close_pairs(places: Float64, distance: float) -> Int64:
    """Return the pairs of `places` (S, 2) that are at most `distance` [m] apart, as indices (P, 2), the lower first."""
    ordered, side, order = _sorted_along(places)
    found = [np.zeros((0, 2), np.int64)]
    for apart in range(1, len(places)):
        between = ordered[apart:] - ordered[:-apart]
        if between[:, side].min() > distance:
            break
        near = np.flatnonzero((between * between).sum(axis=1) <= distance * distance)
        found.append(np.stack([order[near], order[near + apart]], axis=1))
    return np.sort(np.concatenate(found), axis=1)


def _sorted_along(places: Float64) -> tuple[Float64, int, Int64]:
    """Return the places in order along their longer side, that side (0: x, 1: z), and the order."""
    side = int(np.argmax(np.ptp(places, axis=0))) if len(places) else 0
    order = np.argsort(places[:, side], kind="stable")
    return places[order], side, order
