"""Springs of character files: read from both versions of VRM and found by names, fitted to the dancer."""

import numpy as np
import pytest

from live.base.body.catalogue import CharacterFile
from live.base.errors import PersonError
from live.motion.cloth.spring_rig import DRAG, GRAVITY_Y, HIT_RADIUS, MAX_SPRINGS, STIFFNESS
from live.motion.skeleton import SKELETON
from live.render.characters.character import load_character
from tests.fixtures.mostly_long import mostly_long
from tests.render.characters.detailed_figures import (
    HAIR_BONE,
    HAIR_BONES,
    STYLES,
    Detailed,
    detailed_document,
    detailed_glb,
)
from tests.render.characters.figures import glb

SPRING = {"stiffness": 0.7, "gravityPower": 0.3, "dragForce": 0.45, "hitRadius": 0.015}
SPHERES = (((0.0, 0.07, 0.0), 0.09), ((0.0, 0.0, -0.02), 0.05))


def load(tmp_path, data):
    path = tmp_path / "anna.vrm"
    path.write_bytes(data)
    return load_character(CharacterFile("anna", str(path)))


def test_springs_of_vrm_1_have_their_settings(tmp_path):
    loaded = load(tmp_path, detailed_glb(vrm="1.0", springs="1.0", spring=SPRING, colliders=SPHERES, strands=2))
    springs, scale = loaded.springs, loaded.fitted.transform.scale
    rig = springs.rig
    assert springs.source == "VRM"
    assert rig.count == 2 * HAIR_BONES  # the last node of a strand is only an end
    assert rig.parent.tolist() == [-1, 0, 1, 2, 3, 4, -1, 6, 7, 8, 9, 10]
    assert (rig.joint == SKELETON.index("head")).all()
    assert np.allclose(rig.setting[:, [STIFFNESS, DRAG, HIT_RADIUS]], (0.7 * scale, 0.45, 0.015 * scale))
    assert np.allclose(rig.setting[:, GRAVITY_Y], -0.3 * scale)
    assert np.allclose(np.linalg.norm(rig.tail - rig.head, axis=1), HAIR_BONE * scale, rtol=0.02)
    assert (rig.hits & 3 == 3).all()  # the file's two colliders; then those of the body
    assert np.allclose(rig.collider[:2, 6], np.array([0.09, 0.05]) * scale)
    assert (rig.hits >> 2).any()
    head = SKELETON.rest_positions()[SKELETON.index("head")]
    assert np.abs(rig.collider[:2, :3] - head - [offset for offset, _ in SPHERES]).max() < 0.004


@pytest.mark.long
def test_both_versions_of_vrm_give_the_same_springs(tmp_path):
    """A VRM 0.x faces backwards, its colliders have the opposite z, and its last bones swing, too."""
    new = load(tmp_path, detailed_glb(vrm="1.0", springs="1.0", spring=SPRING, colliders=SPHERES)).springs.rig
    (tmp_path / "old").mkdir()
    old = load(
        tmp_path / "old", detailed_glb(vrm="0.x", turn=0.0, springs="0.x", spring=SPRING, colliders=SPHERES)
    ).springs.rig
    assert old.count == new.count + 1
    assert np.allclose(old.setting[:-1], new.setting)
    assert np.allclose(old.head[:-1], new.head, atol=1e-5)
    assert np.allclose(old.collider, new.collider, atol=1e-5)
    assert np.linalg.norm(old.tail[-1] - old.head[-1]) == pytest.approx(0.07, rel=0.03)


@mostly_long("style", ["Mixamo", "MakeHuman", "game engine"], quick=[2])
def test_hair_of_other_files_is_found_by_its_name_and_collides_with_the_body(style, tmp_path):
    loaded = load(tmp_path, detailed_glb(**STYLES[style]))
    rig = loaded.springs.rig
    assert loaded.springs.source == "bone names"
    assert rig.count >= HAIR_BONES
    assert np.allclose(np.linalg.norm(rig.tail - rig.head, axis=1)[:HAIR_BONES], HAIR_BONE, rtol=0.05)  # any unit
    assert 8 <= len(rig.collider) < 20
    for bone in range(rig.count):  # nothing collides where it hangs at rest
        for number, row in enumerate(rig.collider):
            if rig.hits[bone] >> number & 1:
                a, b = row[:3], row[3:6]
                share = np.clip((rig.tail[bone] - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
                assert np.linalg.norm(rig.tail[bone] - a - share * (b - a)) > row[6]
    assert rig.hits.any()


@pytest.mark.long
def test_of_two_hundred_springs_those_that_move_most_swing(tmp_path):
    loaded = load(tmp_path, detailed_glb(vrm="1.0", springs="1.0", strands=34))
    assert loaded.springs.rig.count == MAX_SPRINGS
    assert f"of its {34 * HAIR_BONES} springs, the {MAX_SPRINGS}" in " ".join(loaded.model.notes)
    assert loaded.own.count <= 203
    assert loaded.levels[2].body.joint.max() < 256


def test_springs_on_joints_of_the_body_are_left_out(tmp_path):
    root, chunk, nodes = detailed_document(Detailed(vrm="1.0", springs="1.0"))
    head = next(n for n, node in enumerate(root["nodes"]) if node["name"] == "head")
    joints = root["extensions"]["VRMC_springBone"]["springs"][0]["joints"]
    joints.insert(0, {"node": head})
    rig = load(tmp_path, glb(root, chunk)).springs.rig
    assert rig.count == HAIR_BONES
    assert nodes["hair"]


def broken(change):
    root, chunk, _ = detailed_document(Detailed(vrm="1.0", springs="1.0", colliders=SPHERES))
    change(root["extensions"]["VRMC_springBone"], root)
    return glb(root, chunk)


@mostly_long(
    ("change", "words"),
    [
        (lambda springs, _: springs["springs"][0]["joints"][0].update(node=9999), "node is 9999"),
        (lambda springs, _: springs["springs"][0].update(colliderGroups=[3]), "colliderGroups"),
        (lambda springs, _: springs["springs"][0]["joints"][0].update(stiffness="hard"), "stiffness"),
        (lambda springs, _: springs["colliders"][0].pop("shape"), "shape is missing"),
        (lambda _, root: root["nodes"][5].setdefault("children", []).append(0), "cycle|already has a parent"),
    ],
    quick=[2, 3, 4],
)
def test_damaged_springs_are_refused_with_file_and_place(change, words, tmp_path):
    with pytest.raises(PersonError, match=words) as refused:
        load(tmp_path, broken(change))
    assert "anna.vrm" in refused.value.message
    assert refused.value.remedy
