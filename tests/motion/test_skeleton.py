"""Tests of Skeleton, Clip and StepClip: their properties and validation."""

import numpy as np
import pytest

from live.motion.clip import Clip
from live.motion.skeleton import BODY_HEIGHT, JOINT_COUNT, MIRROR, SKELETON, SOLE_BELOW_ANKLE
from live.motion.step_clip import DIRECTIONS, StepClip

SIDE = ("Shoulder", "UpperArm", "LowerArm", "Hand")
LEG = ("UpperLeg", "LowerLeg", "Foot", "Toes")
HUMANOID = ["hips", "spine", "chest", "upperChest", "neck", "head"] + [
    side + part for parts in (SIDE, LEG) for side in ("left", "right") for part in parts
]


def test_skeleton_has_vrm_humanoid_names_in_order():
    assert list(SKELETON.names) == HUMANOID
    assert JOINT_COUNT == 22
    assert all(parent < joint for joint, parent in enumerate(SKELETON.parents))


def test_rest_pose_is_symmetric_t_pose_on_floor():
    rest = SKELETON.rest_positions()
    left, right = rest[SKELETON.index("leftHand")], rest[SKELETON.index("rightHand")]
    assert left[0] > 0.6  # facing the audience, left is at +x
    assert left == pytest.approx(right * [-1, 1, 1])
    assert rest[list(MIRROR)] == pytest.approx(rest * [-1, 1, 1], abs=1e-6)
    assert rest[SKELETON.index("leftFoot"), 1] == pytest.approx(SOLE_BELOW_ANKLE)
    assert rest[SKELETON.index("leftToes"), 2] > 0.1
    assert 1.45 < rest[SKELETON.index("head"), 1] < BODY_HEIGHT
    assert [MIRROR[MIRROR[j]] for j in range(22)] == list(range(22))


def _clip(samples=9, **changes):
    values = {
        "name": "x",
        "root_position": np.zeros((samples, 3), np.float32),
        "rotation": np.ones((samples, 22, 4), np.float32) / 2,
        "sample_rate": 4.0,
        "contact": np.ones((samples, 2), np.bool_),
    }
    return Clip(**{**values, **changes})


def test_clip_is_read_only_and_has_duration():
    clip = _clip()
    assert clip.seconds == 2.0
    with pytest.raises(ValueError, match="read-only"):
        clip.root_position[0] = 1.0


@pytest.mark.parametrize(
    "changes",
    [
        {"root_position": np.zeros((8, 3), np.float32)},
        {"contact": np.ones((9, 3), np.bool_)},
        {"root_position": np.full((9, 3), np.nan, np.float32)},
        {"rotation": np.full((9, 22, 4), np.inf, np.float32)},
    ],
)
def test_clip_with_wrong_shapes_or_numbers_is_refused(changes):
    with pytest.raises(ValueError, match="clip 'x'"):
        _clip(**changes)


def test_step_outside_clip_is_refused():
    step = StepClip("s", _clip(), first=2.0, samples_per_measure=3.0, measures=2)
    assert step.beats == 8
    with pytest.raises(ValueError, match="ends at 8"):
        StepClip("s", _clip(), first=3.0, samples_per_measure=3.0, measures=2)
    with pytest.raises(ValueError, match="first -1"):
        StepClip("s", _clip(), first=-1.0, samples_per_measure=3.0)


def test_nine_directions_are_distinct():
    assert len(set(DIRECTIONS)) == 9
