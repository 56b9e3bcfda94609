"""Tests of path bends: paths shorter and turned as asked, planted feet planted, and the beginning where it was."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.clip import read_clip
from live.motion.editing.path_bend import bend_path, path_variants, source_name
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.quality.metrics import contact_slide_speeds
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import measured_distance, travel
from tests.fixtures.mostly_long import mostly_long
from tests.places import ROOT

STEPS = ROOT / "patches" / "steps"


def walk(direction="long forward"):
    path = STEPS / "walk.toml"
    return replace(step_clip(parse_sketch(path.read_text(encoding="utf-8"), path.name), direction), recorded=True)


def joints(step):
    return forward_kinematics(step.clip.root_position.astype(float), step.clip.rotation.astype(float))[0]


def heading(step, sample):
    """Heading of the line between the upper legs [rad]."""
    position = joints(step)[round(sample)]
    across = position[SKELETON.index("leftUpperLeg")] - position[SKELETON.index("rightUpperLeg")]
    return float(np.arctan2(-across[2], across[0]))


@pytest.mark.parametrize("scale", [0.25, 0.6, 1.0])
def test_path_is_scaled(scale):
    step = walk()
    bent = bend_path(step, scale=scale, turn=0.0)
    assert measured_distance(bent) == pytest.approx(scale * measured_distance(step), abs=0.06)
    assert travel(bent)[0] == pytest.approx(travel(step)[0], abs=0.03)


@pytest.mark.parametrize("degrees", [-50.0, 50.0])
def test_body_and_path_turn_evenly(degrees):
    step, turn = walk(), np.radians(degrees)
    bent = bend_path(step, scale=1.0, turn=turn)
    end = step.first + step.measures * step.samples_per_measure
    assert heading(bent, end) - heading(step, end) == pytest.approx(turn, abs=0.02)
    assert heading(bent, step.first) - heading(step, step.first) == pytest.approx(0.0, abs=0.02)
    way = travel(bent)
    assert np.arctan2(way[0], way[1]) == pytest.approx(0.5 * turn, abs=0.1)  # half way on average
    chord = np.sin(abs(turn) / 2) / (abs(turn) / 2)  # of an even arc
    assert np.hypot(*way) == pytest.approx(chord * measured_distance(step), rel=0.06)


@mostly_long(("scale", "degrees"), [(0.25, 0.0), (0.6, 50.0), (1.0, -90.0)], quick=[0, 2])
def test_standing_feet_stand(scale, degrees):
    step = walk()
    bent = bend_path(step, scale=scale, turn=np.radians(degrees))
    slide = contact_slide_speeds(joints(bent), bent.clip.contact, bent.clip.sample_rate)
    own = contact_slide_speeds(joints(step), step.clip.contact, step.clip.sample_rate)
    assert slide.mean() < own.mean() + 0.01
    np.testing.assert_array_equal(bent.clip.contact, step.clip.contact)


def test_step_begins_where_it_did():
    step = walk()
    bent = bend_path(step, scale=0.5, turn=0.7)
    now, then = (read_clip(one.clip, np.array([step.first])) for one in (bent, step))
    np.testing.assert_allclose(now[0][0, ::2], then[0][0, ::2], atol=0.02)
    assert (now[1][0, 0] * then[1][0, 0]).sum() ** 2 == pytest.approx(1.0, abs=1e-4)


@pytest.mark.long
def test_variants_are_named_after_their_source_and_mirrored_alike():
    step = walk()
    variants = path_variants(step)
    assert len(variants) == 5  # 1.1 m a measure: half as far, and turned to both sides
    assert {source_name(one.clip.name) for one in variants} == {step.clip.name}
    assert len({one.clip.name for one in variants}) == len(variants)
    mirrored = path_variants(mirror_step(step))
    assert {source_name(one.clip.name) for one in mirrored} == {mirror_step(step).clip.name}
    ways = sorted(tuple(np.round(travel(one), 2)) for one in variants)
    other = sorted(tuple(np.round(travel(one) * (-1, 1), 2)) for one in mirrored)
    np.testing.assert_allclose(ways, other, atol=0.05)


def test_steps_in_place_have_no_variants():
    assert not path_variants(walk("in place"))
    assert source_name("walk, file from measure 1") == "walk, file from measure 1"
