"""Tests of joint mapping: names of many programs, and hierarchies in which one name means different joints."""

import pytest

from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.joint_mapping import find_body, map_joints, split_name
from live.motion.skeleton import SKELETON
from tests.fixtures.mocap import mocap_motion
from tests.motion.formats.made_bvh import body_bvh, still


def skeleton(*paths: str) -> SourceMotion:
    """A skeleton in which each path "A/B/C" names a chain of joints from the root."""
    tree: dict[str, dict] = {}
    for path in paths:
        level = tree
        for name in path.split("/"):
            level = level.setdefault(name, {})

    def write(name: str, children: dict, keyword: str) -> str:
        inside = "".join(write(child, below, "JOINT") for child, below in children.items())
        return f"{keyword} {name}\n{{ OFFSET 0 1 0 CHANNELS 1 Xrotation\n{inside} }}\n"

    (root, children) = next(iter(tree.items()))
    text = "HIERARCHY\n" + write(root, children, "ROOT")
    count = text.count("CHANNELS")
    return bvh_to_source_motion(parse_bvh(f"{text}MOTION\nFrames: 1\nFrame Time: 0.1\n{'0 ' * count}\n", "made"))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mixamorig:LeftUpLeg", ("left", "upleg")),
        ("LeftUpLeg", ("left", "upleg")),
        ("lShldr", ("left", "shldr")),
        ("rThumb1", ("right", "thumb")),
        ("LHipJoint", ("left", "hipjoint")),
        ("upper_arm.L", ("left", "upperarm")),
        ("upperleg01.R", ("right", "upperleg")),
        ("UpArm_L", ("left", "uparm")),
        ("L_Hip", ("left", "hip")),
        ("Bip01 L Calf", ("left", "calf")),
        ("leftshoulder", ("left", "shoulder")),
        ("RIGHTKNEE", ("right", "knee")),
        ("spine.001", ("", "spine")),
        ("LeftHand_End", ("", "")),
        ("__UpLeg_L", ("", "")),
        ("LeftForeArmRoll", ("", "")),
        ("Hips", ("", "hips")),
        ("lowerback", ("", "lowerback")),
        ("", ("", "")),
        ("12", ("", "")),
    ],
)
def test_name_is_split_into_side_and_stem(name: str, expected: tuple[str, str]) -> None:
    assert split_name(name) == expected


COMMON = {
    "salsa/60_01.bvh": "hip abdomen chest - neck head lCollar lShldr lForeArm lHand lThigh lShin lFoot -",
    "solo/modern05/05_09.bvh": "Hips LowerBack Spine Spine1 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand "
    "LeftUpLeg LeftLeg LeftFoot LeftToeBase",
    "group/perfume_aachan.bvh": "Hips Chest Chest3 Chest4 Neck Head LeftCollar LeftShoulder LeftElbow LeftWrist "
    "LeftHip LeftKnee LeftAnkle LeftToe",
    "walk/131_01_styled.bvh": "Hips lowerback Chest Chest2 lowerneck Head LeftCollar LeftShoulder LeftElbow LeftWrist "
    "LeftHip LeftKnee LeftAnkle LeftToe",
    "walk/figure8_MS2_8Walk_M.bvh": "Hips Spine - - - Head LeftShoulder LeftArm LeftForeArm LeftHand "
    "LeftUpLeg LeftLeg LeftFoot LeftToeBase",
    "solo/rokoko_jesse_dance.bvh": "Hips Spine Spine1 Spine2 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand "
    "LeftUpLeg LeftLeg LeftFoot LeftToeBase",
    "edge/blender_rigify_metres_freemocap.bvh": "pelvis spine spine.001 - neck face shoulder.L upper_arm.L forearm.L - "
    "thigh.L shin.L foot.L -",
    "edge/makehuman_walk1.bvh": "Hips Spine1 Spine2 Spine3 Neck Head Clavicle_L UpArm_L LoArm_L Hand_L "
    "UpLeg_L LoLeg_L Foot_L Toe_L",
    "edge/makehuman_benchmark_6and3.bvh": "root spine05 spine03 spine01 neck01 head clavicle.L upperarm01.L "
    "lowerarm01.L wrist.L upperleg01.L lowerleg01.L foot.L toe1-1.L",
    "edge/spec_example_2frames.bvh": "Hips Chest - - Neck Head LeftCollar LeftUpArm LeftLowArm LeftHand "
    "LeftUpLeg LeftLowLeg LeftFoot -",
    "edge/mixamo_prefix_freebvh.bvh": "mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Spine2 mixamorig:Neck "
    "mixamorig:Head mixamorig:LeftShoulder mixamorig:LeftArm mixamorig:LeftForeArm mixamorig:LeftHand "
    "mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftFoot mixamorig:LeftToeBase",
}
CENTRE_AND_LEFT = [name for name in SKELETON.names if not name.startswith("right")]


