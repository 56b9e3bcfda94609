"""Giving way at goals: who is there, and stands in the way of those who are not, holds on to her place no longer."""

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Bools = npt.NDArray[np.bool_]


def who_gives_way(position: npt.NDArray[np.floating], arrived: Bools, near: float) -> Bools:
    """Those of the `arrived` (A,) who stand in one throng with somebody who has not arrived, shape (A,).

    A throng: everybody from whom one comes to everybody else by steps of at most `near` [m] from one to the next;
    so those behind make room, too, for those in front, who could not else.
    """
    count = len(position)
    if count < 2 or arrived.all() or not arrived.any():
        return np.zeros(count, np.bool_)
    pairs = cKDTree(position).query_pairs(near, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.bool_), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, throng = connected_components(links, directed=False)
    pressed = np.zeros(count, np.bool_)
    pressed[throng[~arrived]] = True
    there: Bools = arrived & pressed[throng]
    return there
