"""Tests of the placement kernel against the closed form of `editing/support_turns.py`, and general properties."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.editing.turn_insertion import SupportTurns, ease_progress
from live.motion.pose.turn_kernels import eased_share, place_dancers
from live.motion.pose.warp_curve_kernels import KNOTS

NODES, DANCERS = 12, 40
CHANCE = np.random.default_rng(9)


def random_turns(chance):
    edges = np.sort(chance.uniform(0, 0.8, (NODES, 6)), axis=1)
    start, stop, weight = np.ones((NODES, 8)), np.ones((NODES, 8)), np.zeros((NODES, 8))
    start[:, :3], stop[:, :3], weight[:, :3] = edges[:, ::2], edges[:, 1::2], chance.dirichlet([1, 1, 1], NODES)
    point = chance.normal(0, 1, (NODES, 8, 2))
    point_stop, softness = point + chance.normal(0, 0.1, (NODES, 8, 2)), chance.uniform(0, 0.5, (NODES, 8))
    return SupportTurns(start, stop, weight, point, point_stop, softness)


def random_warp_curves(chance):
    """A warp curve for each node, linear between two of its knots."""
    begin, end = chance.integers(0, 20, NODES), chance.integers(30, 60, NODES)
    rate = np.zeros((NODES, KNOTS))
    for n in range(NODES):
        rate[n, begin[n] : end[n]] = 1.0
    share = np.pad(np.cumsum(0.5 * (rate[:, 1:] + rate[:, :-1]), axis=1) / (KNOTS - 1), ((0, 0), (1, 0)))
    return np.ascontiguousarray(np.stack((share, rate), axis=2) / share[:, -1:, None])


def turn_rows(turns):
    flat = [turns.start[..., None], turns.stop[..., None], turns.weight[..., None], turns.point, turns.point_stop]
    return np.ascontiguousarray(np.concatenate([*flat, turns.softness[..., None]], axis=-1))


def test_placement_matches_closed_form():
    chance = np.random.default_rng(4)
    turns = random_turns(chance)
    node, fraction = chance.integers(0, NODES, DANCERS).astype(np.int32), chance.uniform(0, 1, DANCERS)
    fraction = np.round(fraction * (KNOTS - 1)) / (KNOTS - 1)
    placement, correction, aimed = chance.normal(0, 1, (3, DANCERS, 3))
    rise = random_warp_curves(chance)
    aimed[:, 2] = chance.uniform(0, 0.8, DANCERS)
    out = np.empty((DANCERS, 4))
    place_dancers(out, placement, correction, aimed, fraction, node, turn_rows(turns), rise, np.ones(DANCERS))
    own = turns.select(node)
    x, z = own.displacement(fraction, correction[:, 2]).T
    c, s = np.cos(placement[:, 2]), np.sin(placement[:, 2])
    risen = np.array(
        [np.interp(f, np.linspace(0, 1, KNOTS), rise[n, :, 0]) for n, f in zip(node, fraction, strict=True)]
    )
    passed = ((risen - aimed[:, 2]) / (1 - aimed[:, 2]))[:, None]
    share = aimed[:, :2] * (1 - passed) + passed * correction[:, :2]
    assert out[:, :2] == pytest.approx(placement[:, :2] + share + np.stack([x * c + z * s, z * c - x * s], axis=1))
    assert out[:, 2] == pytest.approx(placement[:, 2] + correction[:, 2] * own.share(fraction))
    assert np.array_equal(out[:, 2], out[:, 3])  # path and body turn as one


def test_spread_turn_rotates_body_alone():
    placement, correction = np.array([[1.0, 2.0, 0.3]]), np.array([[0.4, -0.2, 1.0]])
    out, turns = np.empty((1, 4)), turn_rows(random_turns(np.random.default_rng(1)))
    half = np.linspace(0, 1, KNOTS)
    rise = np.ascontiguousarray(np.stack((half, np.ones(KNOTS)), axis=1)[None])
    node = np.zeros(1, np.int32)
    place_dancers(out, placement, correction, np.zeros((1, 3)), np.array([0.5]), node, turns, rise, np.zeros(1))
    assert out[0] == pytest.approx([1.2, 1.9, 0.3, 0.8])


@given(st.floats(0, 1), st.floats(0, 0.5))
def test_eased_share_matches_closed_form(passed, softness):
    assert eased_share(passed, softness) == pytest.approx(float(ease_progress(passed, softness)), abs=1e-9)


@given(st.floats(-math.pi, math.pi), st.floats(0, 1))
def test_support_foot_stays_during_turn(angle, passed):
    """A turn about a foot that does not creep keeps that foot in place at every moment of the turn."""
    row = np.zeros((1, 8, 8))
    row[0, :, :2] = 1.0
    row[0, 0] = 0.2, 0.7, 1.0, 0.3, -0.4, 0.3, -0.4, 0.3
    placement, fraction = np.array([[0.5, 1.0, 0.8]]), np.array([0.2 + 0.5 * passed])
    out, node, aimed, rise = np.empty((1, 4)), np.zeros(1, np.int32), np.zeros((1, 3)), random_warp_curves(CHANCE)
    place_dancers(out, placement, np.array([[0, 0, angle]]), aimed, fraction, node, row, rise, np.ones(1))

    def foot(x, z, yaw):
        c, s = math.cos(yaw), math.sin(yaw)
        return np.array([x + 0.3 * c - 0.4 * s, z - 0.4 * c - 0.3 * s])

    assert foot(*out[0, :3]) == pytest.approx(foot(*placement[0]), abs=1e-9)
