"""Tests of paths: equal parts, headings, smoothing (golden values of Fig. 5.5), and messages for invalid text."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.errors import PersonError
from live.graph.search.path_following import (
    Targets,
    along_headings,
    follow_line,
    read_path,
    smooth_headings,
    smoothed,
)

SQUARE = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0)]
places = st.tuples(st.floats(-50, 50), st.floats(-50, 50))
angles = st.floats(-math.pi, math.pi)


def test_smoothed_turns_match_figure_5_5():
    """0 for five measures, then 80 degrees: the dancer turns by 20, 40 and 20 degrees in measures 5, 6 and 7."""
    wanted = np.radians([0, 0, 0, 0, 0, 80, 80, 80, 80])
    turned = np.degrees(np.diff(smooth_headings(wanted), prepend=0.0))
    np.testing.assert_allclose(turned, [0, 0, 0, 0, 20, 40, 20, 0, 0], atol=1e-9)


def test_smoothing_takes_shorter_way_across_180_degrees():
    wanted = np.radians([170, 170, -170, -170])
    np.testing.assert_allclose(np.degrees(smooth_headings(wanted)), [170, 175, 185, 190], atol=1e-9)


@given(st.lists(angles, min_size=1, max_size=30))
def test_smoothing_is_convolution_within_range_of_headings(headings):
    unwrapped = np.unwrap(headings)
    smooth = smooth_headings(headings)
    assert smooth.min() >= unwrapped.min() - 1e-9
    assert smooth.max() <= unwrapped.max() + 1e-9
    inner = np.convolve(unwrapped, [0.25, 0.5, 0.25], mode="valid")
    np.testing.assert_allclose(smooth[1:-1], inner if len(headings) > 2 else smooth[1:-1], atol=1e-9)


def test_square_is_divided_into_sixteen_measures():
    targets = follow_line(SQUARE, 16, facing="path")
    np.testing.assert_allclose(targets.distances, 1.0)
    np.testing.assert_allclose(targets.place[[0, 4, 8, 12, 16]], SQUARE, atol=1e-12)
    # right, toward the audience, left, away: along +x is 90 degrees, +z 0
    np.testing.assert_allclose(np.degrees(targets.heading[[1, 4, 5, 9, 13]]), [90, 90, 0, -90, -180], atol=1e-9)
    assert np.diff(targets.heading)[[4, 8, 12]] == pytest.approx([-math.pi / 2] * 3)


def test_given_headings_change_evenly_the_shorter_way():
    targets = follow_line([(0, 0), (0, 3)], 4, facing=(math.radians(170), math.radians(-150)))
    np.testing.assert_allclose(np.degrees(targets.heading), [170, 180, 190, 200, 210], atol=1e-9)
    np.testing.assert_allclose(np.degrees(np.diff(targets.heading)), 10.0, atol=1e-9)


@given(st.lists(places, min_size=1, max_size=12), st.integers(1, 40))
def test_places_are_equally_spaced_along_line(points, measures):
    """Against subtracting the segment lengths one by one."""
    targets = follow_line(points, measures)
    line = np.array(points, np.float64)
    lengths = np.hypot(*np.diff(line, axis=0).T)
    total = lengths.sum()
    for n in range(measures + 1):
        left, place = total * n / measures, line[0]
        for k, length in enumerate(lengths):
            if left <= length and length > 0:
                place = line[k] + left / length * (line[k + 1] - line[k])
                break
            left -= length
            place = line[k + 1]
        np.testing.assert_allclose(targets.place[n], place, atol=1e-6 * (1.0 + total))
    assert (targets.distances <= total / measures + 1e-9 * (1 + total)).all()


@given(st.lists(places, min_size=2, max_size=12))
def test_headings_point_along_path(points):
    place = np.array(points)
    heading = along_headings(place)
    way = np.diff(place, axis=0)
    length = np.hypot(*way.T)
    for n in np.flatnonzero(length > 1e-2):
        facing = np.array([math.sin(heading[n + 1]), math.cos(heading[n + 1])])
        np.testing.assert_allclose(facing * length[n], way[n], atol=1e-6)
    assert (np.abs(np.diff(heading)) <= math.pi + 1e-9).all()


def test_standing_dancer_keeps_last_heading():
    heading = along_headings(np.array([(0, 0), (0, 0), (1, 0), (1, 0), (1, 1)], np.float64))
    np.testing.assert_allclose(np.degrees(heading), [90, 90, 90, 90, 0])
    assert along_headings(np.zeros((4, 2))).tolist() == [0, 0, 0, 0]


def test_smoothed_targets_keep_places():
    targets = Targets(np.zeros((3, 2)), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(smoothed(targets).heading, [0.0, 0.25, 0.75])
    assert smoothed(targets).place is targets.place


def test_path_text_is_parsed():
    np.testing.assert_array_equal(read_path(" 0, 0; 4,0 ,4,-4.5"), [(0, 0), (4, 0), (4, -4.5)])


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("", "even number"),
        ("1,2", "even number"),
        ("1,2,3", "3 numbers read"),
        ("1,2,x,4", "number 3 is 'x'"),
        ("1,2,nan,4", "number 3"),
        ("1,2,3,inf", "number 4"),
        ("1,2,3,4000", "number 4 is '4000'"),
        ("1,2,,4", "number 3 is ''"),
        ("9" * 500 + ",1,2,3", "…"),
        ("1," * 300_000 + "1", "fewer points"),
    ],
)
def test_invalid_path_text_is_reported(text, fragment):
    with pytest.raises(PersonError) as error:
        read_path(text)
    message = f"{error.value} {error.value.remedy}"
    assert fragment in message
    assert len(message) < 400


def test_invalid_lines_are_refused():
    with pytest.raises(ValueError, match="at least 1"):
        follow_line(SQUARE, 0)
    with pytest.raises(ValueError, match="shape"):
        follow_line(np.zeros((0, 2)), 3)
    with pytest.raises(ValueError, match="finite"):
        follow_line([(0.0, math.nan), (1.0, 1.0)], 3)
