"""Steps of a recording: measures that are alike, and measures that are always danced one after another (T037, T041)."""

from collections import Counter
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Int32
from live.graph.vocabulary.measures import Measures

ALIKE: Final = 0.11
"""Measures nearer than this on average [m] are the same."""
LONGEST: Final = 4
"""Most measures of a step."""
BOUND_SHARE: Final = 0.75
"""Share of the occurrences of two steps that must follow each other if they are to be one."""


@dataclass(frozen=True, slots=True)
class FoundStep:
    """A step that was found: all its occurrences, the most typical one first."""

    measures: int
    """Its length."""
    starts: tuple[int, ...]
    """Index of the first measure of each occurrence."""
    spread_m: float
    """Mean distance of the others from the most typical one [m]; 0 if there is none."""


def alike_measures(distance: Float32, alike: float = ALIKE) -> Int32:
    """Return a cluster for each of M measures with `distance` (M, M) [m], numbered in order of appearance, (M,).

    Average linkage: clusters are joined while the mean distance between their measures is at most `alike`.
    """
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    if len(distance) < 2:
        return np.zeros(len(distance), np.int32)
    square = distance.astype(np.float64)
    np.fill_diagonal(square, 0.0)
    tree = linkage(squareform(square, checks=False), "average")
    label = fcluster(tree, alike, "distance")
    _, first, number = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))
    return np.asarray(order[number], np.int32)


def find_steps(
    measures: Measures, distance: Float32, *, alike: float = ALIKE, longest: int = LONGEST
) -> list[FoundStep]:
    """Return the steps of some recordings in order of their first occurrence; every measure belongs to one of them.

    Measures that are alike are one step. Two steps that follow each other twice or more, and nearly always, are one
    longer step of up to `longest` measures, so a basic of two measures is cut as a whole.
    """
    label = alike_measures(distance, alike).tolist()
    tokens = [(kind, start, 1) for start, kind in enumerate(label)]
    follows, kinds = measures.follows, max(label, default=-1) + 1
    length = dict.fromkeys(range(kinds), 1)
    while True:
        pair = _bound_pair(tokens, follows, length, longest)
        if pair is None:
            break
        length[kinds] = length[pair[0]] + length[pair[1]]
        tokens = _joined(tokens, follows, pair, kinds)
        kinds += 1
    starts: dict[int, list[int]] = {}
    for kind, start, _ in tokens:
        starts.setdefault(kind, []).append(start)
    return [_step(distance, length[kind], np.array(found)) for kind, found in starts.items()]


Token = tuple[int, int, int]
"""Kind, first measure, measures."""


def _pairs(tokens: list[Token], follows: np.ndarray) -> list[tuple[int, int]]:
    """Return the places and kinds of neighbours ... as (index, index + 1) of tokens that follow each other."""
    return [(n, n + 1) for n in range(len(tokens) - 1) if follows[tokens[n + 1][1]]]


def _bound_pair(
    tokens: list[Token], follows: np.ndarray, length: dict[int, int], longest: int
) -> tuple[int, int] | None:
    """Return the two kinds that follow each other most often, and nearly always; None if there are none."""
    number = Counter(kind for kind, _, _ in tokens)
    together = Counter((tokens[a][0], tokens[b][0]) for a, b in _pairs(tokens, follows))
    good = [
        (-count, pair)
        for pair, count in together.items()
        if count >= 2
        and pair[0] != pair[1]
        and length[pair[0]] + length[pair[1]] <= longest
        and count >= BOUND_SHARE * max(number[pair[0]], number[pair[1]])
    ]
    return min(good)[1] if good else None


def _joined(tokens: list[Token], follows: np.ndarray, pair: tuple[int, int], kind: int) -> list[Token]:
    """Return the tokens with each `pair` of kinds as one token of a new `kind`."""
    out: list[Token] = []
    for token in tokens:
        before = out[-1] if out else None
        if before is not None and (before[0], token[0]) == pair and follows[token[1]]:
            out[-1] = (kind, before[1], before[2] + token[2])
        else:
            out.append(token)
    return out


def _step(distance: Float32, length: int, starts: np.ndarray) -> FoundStep:
    """Return the step with the occurrence first that is nearest to all others, the others by their distance from it."""
    apart = np.mean([distance[np.ix_(starts + n, starts + n)] for n in range(length)], axis=0)
    typical = int(np.argmin(apart.mean(axis=1)))
    order = np.argsort(apart[typical], kind="stable")
    order = np.concatenate(([typical], order[order != typical]))
    spread = float(apart[typical][order[1:]].mean()) if len(starts) > 1 else 0.0
    return FoundStep(length, tuple(int(start) for start in starts[order]), spread)
