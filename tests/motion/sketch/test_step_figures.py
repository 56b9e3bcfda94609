"""Tests of step measurements on clips with known values: travel, direction, contacts per beat, foot slide."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.mirror import mirror_step
from live.motion.sketch.sketch_clips import step_clips
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import DIRECTIONS, beat_contacts, foot_slide, measured_direction, measured_distance, travel
from tests.fixtures.made_steps import made_clip

WALK = """
name = "walk"
travels = true
short = 0.3
long = 0.8
[right_foot]
"1" = "home, lift 5"
[left_foot]
"3" = "home, lift 5"
"""


def test_travel_is_measured_between_measure_lines():
    step = made_clip("glide", way=(0.3, -0.4), measures=2)
    assert travel(step) == pytest.approx((0.6, -0.8), abs=1e-6)
    assert measured_distance(step) == pytest.approx(1.0, abs=1e-6)
    between = replace(step, first=step.first - 0.25)
    assert travel(between) == pytest.approx((0.6, -0.8), abs=1e-6)


@pytest.mark.parametrize(
    ("way", "direction"),
    [
        ((0.0, 0.1), "in place"),
        ((0.0, 0.3), "short forward"),
        ((0.1, -0.3), "short back"),
        ((0.3, 0.1), "short left"),
        ((-0.3, 0.1), "short right"),
        ((0.0, 0.8), "long forward"),
        ((-0.8, -0.1), "long right"),
    ],
)
def test_direction_is_relative_to_dancer(way, direction):
    assert measured_direction(made_clip("glide", way=way)) == direction
    assert measured_direction(made_clip("glide", way=way, measures=3)) == direction


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_mirrored_step_has_mirrored_direction(x, z):
    step = made_clip("glide", way=(x, z))
    image = mirror_step(replace(step, direction=measured_direction(step)))
    if abs(abs(x) - abs(z)) > 1e-6:
        assert measured_direction(image) == image.direction
    assert measured_distance(image) == pytest.approx(measured_distance(step), abs=1e-6)


@pytest.mark.long
def test_sketched_directions_are_measured_back():
    for step in step_clips(parse_sketch(WALK, "walk.toml")):
        assert measured_direction(step) == step.direction
        wanted = {"in": 0.0, "short": 0.3, "long": 0.8}[step.direction.split()[0]]
        assert step.distance_m == pytest.approx(wanted, abs=0.02)
    assert {step.direction for step in step_clips(parse_sketch(WALK, "walk.toml"))} == set(DIRECTIONS)


def test_contacts_are_fractions_of_beats():
    step = made_clip("sway")
    contact = np.ones_like(step.clip.contact)
    first, per_beat = int(step.first), int(step.samples_per_measure) // 4
    contact[first + per_beat : first + 2 * per_beat, 0] = False
    contact[first + 2 * per_beat : first + 2 * per_beat + per_beat // 4, 1] = False
    step = replace(step, clip=replace(step.clip, contact=contact))
    expected = [[1, 1], [0, 1], [1, 0.75], [1, 1]]
    assert beat_contacts(step) == pytest.approx(np.array(expected))


def test_foot_slide_of_gliding_step_matches_body_speed():
    step = made_clip("glide", way=(0.0, 0.8))
    seconds = step.samples_per_measure / step.clip.sample_rate
    assert foot_slide(step) == pytest.approx(0.8 / seconds, rel=1e-3)
    assert foot_slide(made_clip("sway")) == pytest.approx(0.0, abs=1e-6)
    flying = replace(step, clip=replace(step.clip, contact=np.zeros_like(step.clip.contact)))
    assert foot_slide(flying) is None
    turning = made_clip("spin", turn=math.pi)
    assert foot_slide(turning) > 0.1
