"""Tests of fragment matching against a loop, with the 4 × rule, and of cuts at turning points."""

import numpy as np
import pytest

from live.motion.texture.fragment_search import match_fragments, resample_fragments
from live.motion.texture.fragments import Fragments, find_cuts, make_fragments

CHANCE = np.random.default_rng(4)


def test_cuts_are_at_turning_points() -> None:
    t = np.arange(101) / 100.0
    cuts = find_cuts(np.cos(2.0 * np.pi * 2.0 * t))
    assert cuts.tolist() == [0, 25, 50, 75, 100]
    rests = np.repeat([0.0, 1.0, 2.0, 1.0, 0.0], 8)
    assert find_cuts(rests).tolist() == [0, 23, 39]
    assert find_cuts(np.zeros(20)).tolist() == [0, 19]


def test_adjacent_fragments_share_cut_within_one_clip() -> None:
    parts = make_fragments([np.array([0, 4, 9]), np.array([0, 6])], [0, 10])
    assert parts.begin.tolist() == [0, 4, 10]
    assert parts.end.tolist() == [4, 9, 16]
    assert parts.follows(0, 1)
    assert not parts.follows(1, 2)


def _distances_by_loop(sketch: np.ndarray, own: Fragments, data: np.ndarray, theirs: Fragments) -> list[list[float]]:
    far = []
    for a, b in zip(own.begin, own.end, strict=True):
        row = []
        for c, d in zip(theirs.begin, theirs.end, strict=True):
            at = np.linspace(c, d, b - a + 1)
            there = np.stack([np.interp(at, np.arange(len(data)), data[:, n]) for n in range(data.shape[1])], -1)
            row.append(float(((sketch[a : b + 1] - there) ** 2).mean()) if d - c <= 4 * (b - a) else np.inf)
        far.append(row)
    return far


def test_closest_fragments_are_sorted_and_too_long_excluded() -> None:
    sketch, data = CHANCE.normal(size=(40, 6)), CHANCE.normal(size=(200, 6))
    own = make_fragments([np.array([0, 5, 17, 22, 39])], [0])
    theirs = make_fragments([np.array([0, 7, 12, 40, 44, 52, 60]), np.array([0, 60, 71, 80])], [0, 100])
    found = match_fragments(sketch, own, data, theirs, 4)
    for row, far in enumerate(_distances_by_loop(sketch, own, data, theirs)):
        best = np.argsort(far, kind="stable")[:4]
        assert found.candidates[row].tolist() == best.tolist()
        assert np.allclose(found.distances[row], np.array(far)[best], atol=1e-9)
    with pytest.raises(ValueError, match="last longer than 4 times"):
        match_fragments(sketch, own, data, make_fragments([np.array([0, 199])], [0]), 4)


def test_scale_is_optimal() -> None:
    data = CHANCE.normal(size=(30, 4))
    whole = make_fragments([np.array([0, 29])], [0])
    found = match_fragments(0.7 * data, whole, data, whole, 1, scale=True)
    assert abs(found.scales[0][0] - 0.7) < 1e-12


def test_linear_resampling_keeps_ends() -> None:
    data = CHANCE.normal(size=(20, 2))
    there = resample_fragments(data, np.array([3]), np.array([11]), 5)
    assert np.array_equal(there[0], data[[3, 5, 7, 9, 11]])
