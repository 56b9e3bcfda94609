"""Tests of the fragment search: the example of the paper's figure 7 (P012), and exhaustive search on small inputs."""

import itertools

import numpy as np
import pytest

from live.motion.texture.fragment_search import best_paths, weighted_paths

FIGURE_7 = ((4, 1, 3), (5, 7, 2), (9, 4, 6), (2, 8, 5))


def _follows(first: int, second: int) -> bool:
    return second == first + 1


def _fragments(places: tuple[int, ...], candidates: tuple[tuple[int, ...], ...]) -> list[int]:
    return [row[place] for row, place in zip(candidates, places, strict=True)]


def test_best_paths_match_figure_7() -> None:
    ranks = [[0.0, 1.0, 2.0]] * 4
    found = best_paths(FIGURE_7, ranks, _follows, 3)
    assert [_fragments(path.ranks, FIGURE_7) for path in found] == [[4, 5, 6, 2], [4, 5, 4, 5], [1, 2, 4, 5]]
    assert [path.consecutive_joins for path in found] == [2, 2, 2]
    more = best_paths(FIGURE_7, ranks, _follows, 4)
    assert more[:3] == found
    assert more[3].consecutive_joins == 1  # no fourth path has two


def _enumerate_paths(
    candidates: list[list[int]], distances: list[list[float]]
) -> list[tuple[int, float, tuple[int, ...]]]:
    """All paths whose candidates are closest or beside a free join: (cost, distance, places), sorted."""
    ways = []
    for places in itertools.product(*(range(len(row)) for row in candidates)):
        taken = [row[place] for row, place in zip(candidates, places, strict=True)]
        free = [_follows(a, b) for a, b in itertools.pairwise(taken)]
        beside = [any(free[max(0, n - 1) : n + 1]) for n in range(len(taken))]
        if all(place == 0 or linked for place, linked in zip(places, beside, strict=True)):
            far = sum(row[place] for row, place in zip(distances, places, strict=True))
            ways.append((len(free) - sum(free), far, places))
    return sorted(ways)


@pytest.mark.parametrize("seed", range(30))
def test_best_paths_equal_exhaustive_search(seed: int) -> None:
    chance = np.random.default_rng(seed)
    count, keep, most = int(chance.integers(1, 6)), int(chance.integers(1, 5)), int(chance.integers(1, 9))
    candidates = [chance.permutation(7)[:keep].tolist() for _ in range(count)]
    distances = [sorted(chance.integers(0, 50, keep).astype(float).tolist()) for _ in range(count)]
    found = best_paths(candidates, distances, _follows, most)
    tried = _enumerate_paths(candidates, distances)[:most]
    assert [(count - 1 - path.consecutive_joins, path.distance) for path in found] == [way[:2] for way in tried]
    assert len({path.ranks for path in found}) == len(found)


@pytest.mark.parametrize("seed", range(10))
def test_weighted_paths_equal_exhaustive_search(seed: int) -> None:
    chance = np.random.default_rng(100 + seed)
    count, keep, most, join = int(chance.integers(1, 6)), int(chance.integers(1, 5)), int(chance.integers(1, 6)), 7.25
    candidates = [chance.permutation(7)[:keep].tolist() for _ in range(count)]
    distances = [sorted(chance.uniform(0, 20, keep).tolist()) for _ in range(count)]
    sums = []
    for places in itertools.product(*(range(len(row)) for row in candidates)):
        taken = _fragments(places, tuple(map(tuple, candidates)))
        far = sum(row[place] for row, place in zip(distances, places, strict=True))
        sums.append((far + join * sum(not _follows(a, b) for a, b in itertools.pairwise(taken)), places))
    found = weighted_paths(candidates, distances, _follows, most, join)
    assert [path.ranks for path in found] == [places for _, places in sorted(sums)[:most]]
    assert [path.distance + join * (count - 1 - path.consecutive_joins) for path in found] == pytest.approx(
        [far for far, _ in sorted(sums)[:most]]
    )
