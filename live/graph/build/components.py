"""Strongly connected components of a graph (T037)."""

import numpy as np

from live.base.arrays import Bool, Int32


def strong_components(count: int, source: Int32, target: Int32) -> Int32:
    """Return the strongly connected component of each of `count` nodes (N,), for edges sorted by source (T037)."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    start = np.searchsorted(source, np.arange(count + 1)).astype(np.int32)
    table = csr_array((np.ones(len(source)), target.astype(np.int32), start), shape=(count, count))
    return np.asarray(connected_components(table, directed=True, connection="strong")[1], np.int32)


def largest_component(count: int, source: Int32, target: Int32) -> Bool:
    """Return the nodes of the largest strongly connected component, shape (N,): dead ends are pruned (T037)."""
    label = strong_components(count, source, target)
    size = np.bincount(label)
    lives = np.zeros(len(size), np.bool_)  # a single node without a self-loop is a component, but allows no dance
    lives[label[source[label[source] == label[target]]]] = True
    return np.asarray(label == np.argmax(size + lives * len(label)), np.bool_)