@pytest.mark.shared
@pytest.mark.parametrize("file", COMMON)
def test_real_skeletons_are_mapped(file: str) -> None:
    found = map_joints(mocap_motion(file))
    assert {name: found[name] or "-" for name in CENTRE_AND_LEFT} == dict(
        zip(CENTRE_AND_LEFT, COMMON[file].split(), strict=True)
    )


@pytest.mark.shared
@pytest.mark.parametrize("file", COMMON)
def test_left_and_right_mappings_match(file: str) -> None:
    found = map_joints(mocap_motion(file))
    for name in SKELETON.names:
        if name.startswith("left"):
            left, right = found[name], found["right" + name[4:]]
            assert (left is None) == (right is None)
            assert left is None or (split_name(left)[1] == split_name(right or "")[1] and left != right)


def test_left_shoulder_is_clavicle_or_upper_arm() -> None:
    arm = skeleton("Hips/Spine/LeftShoulder/LeftArm/LeftForeArm/LeftHand")
    assert map_joints(arm)["leftShoulder"] == "LeftShoulder"
    assert map_joints(arm)["leftUpperArm"] == "LeftArm"
    collar = skeleton("Hips/Spine/LeftCollar/LeftShoulder/LeftElbow/LeftWrist")
    assert map_joints(collar)["leftShoulder"] == "LeftCollar"
    assert map_joints(collar)["leftUpperArm"] == "LeftShoulder"


def test_left_foot_below_ankle_is_toes() -> None:
    found = map_joints(skeleton("Pelvis/L_Hip/L_Knee/L_Ankle/L_Foot"))
    assert [found[name] for name in ("leftUpperLeg", "leftLowerLeg", "leftFoot", "leftToes")] == [
        "L_Hip",
        "L_Knee",
        "L_Ankle",
        "L_Foot",
    ]


def test_misplaced_names_are_ignored() -> None:
    body = find_body(skeleton("Hips/LeftFoot/LeftLeg/LeftUpLeg", "Hips/RightUpLeg/RightLeg/RightFoot"))
    assert body.joints["leftUpperLeg"] is None
    assert body.joints["rightFoot"] is not None
    assert "leftUpperLeg" in body.missing


def test_complete_body_is_found() -> None:
    body = find_body(bvh_to_source_motion(parse_bvh(body_bvh(still()), "made")))
    assert body.missing == ()
    assert body.joint("leftUpperLeg") == 13
    assert len(body.spine) == 2
    assert all(joint is not None for name, joint in body.joints.items() if name != "upperChest")


def test_hundreds_of_equal_names_are_handled() -> None:
    chain = "Hips/" + "/".join(["LeftUpLeg"] * 1)
    text = "HIERARCHY\nROOT Hips { OFFSET 0 1 0 CHANNELS 1 Xrotation\n"
    names = ["LeftUpLeg"] * 330 + ["LeftLeg"] * 330 + ["LeftThing"] * 330
    text += "".join(f"JOINT {name} {{ OFFSET 0 1 0\n" for name in names) + "}" * (len(names) + 1)
    motion = parse_bvh(f"{text}\nMOTION\nFrames: 1\nFrame Time: 0.1\n0\n", "made")
    assert find_body(bvh_to_source_motion(motion)).joints["leftUpperLeg"] is None
    assert find_body(skeleton(chain)).joints["leftUpperLeg"] is None


def test_missing_joint_raises_only_on_access() -> None:
    body = find_body(skeleton("Hips/Tail"))
    assert len(body.missing) == 11
    assert body.missing[-1] == "hips"
    with pytest.raises(KeyError, match="leftFoot"):
        body.joint("leftFoot")
