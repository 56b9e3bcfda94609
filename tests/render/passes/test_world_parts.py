"""Parts of the worlds without a picture: noise that tiles, rings of steps, strokes between joints."""

import numpy as np
import pytest

from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.worlds.constellation_pass import STARS, joint_weights, star_rows
from live.render.worlds.ripple_pass import CAPACITY, LASTING, StepRings
from live.render.worlds.stroke_kernels import STROKE_NUMBERS, fill_strokes
from live.render.worlds.world_textures import gobo_texels, noise_texels
from tests.render.poses import ARMS_DOWN, LUNGE, REACH, stage_view

TIPS = np.array([SKELETON.index(name) for name in ("head", "leftHand", "rightHand")], np.int32)
PARENTS = np.array(SKELETON.parents, np.int32)


@pytest.mark.parametrize("texels", [noise_texels, gobo_texels])
def test_textures_tile_without_a_seam_and_use_their_range(texels):
    image = texels().astype(float)
    for layer in range(4):
        one = image[..., layer]
        for axis in (0, 1):
            inside = np.abs(np.diff(one, axis=axis)).mean(axis=1 - axis)
            seam = np.abs(np.take(one, 0, axis) - np.take(one, -1, axis)).mean()
            assert seam <= inside.max() + 1e-9
        assert one.max() - one.min() > 150.0


def stepping(height, beat, x=1.0):
    """A dancer at x whose toes are so high [m]."""
    view = stage_view([(ARMS_DOWN, (x, 0.5), 0.0, 0)])
    toes = [SKELETON.index("leftToes"), SKELETON.index("rightToes")]
    view.joint_position[:, toes[1], 1] = 0.02
    view.joint_position[:, toes[0], 1] = height
    view.beat = beat
    return view, view.joint_position[0, toes[0]][[0, 2]]


def test_foot_that_comes_down_begins_one_ring_at_its_place():
    rings = StepRings()
    for height, beat in ((0.2, 0.1), (0.1, 0.2), (0.06, 0.25)):
        rings.update(stepping(height, beat)[0])
    assert len(rings.seen(0.25)) == 0
    view, place = stepping(0.03, 0.3)
    rings.update(view)
    for beat in (0.4, 0.6, 0.9):
        rings.update(stepping(0.05, beat)[0])  # not lifted: it trembles
    seen = rings.seen(0.9)
    assert len(seen) == 1
    np.testing.assert_allclose(seen[0], [*place, 0.6, 1.0], atol=1e-6)
    assert len(rings.seen(0.3 + LASTING + 0.01)) == 0


def test_those_who_stand_make_a_small_ring_on_each_beat():
    rings = StepRings()
    for beat in (0.5, 0.9, 1.05, 1.5):
        rings.update(stepping(0.02, beat)[0])
    seen = rings.seen(1.5)
    assert len(seen) == 1
    assert seen[0, 2] == pytest.approx(0.5)  # it began on the beat
    assert seen[0, 3] < 0.5


@pytest.mark.long
def test_rings_are_forgotten_when_time_goes_back_and_when_too_many():
    rings = StepRings()
    rings.update(stepping(0.2, 5.0)[0])
    rings.update(stepping(0.02, 5.1)[0])
    assert len(rings.seen(5.1)) == 1
    rings.update(stepping(0.2, 1.0)[0])
    assert len(rings.seen(5.1)) == 0
    crowd = stage_view([(ARMS_DOWN, (0.1 * i, 0.0), 0.0, 0) for i in range(CAPACITY)])
    crowd.joint_position[..., 1] += 0.5
    crowd.beat = 2.0
    rings.update(crowd)
    crowd.joint_position[..., 1] -= 0.5
    crowd.beat = 2.1
    rings.update(crowd)
    assert len(rings.seen(2.1)) == CAPACITY


def expected_strokes(view, reach, bright):
    """The strokes by the text of the kernel, in plain Python."""
    place, weight, found = view.joint_position.astype(float), joint_weights(), []
    for a in np.flatnonzero(view.present):
        for j in range(JOINT_COUNT):
            found.append((*place[a, j], *place[a, j], a, bright * weight[j], 0.010 + 0.014 * weight[j]))
            if PARENTS[j] >= 0:
                found.append((*place[a, j], *place[a, PARENTS[j]], a, bright * 0.34, 0.0045))
    for a in np.flatnonzero(view.present):
        for b in np.flatnonzero(view.present):
            for tip in TIPS if a < b else ():
                gap = float(np.linalg.norm(place[a, tip] - place[b, tip]))
                if gap < reach:
                    near = 1.0 - gap / reach
                    found.append((*place[a, tip], *place[b, tip], a, bright * 0.30 * near**2 * (3 - 2 * near), 0.0032))
    return np.array(found)


def filled(view, reach=1.5, bright=0.8, room=4000):
    out = np.zeros((room, STROKE_NUMBERS), np.float32)
    count = fill_strokes(
        view.joint_position, view.present, PARENTS, TIPS, joint_weights(), float(reach), float(bright), out
    )
    return out[:count]


def test_strokes_join_joints_to_parents_and_near_tips():
    view = stage_view([(LUNGE, (0.0, 0.0), 0.0, 0), (REACH, (1.1, 0.3), 40.0, 1), (ARMS_DOWN, (0.4, -0.9), 90.0, 0)])
    view.present[2] = False
    strokes, expected = filled(view), expected_strokes(view, 1.5, 0.8)
    assert len(strokes) == len(expected) > 2 * (2 * JOINT_COUNT - 1)
    np.testing.assert_allclose(strokes, expected, atol=1e-5)


def test_line_to_a_neighbour_appears_from_nothing_and_room_is_kept():
    own = 2 * (2 * JOINT_COUNT - 1)
    brightness = []
    for gap in np.linspace(1.6, 0.7, 40):
        strokes = filled(stage_view([(ARMS_DOWN, (0.0, 0.0), 0.0, 0), (ARMS_DOWN, (float(gap), 0.0), 0.0, 0)]))
        brightness.append(strokes[own:, 7].sum())
    assert brightness[0] == 0.0
    assert brightness[-1] > 0.1
    assert np.abs(np.diff(brightness)).max() < 0.05
    crowd = stage_view([(ARMS_DOWN, (0.5 * i, 0.0), 0.0, 0) for i in range(12)])
    assert len(filled(crowd, room=100)) == 100


def test_stars_are_seeded_and_leave_the_stage_free():
    stars = star_rows()
    assert stars.shape == (STARS, 6)
    np.testing.assert_array_equal(stars, star_rows())
    assert np.hypot(stars[:, 0], stars[:, 2] + 4.0).min() > 8.0
    assert stars[:, 1].min() > 0.0
