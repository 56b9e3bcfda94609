"""Hands and feet: five fingers that bend at their joints, fists that close, toes of their own."""

from itertools import pairwise

import numpy as np
import pytest

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.body.expression import CURL, FACE_SIZE, SPREAD
from live.render.body.body_mesh import COARSE, DISTANT, FINE, LIGHT, build_body
from live.render.body.drawn_joints import DETAIL_JOINTS, DRAWN_NAMES, EXPRESSION_SIZE
from live.render.body.fingers import FINGERS, PHALANGES
from tests.render.body.detail_motion import drawn_motions
from tests.render.body.test_skinning import litres, skinned_by
from tests.render.poses import pose

FOUR = FINGERS[1:]


def posed(level, curl, spread=0.0, name=DEFAULT_BODY):
    """Mesh, vertices with the left hand so, by dual quaternions, and motions of the joints."""
    expression = np.zeros(EXPRESSION_SIZE)
    expression[FACE_SIZE + CURL.start : FACE_SIZE + CURL.stop] = curl
    expression[FACE_SIZE + SPREAD] = spread
    mesh = build_body(level, name)
    turns, moves = drawn_motions(*pose({}), expression)
    return mesh, skinned_by(mesh, turns, moves), turns, moves


def finger_of(mesh, finger):
    """Vertices of the left hand that a finger's last two joints move most."""
    numbers = [DRAWN_NAMES.index(f"left{finger.name}{part}") for part in PHALANGES[1:]]
    return np.flatnonzero((np.isin(mesh.joint, numbers) * mesh.weight).sum(axis=1) > 0.5)


def bone(finger, turns, moves, phalanx):
    """Ends of a bone as it is moved."""
    joint = DRAWN_NAMES.index(f"left{finger.name}{PHALANGES[phalanx]}")
    return [turns[joint] @ np.array(finger.places[end]) + moves[joint] for end in (phalanx, phalanx + 1)]


@pytest.mark.parametrize("level", [LIGHT, FINE])
@pytest.mark.parametrize("name", BODIES)
def test_every_body_has_five_fingers_that_stand_apart(level, name):
    mesh = build_body(level, name)
    for finger in FINGERS:
        mine = mesh.position[finger_of(mesh, finger)]
        assert len(mine) >= 6
        end = np.array(finger.places[3])
        assert np.linalg.norm(mine - end, axis=1).min() < 0.012
        for other in FINGERS:
            if other is not finger:
                apart = np.linalg.norm(mine[:, None] - mesh.position[finger_of(mesh, other)][None], axis=2)
                assert apart.min() > 0.001


@pytest.mark.parametrize("level", [COARSE, DISTANT])
def test_small_bodies_have_mittens(level):
    mesh = build_body(level)
    assert (mesh.position[:, 0] > 0.78).sum() < 20


@pytest.mark.parametrize("level", [LIGHT, FINE])
def test_fist_is_closed_and_keeps_its_volume(level):
    mesh, rest, *_ = posed(level, 0.0)
    _, fist, turns, moves = posed(level, 1.0, -0.6)
    for finger in FOUR:
        knuckle, tip = np.array(finger.places[0]), bone(finger, turns, moves, 2)[1]
        assert np.linalg.norm(tip - knuckle) < 0.4 * np.linalg.norm(np.subtract(finger.places[3], finger.places[0]))
        assert tip[1] < knuckle[1]
    reach = fist[mesh.position[:, 0] > 0.7, 0].max()
    assert reach < 0.80  # 8 cm shorter than the flat hand
    hand = litres(mesh, rest) - litres(mesh, fist)
    assert abs(hand) < 0.04  # of a hand's 0.35 l; overlapping skin counts twice


def test_thumb_lies_across_the_fingers_of_a_fist_without_entering_them():
    _, _, turns, moves = posed(LIGHT, 1.0, -0.6)
    thumb = [np.array(bone(FINGERS[0], turns, moves, phalanx)) for phalanx in (1, 2)]
    for finger in FOUR[:2]:
        for phalanx in range(3):
            for own in thumb:
                gap = segment_distance(*own, *bone(finger, turns, moves, phalanx))
                assert gap > 0.7 * (FINGERS[0].thick + finger.thick), (finger.name, phalanx)
    assert thumb[1][1][2] < FOUR[1].places[0][2] + 0.01  # its tip is in front of the middle finger


def segment_distance(a, b, c, d):
    s = np.linspace(0.0, 1.0, 41)[:, None]
    return float(np.linalg.norm((a + (b - a) * s)[:, None] - (c + (d - c) * s)[None], axis=2).min())


def test_pressed_fingers_touch_and_spread_ones_part():
    gaps = {}
    for spread in (-1.0, 0.0, 1.0):
        _, _, turns, moves = posed(LIGHT, 0.0, spread)
        tips = [bone(finger, turns, moves, 2)[1] for finger in FOUR]
        gaps[spread] = [float(np.linalg.norm(a - b)) for a, b in pairwise(tips)]
        for one, two in pairwise(FOUR):
            gap = segment_distance(*bone(one, turns, moves, 1), *bone(two, turns, moves, 1))
            assert gap > 0.9 * (one.wide + two.wide)  # never one in the other
    assert all(a < b < c for a, b, c in zip(gaps[-1.0], gaps[0.0], gaps[1.0], strict=True))
    assert max(gaps[-1.0][:2]) < 0.023


def test_joints_bend_where_the_mesh_is_bound_to_both():
    """Around each joint of a finger the weights of both its bones meet within half a centimetre of the joint."""
    mesh = build_body(FINE)
    for finger in FINGERS:
        for phalanx in (1, 2):
            near, far = (DRAWN_NAMES.index(f"left{finger.name}{PHALANGES[p]}") for p in (phalanx - 1, phalanx))
            shares = [(np.where(mesh.joint == joint, mesh.weight, 0.0)).sum(axis=1) for joint in (near, far)]
            both = np.flatnonzero((shares[0] > 0.2) & (shares[1] > 0.2))
            along = (mesh.position[both] - np.array(finger.places[phalanx])) @ finger.direction(phalanx)
            assert len(both) >= 4
            assert np.abs(along).max() < 0.008, finger.name


def test_bones_of_detail_joints_are_those_of_the_fingers():
    pivots = {joint.name: joint.pivot for joint in DETAIL_JOINTS}
    for finger in FINGERS:
        for phalanx, name in enumerate(PHALANGES):
            assert pivots[f"left{finger.name}{name}"] == finger.places[phalanx]


def test_toes_are_closed_and_move_with_the_toes():
    mesh = build_body(FINE)
    toes = (mesh.position[:, 2] > 0.165) & (mesh.position[:, 0] > 0.0)
    bond = DRAWN_NAMES.index("leftToes")
    assert toes.sum() > 60
    assert np.where(mesh.joint == bond, mesh.weight, 0.0).sum(axis=1)[toes].min() > 0.95
    tips = [np.abs(mesh.position[toes, 0] - x).min() for x in (0.064, 0.083, 0.098, 0.110, 0.119)]
    assert max(tips) < 0.005
