"""Skeletons of character makers and capture programs: an independently posed body comes back with the same joints."""

import time
from dataclasses import replace

import numpy as np
import pytest

from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_report import analyze_motion
from live.motion.formats.gltf_reader import parse_gltf
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.joint_mapping import common_prefix, find_body
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_gltf import MadeGltf
from tests.motion.retarget.made_families import FAMILIES, MIXAMO, REALLUSION, family_bvh, family_motion, joints_of

BODY = tuple(name for name in SKELETON.names if name not in ("spine", "chest", "upperChest", "neck", "head"))
"""Joints whose place does not depend on how a trunk is divided."""


def largest_error(motion, places) -> float:
    """Largest distance [m] of a joint of the retargeted body from its true place, up to where the clip begins."""
    clip = retarget(motion, name="made")
    found, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    joints = [SKELETON.index(name) for name in BODY]
    off = found[:, joints] - places[: len(found), joints]
    return float(np.linalg.norm(off - off.mean(axis=(0, 1)), axis=-1).max())


@mostly_long("family", FAMILIES, quick=[2, 3, 4, 14])
def test_every_joint_of_the_body_is_found_by_name(family: str) -> None:
    motion, _ = family_motion(FAMILIES[family])
    rows, body = joints_of(FAMILIES[family]), find_body(motion)
    assert not body.by_shape
    for name in BODY:
        joint = body.joints[name]
        assert joint is not None, name
        assert (rows[joint][2], rows[joint][3]) == (name, 0.0)
    assert rows[body.joints["head"] or 0][2] == "head"
    assert rows[body.neck[0]][2] == "neck"
    assert rows[body.spine[0]][2] == "spine"
    assert rows[body.spine[-1]][2] == "upperChest"


@mostly_long("rest", ["T", "A", "hanging"], quick=[1])
@mostly_long("family", FAMILIES, quick=[8, 10, 11, 13])
def test_posed_body_comes_back_through_bvh(family: str, rest: str) -> None:
    motion, places = family_motion(FAMILIES[family], rest=rest)
    read = bvh_to_source_motion(parse_bvh(family_bvh(motion), "made.bvh"))
    assert largest_error(read, places) < 0.005


@mostly_long("family", FAMILIES, quick=[4, 16])
def test_posed_body_with_bones_of_any_axes_comes_back(family: str) -> None:
    """As in glTF: every bone has axes of its own in the rest pose."""
    motion, places = family_motion(FAMILIES[family], rest="A", scale=1.0, axes=7)
    assert largest_error(motion, places) < 0.005


@pytest.mark.parametrize("family", ["Reallusion", "Mixamo in glTF"])
def test_posed_body_comes_back_through_glb(family: str) -> None:
    motion, places = family_motion(FAMILIES[family], rest="A", scale=1.0, axes=7)
    made = MadeGltf()
    assert motion.rest_rotation is not None
    nodes: list[int] = []
    for name, parent, offset, rest in zip(
        motion.names, motion.parents.tolist(), motion.offsets, motion.rest_rotation, strict=True
    ):
        above = None if parent < 0 else nodes[parent]
        nodes.append(made.node(name, above, translation=offset.tolist(), rotation=rest[[1, 2, 3, 0]].tolist()))
    tracks = {(node, "rotation"): motion.rotation[:, joint] for joint, node in enumerate(nodes)}
    tracks |= {(node, "translation"): motion.translation[:, joint] for joint, node in enumerate(nodes[:2])}
    made.animate(tracks, np.arange(motion.frame_count) / 60.0)
    assert largest_error(parse_gltf(made.glb(), "made.glb"), places) < 0.005


def renamed(text: str):
    motion, places = family_motion(text)
    return replace(motion, names=tuple(f"bone_{n:02}" for n in range(motion.joint_count))), places


@mostly_long("family", ["Axis Studio", "SMPL", "Xsens joints", "Motive", "Rokoko", "Perception Neuron"], quick=[0, 3])
def test_nameless_body_is_found_by_its_shape(family: str) -> None:
    motion, places = renamed(FAMILIES[family])
    named, _ = family_motion(FAMILIES[family])
    found, expected = find_body(motion), find_body(named)
    assert found.by_shape
    limbs = [name for name in BODY if not name.endswith("Toes")]
    assert {name: found.joints[name] for name in limbs} == {name: expected.joints[name] for name in limbs}
    assert found.spine == expected.spine
    assert largest_error(motion, places) < 0.005
    told = [warning.what for warning in analyze_motion(motion)[0].warnings]
    assert any("found by its shape; check left and right" in words for words in told)


def test_left_and_right_come_from_toes_and_knees_not_from_order() -> None:
    """The same body with its sides written in the other order."""
    swapped = MIXAMO.replace("{p}", "").replace("Left", "#").replace("Right", "Left").replace("#", "Right")
    swapped = swapped.replace("left", "#").replace("right", "left").replace("#", "right")
    motion, places = renamed(swapped)
    assert largest_error(motion, places) < 0.005


@pytest.mark.parametrize("kept", [5, 12])
def test_part_of_a_body_is_no_body(kept: int) -> None:
    motion, _ = renamed(FAMILIES["Axis Studio"])
    part = replace(
        motion,
        names=motion.names[:kept], parents=motion.parents[:kept], offsets=motion.offsets[:kept],
        translation=motion.translation[:, :kept], rotation=motion.rotation[:, :kept],
        end_parents=motion.end_parents[:0], end_offsets=motion.end_offsets[:0],
    )  # fmt: skip
    assert find_body(part).missing


def test_common_prefix_is_what_most_names_begin_with() -> None:
    names = [name for name, _, _, _ in joints_of(REALLUSION)]
    assert common_prefix(names) == ("cc", "base")
    assert common_prefix([name for name, _, _, _ in joints_of(FAMILIES["SMPL-X"])]) == ()
    assert common_prefix([f"LeftHand{n}" for n in range(20)]) == ()
    assert common_prefix(["CC_Base_Hip", "CC_Base_Head"]) == ()


def test_hostile_skeletons_take_no_time() -> None:
    """Hundreds of limbs of one joint, a chain of joints, and names of a hundred thousand words."""
    count = 500
    flat = np.full(count, 0, np.int32)
    flat[0] = -1
    chains = np.where(np.arange(count) % 4 == 1, 0, np.arange(count) - 1).astype(np.int32)
    chain = np.arange(-1, count - 1, dtype=np.int32)
    motion, _ = renamed(FAMILIES["SMPL"])
    begin = time.process_time()
    for parents in (flat, chains, chain):
        hostile = replace(
            motion,
            names=("a_" * 100_000,) * 10 + ("x",) * (count - 10), parents=parents, offsets=np.ones((count, 3)),
            translation=np.ones((2, count, 3)), rotation=np.tile((1.0, 0.0, 0.0, 0.0), (2, count, 1)),
            end_parents=motion.end_parents[:0], end_offsets=motion.end_offsets[:0],
        )  # fmt: skip
        assert find_body(hostile).missing
    assert time.process_time() - begin < 5.0
