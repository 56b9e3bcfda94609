"""Drawn paths (T103)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents.evolutions import paths
from live.base.errors import PersonError
from tests.fixtures.mostly_long import mostly_long

POINTS = st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=1, max_size=8)


@given(POINTS)
def test_resampled_polyline_keeps_ends_and_even_spacing(points):
    way = paths.resample_polyline(points, 33)
    assert way[0] == pytest.approx(np.array(points[0]), abs=1e-9)
    assert way[-1] == pytest.approx(np.array(points[-1]), abs=1e-6)
    whole = np.hypot(*np.diff(points, axis=0).T).sum()
    assert (np.hypot(*np.diff(way, axis=0).T) <= whole / 32 + 1e-6).all()


@pytest.mark.parametrize("points", [[], [[1, np.nan]], [[1, 2, 3]]])
def test_invalid_polyline_is_refused(points):
    with pytest.raises(PersonError):
        paths.resample_polyline(points)


@given(st.integers(1, 9), st.floats(0.3, 2.0), st.integers(0, 99))
def test_single_file_starts_at_positions_and_ends_in_line(count, gap, seed):
    start = np.random.default_rng(seed).uniform(-4, 4, (count, 2))
    ways = paths.single_file([[-6, 5], [-6, -5], [60, -5]], start, gap=gap)
    assert ways[:, 0] == pytest.approx(start, abs=1e-5)
    ends = np.sort(ways[:, -1, 0])[::-1]
    assert ends == pytest.approx(60 - gap * np.arange(count), abs=1e-3)
    first = np.argmin(np.hypot(*(start - [-6, 5]).T))
    assert ways[first, -1] == pytest.approx([60, -5], abs=1e-4)


def test_dancer_at_path_start_follows_path_directly():
    assert paths.single_file([[0, 0], [4, 0]], [[0, 0]], knots=5)[0, :, 0].tolist() == [0, 1, 2, 3, 4]


@mostly_long(("points", "knots"), [(2, 65), (65, 65), (66, 129), (512, 513), (4096, 1025)], quick=[0, 2])
def test_a_stroke_of_many_points_is_danced_as_it_was_drawn(points, knots):
    """A zigzag, whose corners a coarse path would cut: every point is passed within half a knot's spacing, in
    single file within one."""
    line = [[0.1 * k, 0.2 * (k % 2)] for k in range(points)]
    (way,) = paths.parallel_paths(line, [[0.0, 0.0]])
    (file,) = paths.single_file(line, [[0.0, 0.0]])
    assert len(way) == knots
    spacing = math.dist(line[0], line[1]) * (points - 1) / (knots - 1)
    for walked, share in ((way, 0.5), (file, 1.0)):
        far = np.hypot(*(np.asarray(line)[:, None] - walked[None]).transpose(2, 0, 1)).min(axis=1).max()
        assert far <= share * spacing + 1e-3
