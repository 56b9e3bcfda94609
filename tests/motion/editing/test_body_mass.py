"""The body's masses: their sum, where the balance of a standing person is, and momentum against its definition."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.editing.body_mass import SEGMENTS, angular_momentum, centre_of_mass, rotation_row
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import BODY_HEIGHT, JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip
from tests.motion.editing.body_physics import measure_samples, physics_of
from tests.motion.editing.made_steps import random_clip


def test_shares_are_of_one_body_and_alike_on_both_sides():
    assert sum(share for share, _, _ in SEGMENTS.values()) == pytest.approx(1.0, abs=1e-9)
    for joint, (share, at, radii) in SEGMENTS.items():
        if SKELETON.names[joint].startswith("left"):
            other = SEGMENTS[SKELETON.index(SKELETON.names[joint].replace("left", "right"))]
            assert other[0] == share
            assert np.array_equal(other[1], at * (-1.0, 1.0, 1.0))
            assert np.array_equal(other[2], radii)


def test_every_segment_is_a_possible_body():
    """No moment of inertia is larger than the sum of the other two."""
    for _, _, radii in SEGMENTS.values():
        assert (radii**2 < (radii**2).sum() - radii**2).all()


def test_standing_body_is_balanced_at_57_percent_of_its_height_with_arms_level():
    """55 to 57 % with hanging arms (Winter 2009); two level arms of 5 % of the mass lift it by 2 %."""
    hips = SKELETON.rest_positions()[:1].astype(np.float64)
    centre = centre_of_mass(hips, rotation_row(np.broadcast_to(np.eye(3), (1, JOINT_COUNT, 3, 3))))[0]
    assert centre[0] == pytest.approx(0.0, abs=1e-9)
    assert abs(centre[2]) < 0.02
    assert 0.55 < centre[1] / BODY_HEIGHT < 0.60


@pytest.mark.parametrize("seed", range(3))
def test_centre_and_momentum_are_those_of_the_segments(seed):
    """Of every joint swinging about a random pose."""
    step = StepClip(step="any", clip=random_clip(seed, samples=400), first=40.0, samples_per_measure=300.0)
    physics = physics_of(step)
    row, root = _row(step)
    assert np.allclose(centre_of_mass(root, row), physics.centre, atol=1e-9)
    momentum = angular_momentum(row, step.clip.sample_rate)
    between = 0.5 * (physics.momentum[1:] + physics.momentum[:-1])
    assert np.abs(momentum - between).max() < 1e-3 * np.ptp(physics.momentum, axis=0).max()


def test_rigid_body_turns_with_its_moment_of_inertia():
    """A person in the rest pose who turns about the vertical at 2 rad/s, and about where the hips are."""
    rate, speed = 240.0, 2.0
    turn = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), speed * np.arange(5) / rate)
    rotation = np.tile(np.array(quaternion.IDENTITY), (5, JOINT_COUNT, 1))
    rotation[:, 0] = turn
    position, world = forward_kinematics(np.zeros((5, 3)), rotation)
    inertia = 0.0
    centre = sum(share * (position[0, j] + at) for j, (share, at, _) in SEGMENTS.items())
    for joint, (share, at, radii) in SEGMENTS.items():
        off = position[0, joint] + at - centre
        inertia += share * (off[0] ** 2 + off[2] ** 2 + radii[1] ** 2)
    momentum = angular_momentum(rotation_row(quaternion.to_matrix(world)), rate)
    assert momentum[:, 1] == pytest.approx(np.full(4, inertia * speed), rel=1e-4)


def _row(step: StepClip):
    first, last = measure_samples(step)
    root = step.clip.root_position[first : last + 1].astype(np.float64)
    _, world = forward_kinematics(root, step.clip.rotation[first : last + 1].astype(np.float64))
    return rotation_row(quaternion.to_matrix(world)), root
