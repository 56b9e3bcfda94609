"""Transformations of groups: laws, neighbours, room, limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from live.agents.groups.roster import Line
from live.agents.material.neighbours import neighbours_of
from live.agents.material.room import LEAST_GAP, room_of
from live.agents.material.transform import Transform, transform_group, warp_between
from live.base.errors import PersonError
from tests.fixtures.mostly_long import mostly_long

L_SHAPE = (((-5.0, -3.5), (5.0, -3.5), (5.0, -0.5), (-1.0, -0.5), (-1.0, 3.5), (-5.0, 3.5)),)
SQUARE = (((-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)),)
RING = (
    tuple((4.5 * math.cos(k * math.pi / 12), 4.0 * math.sin(k * math.pi / 12)) for k in range(24)),
    tuple((1.2 * math.cos(k * math.pi / 6), 1.2 * math.sin(k * math.pi / 6)) for k in range(12)),
)


def group(count=30, seed=0):
    """Places (count, 2) at random, at least 0.75 m apart."""
    chance, places = np.random.default_rng(seed), np.zeros((0, 2))
    while len(places) < count:
        at = chance.uniform(-4.0, 4.0, (1, 2))
        if not len(places) or np.hypot(*(places - at).T).min() > 0.75:
            places = np.concatenate([places, at])
    return places


def done(transform, places):
    return transform_group(transform, np.asarray(places, np.float64).reshape(1, -1, 2)).points[0]


def least(places):
    return cKDTree(places).query(places, k=2)[0][:, 1].min()


def test_identity_changes_nothing():
    places = group()
    assert np.array_equal(done(Transform(), places), places)


@settings(deadline=None, max_examples=25)
@given(st.floats(1.0, 3.0), st.floats(-180.0, 180.0), st.tuples(st.floats(-5, 5), st.floats(-5, 5)), st.integers(0, 20))
def test_scaling_turning_and_moving_are_undone_by_their_inverse(scale, angle, way, seed):
    places = group(12, seed)
    there = done(Transform(scale=(scale, scale), rotation_deg=angle, centre=way), places)
    back = Transform(scale=(1 / scale, 1 / scale), rotation_deg=-angle, centre=(-way[0], -way[1]))
    turned = done(back, there)
    low, high = there.min(axis=0), there.max(axis=0)
    # each turns about the middle of what it is given, so they agree up to a move
    assert turned - turned.mean(axis=0) == pytest.approx(places - places.mean(axis=0), abs=1e-9)
    assert np.isfinite(low + high).all()


def test_turns_compose():
    places = group()
    twice = done(Transform(rotation_deg=50), done(Transform(rotation_deg=-20), places))
    once = done(Transform(rotation_deg=30), places)
    assert twice - twice.mean(axis=0) == pytest.approx(once - once.mean(axis=0), abs=1e-9)


def test_mirrored_twice_is_the_same():
    places, line = group(), Line.through((1.0, 0.0), (2.0, 3.0))
    once = done(Transform(mirror=line), places)
    assert np.abs(once - places).max() > 1.0
    assert done(Transform(mirror=line), once) == pytest.approx(places, abs=1e-9)


def test_bend_to_the_other_side_is_its_mirror_image():
    places = np.stack([np.linspace(-4, 4, 9), np.zeros(9)], axis=1)
    front, back = done(Transform(bend_deg=90), places), done(Transform(bend_deg=-90), places)
    assert front[[0, -1], 1].min() > front[4, 1] + 1.0  # positive: both sides come to the public
    assert back == pytest.approx(front * (1.0, -1.0), abs=1e-9)
    assert np.hypot(*np.diff(front, axis=0).T) == pytest.approx(np.full(8, 0.9984), abs=1e-4)  # a chord of the arc


def test_along_a_straight_line_only_moves_and_turns():
    places = group(20)
    width = np.ptp(places[:, 0])
    laid = done(Transform(along=((2.0, -width), (2.0, width))), places)
    before, after = (each[:, None] - each[None] for each in (places, laid))
    assert np.hypot(*after.T) == pytest.approx(np.hypot(*before.T), abs=1e-9)
    assert np.ptp(laid[:, 1]) == pytest.approx(width)


@mostly_long("region", [L_SHAPE, SQUARE, RING], quick=[2], ids=["L", "square", "ring"])
@mostly_long("seed", range(3), quick=[1])
def test_all_land_inside_apart_with_their_neighbours(region, seed):
    places = group(30, seed)
    there = done(Transform(into=region), places)
    assert room_of(region).contains(there, 2e-3).all()
    assert least(there) > LEAST_GAP
    assert neighbours_of(places).share_kept(there) >= 0.95


@pytest.mark.long
def test_nothing_depends_on_the_order_of_calls():
    places = group(25)
    first = done(Transform(into=L_SHAPE), places)
    done(Transform(into=RING), group(20, 5))
    assert np.array_equal(done(Transform(into=L_SHAPE), places), first)


@pytest.mark.parametrize(
    "transform", [Transform(bend_deg=70), Transform(along=((-5, 0), (-2, 1), (2, -1), (5, 0)), proportions="stretch")]
)
def test_bodies_and_neighbours_are_kept_where_a_group_is_bent(transform):
    places = group(40, 3) * (1.0, 0.7)
    plain = transform_group(replace(transform, neighbours="any"), places[None])
    found = transform_group(transform, places[None])
    assert found.kept >= max(0.95, plain.kept)
    assert found.least > min(LEAST_GAP, least(places)) - 1e-3


def test_stretch_keeps_lines_or_neighbours():
    places = group(40, 1)
    exact = transform_group(Transform(scale=(2.0, 1.0)), places[None])
    kept = transform_group(Transform(scale=(2.0, 1.0), neighbours="keep"), places[None])
    assert np.ptp(exact.points[0], axis=0) == pytest.approx(np.ptp(places, axis=0) * (2.0, 1.0))
    assert exact.kept < 0.95 <= kept.kept


def test_stretched_rows_stay_rows():
    rows = np.stack(np.meshgrid(np.arange(6), np.arange(4)), axis=-1).reshape(-1, 2) * 0.9
    wide = transform_group(Transform(scale=(1.5, 1.0), neighbours="keep"), rows[None])
    assert wide.kept == 1.0
    assert wide.points[0] - wide.points[0].mean(axis=0) == pytest.approx((rows - rows.mean(axis=0)) * (1.5, 1.0))


def test_so_small_that_bodies_would_touch_is_as_small_as_bodies_allow():
    small = done(Transform(scale=(0.2, 0.2)), group(25))
    assert LEAST_GAP < least(small) < 0.75


@pytest.mark.parametrize("places", [
    [], [[2, 1]], [[2, 1], [3, 1]], [[2, 1], [2, 1]], [[k, 0] for k in range(12)], [[0, k] for k in range(12)],
    [[k, 2 * k] for k in range(7)],
], ids=["none", "one", "two", "two at one place", "row", "column", "slanted row"])  # fmt: skip
@pytest.mark.parametrize("transform", [
    Transform(into=SQUARE), Transform(bend_deg=40), Transform(along=((-3, 0), (0, 2), (3, 0))), Transform(size=(3, 2)),
    Transform(into=RING, mirror=Line(), rotation_deg=20),
])  # fmt: skip
def test_small_and_flat_groups(places, transform):
    there = done(transform, places)
    assert there.shape == (len(places), 2)
    assert np.isfinite(there).all()
    if transform.into:
        assert room_of(transform.into).contains(there, 2e-3).all()
        assert len(places) < 2 or least(there) > LEAST_GAP


@pytest.mark.parametrize(("transform", "words"), [
    (Transform(into=(((0, 0), (2, 0), (2, 2), (0, 2)),)), r"room for 9 dancers, not for 30"),
    (Transform(into=(((0, 0), (0.4, 0), (0.4, 0.4), (0, 0.4)),)), "room for nobody"),
    (Transform(into=(((0, 0), (4, 4), (4, 0), (0, 4)),)), "crosses or touches itself"),
    (Transform(into=(((0, 0), (4, 4)),)), "three different points"),
    (Transform(along=((1, 1), (1, 1))), "line is 0.00 m long"),
    (Transform(bend_deg=300), "would fold"),
])  # fmt: skip
def test_unusable_transformations_are_refused(transform, words):
    with pytest.raises(PersonError, match=words):
        done(transform, group(30))


def test_as_many_as_the_refusal_tells_do_fit():
    region = (((0, 0), (2, 0), (2, 2), (0, 2)),)
    there = done(Transform(into=region), group(room_of(region).capacity))
    assert room_of(region).contains(there, 2e-3).all()
    assert least(there) >= LEAST_GAP - 1e-3


@pytest.mark.long
def test_two_hundred_dancers():
    places = np.random.default_rng(1).uniform(-8.0, 8.0, (200, 2))
    there = done(Transform(into=(((-9, -7), (9, -7), (9, 7), (-9, 7)),)), places)
    assert least(there) > LEAST_GAP
    assert np.abs(there).max(axis=0) == pytest.approx((8.75, 6.75), abs=0.5)
    assert neighbours_of(places).share_kept(there) > 0.9


def test_warp_leads_known_places_where_they_were_led():
    before = group(30)
    after = before * (1.5, 0.5) + (1.0, 2.0)
    warp = warp_between(before, after)
    assert warp(before) == pytest.approx(after, abs=1e-3)
    assert warp(np.array([[0.5, 0.5]])) == pytest.approx(np.array([[1.75, 2.25]]), abs=0.02)
