"""Tests of mirroring (T042): properties of the reflection."""

import numpy as np
import pytest

from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_clip, mirror_step
from live.motion.skeleton import MIRROR
from live.motion.sketch.sketch_clips import step_clips
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import DIRECTIONS, StepClip

SKETCH = """
name = "one-sided"
travels = true
[left_foot]
"1" = "out 8, lift 4"
[right_foot]
"2&" = "forward 10, lift 4"
"4" = "home"
[chest]
"1" = "turn left 20, tilt right 5"
[right_hand]
"2" = "out 30, up 10, forward 12"
"""


@pytest.fixture(scope="module")
def steps() -> list[StepClip]:
    return step_clips(parse_sketch(SKETCH, "one-sided.toml"))


def test_mirroring_twice_returns_same_step(steps: list[StepClip]) -> None:
    for step in steps:
        again = mirror_step(mirror_step(step))
        assert np.array_equal(again.clip.root_position, step.clip.root_position)
        assert np.array_equal(again.clip.rotation, step.clip.rotation)
        assert np.array_equal(again.clip.contact, step.clip.contact)
        assert (again.direction, again.mirrored, again.clip.name) == (step.direction, step.mirrored, step.clip.name)


def test_every_joint_is_reflected_onto_opposite_joint(steps: list[StepClip]) -> None:
    clip = steps[0].clip
    position, _ = forward_kinematics(clip.root_position, clip.rotation)
    mirrored = mirror_clip(clip)
    reflected, _ = forward_kinematics(mirrored.root_position, mirrored.rotation)
    assert np.allclose(reflected, position[:, MIRROR] * (-1.0, 1.0, 1.0), atol=1e-5)


def test_contacts_exchange_sides(steps: list[StepClip]) -> None:
    mirrored = mirror_step(steps[0])
    assert (steps[0].clip.contact[:, 0] != steps[0].clip.contact[:, 1]).any()
    assert np.array_equal(mirrored.clip.contact[:, 0], steps[0].clip.contact[:, 1])


def test_left_and_right_directions_are_exchanged(steps: list[StepClip]) -> None:
    turned = [mirror_step(step).direction for step in steps[: len(DIRECTIONS)]]
    expected = [
        "in place",
        "short forward",
        "short left",
        "short right",
        "short back",
        "long forward",
        "long left",
        "long right",
        "long back",
    ]
    assert turned == expected
