"""Drawn joints: the table is whole and symmetric, and the shader turns each joint as plain matrices do."""

import numpy as np
import pytest

from live.base.body.expression import CURL, FACE_SIZE, HAND_SIZE, SPREAD
from live.base.stage_snapshot import StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.body.drawn_joints import DETAIL_JOINTS, DRAWN_COUNT, DRAWN_MIRROR, DRAWN_NAMES, EXPRESSION_SIZE
from live.render.dancers.skinning import PoseTexture
from tests.render.poses import LUNGE, pose


def test_every_joint_hangs_on_one_before_it() -> None:
    assert len(set(DRAWN_NAMES)) == DRAWN_COUNT
    for number, joint in enumerate(DETAIL_JOINTS):
        assert DRAWN_NAMES.index(joint.parent) < JOINT_COUNT + number
        for column, _ in (joint.first, joint.second):
            assert 0 <= column < EXPRESSION_SIZE


def test_left_and_right_are_mirror_images() -> None:
    assert [DRAWN_MIRROR[other] for other in DRAWN_MIRROR] == list(range(DRAWN_COUNT))
    joints = {joint.name: joint for joint in DETAIL_JOINTS}
    for name, joint in joints.items():
        other = joints[DRAWN_NAMES[DRAWN_MIRROR[DRAWN_NAMES.index(name)]]]
        np.testing.assert_allclose(other.pivot, np.array(joint.pivot) * (-1.0, 1.0, 1.0), atol=1e-12)
        if "Eye" not in name and "Lid" not in name:  # both eyes look the same way
            np.testing.assert_allclose(other.first[1], np.array(joint.first[1]) * (1.0, -1.0, -1.0), atol=1e-12)


def _matrix(around: np.ndarray) -> np.ndarray:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(around))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = around / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


def _rotation(q: np.ndarray) -> np.ndarray:
    w, v = float(q[0]), q[1:].astype(np.float64)
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * (cross @ cross)


@pytest.mark.parametrize("dancers", [1, 5])
def test_shader_moves_detail_joints_as_matrices_do(gl_context, dancers) -> None:
    random = np.random.default_rng(dancers)
    view = StageView.allocate(dancers, JOINT_COUNT)
    for number in range(dancers):
        view.joint_position[number], view.joint_rotation[number] = pose(LUNGE, (float(number), 1.0), 40.0 * number)
    view.face[:] = random.uniform(-1.0, 1.0, view.face.shape)
    view.hand[..., CURL] = random.uniform(0.0, 1.0, (dancers, 2, 5))
    view.hand[..., SPREAD] = random.uniform(-1.0, 1.0, (dancers, 2))
    poses = PoseTexture(gl_context)
    poses.allocate(dancers)
    poses.upload(view)
    poses.draw()
    width, rows = poses.texture.size
    texels = np.frombuffer(poses.texture.read(), np.float32).reshape(rows, width, 4).astype(np.float64)
    poses.release()
    rest, joints = SKELETON.rest_positions().astype(np.float64), {joint.name: joint for joint in DETAIL_JOINTS}
    for dancer in range(dancers):
        expression = np.concatenate([view.face[dancer], view.hand[dancer].ravel()]).astype(np.float64)
        assert len(expression) == FACE_SIZE + 2 * HAND_SIZE
        for number, joint in enumerate(DETAIL_JOINTS):
            place = np.array(joint.pivot) + np.array([0.03, -0.02, 0.05])
            chain = place
            here = joint
            while True:
                around = sum(expression[column] * np.array(turn) for column, turn in (here.first, here.second))
                chain = _matrix(around) @ (chain - here.pivot) + here.pivot
                if here.parent not in joints:
                    break
                here = joints[here.parent]
            anchor = SKELETON.index(here.parent)
            expected = _rotation(view.joint_rotation[dancer, anchor]) @ (chain - rest[anchor])
            expected = expected + view.joint_position[dancer, anchor]
            texel = 2 * (JOINT_COUNT + number)
            real, dual = texels[dancer, texel], texels[dancer, texel + 1]
            move = 2.0 * (real[3] * dual[:3] - dual[3] * real[:3] + np.cross(real[:3], dual[:3]))
            np.testing.assert_allclose(_rotation(np.roll(real, 1)) @ place + move, expected, atol=5e-5)


def test_empty_stage_has_no_expression(gl_context) -> None:
    poses = PoseTexture(gl_context)
    poses.allocate(1)
    poses.upload(StageView.allocate(0, JOINT_COUNT))
    poses.release()
    assert poses.rows >= 1
