"""Fit of characters to the engine's skeleton, for any bone names, rest pose, unit and proportions."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.body.catalogue import CharacterFile, MaterialOverride
from live.base.errors import PersonError
from live.motion.skeleton import SKELETON
from live.render.body.body_lookup import build_figure
from live.render.body.body_mesh import COARSE, LIGHT
from live.render.characters.character import TRIANGLES, load_character
from live.render.characters.model_reader import parse_model
from live.render.characters.skeleton_fit import find_joints, fit
from tests.render.characters.figures import glb_of, mixamo, rigify, striped_image, unreal

BODY = build_figure(LIGHT)
LONGEST_EDGE = 0.13
"""[m]: the figure itself, drawn finely, has edges of 0.124 on its trunk."""
OTHER = {"LowerLeg": 0.8, "Foot": 0.85, "UpperArm": 1.2, "LowerArm": 1.2, "Hand": 1.1, "head": 1.3}


def fit_figure(**wanted):
    model = parse_model(glb_of(**wanted), "anna.glb")
    return model, fit(model, find_joints(model, {}))


@pytest.mark.parametrize(
    "wanted",
    [{}, {"names": mixamo}, {"names": unreal}, {"names": rigify}, {"vrm": "1.0"}, {"vrm": "0.x", "turn": 180.0},
     {"names": mixamo, "unit": 100.0}, {"turn": -90.0}, {"names": unreal, "unit": 39.37, "turn": 30.0}],
)  # fmt: skip
def test_body_read_from_file_equals_generated_body(wanted):
    model, own = fit_figure(**wanted)
    assert find_joints(model, {}) == {name: at for at, name in enumerate(SKELETON.names)}
    soles = BODY.position[:, 1].min()  # they end a little over the floor, and are put upon it
    assert 0.0 <= soles < 0.0015
    assert np.abs(own.position - BODY.position).max() < 2e-5 + 1.3 * soles
    assert np.abs(own.normal - BODY.normal).max() < 1e-3


def test_lowered_arms_of_rest_pose_are_raised():
    _, own = fit_figure(names=mixamo, arms_down=45.0)
    off = np.linalg.norm(own.position - BODY.position, axis=1)
    assert off.max() < 0.006
    assert off.mean() < 0.0005


def test_hands_and_feet_match_skeleton_at_any_proportions():
    _, own = fit_figure(names=mixamo, lengths=OTHER, arms_down=50.0)
    assert own.max_joint_offset > 0.15  # its joints do lie elsewhere
    for name in ("leftHand", "rightHand", "leftFoot", "rightFoot", "leftLowerArm", "rightLowerLeg", "hips"):
        mine = own.weight[:, SKELETON.index(name)] > 0.8
        apart = own.position[mine].mean(axis=0) - BODY.position[mine].mean(axis=0)
        assert np.linalg.norm(apart) < 0.012, name
    feet = own.weight[:, [SKELETON.index("leftFoot"), SKELETON.index("leftToes")]].sum(axis=1) > 0.8
    assert abs(own.position[feet, 1].min()) < 0.004  # the sole lies on the floor


def test_joints_of_toes_near_the_floor_do_not_stretch_the_foot():
    """MakeHuman's game engine rig has them 1 cm over the floor."""
    model = parse_model(glb_of(), "anna.glb")
    joints = find_joints(model, {})
    place = model.node_position.copy()
    place[[joints["leftToes"], joints["rightToes"]], 1] = 0.006
    own = fit(replace(model, node_position=place), joints)
    toes = own.weight[:, SKELETON.index("leftToes")] > 0.5
    assert own.position[toes, 1].max() < BODY.position[toes, 1].max() + 0.03
    assert np.ptp(own.position[toes, 2]) < 1.5 * np.ptp(BODY.position[toes, 2])


def test_missing_joints_are_synthesized():
    lacks = ("upperChest", "neck", "leftToes", "rightToes", "leftShoulder", "rightShoulder")
    model, own = fit_figure(vrm="1.0", without=lacks)
    assert {name for name, node in find_joints(model, {}).items() if node is None} == set(lacks)
    assert np.abs(own.position - BODY.position).max() < 0.01
    assert np.allclose(own.weight.sum(axis=1), 1.0)
    for name in ("upperChest", "neck", "leftToes", "rightToes"):  # their skin bends where the dancer's does
        assert own.weight[:, SKELETON.index(name)].max() > 0.9


def test_bones_whose_names_say_nothing_are_found_by_the_shape_of_the_skeleton():
    model = parse_model(glb_of(names=lambda name: f"Bone{SKELETON.index(name):03d}"), "anna.glb")
    assert find_joints(model, {}) == {name: at for at, name in enumerate(SKELETON.names)}


def test_unknown_bone_names_are_reported_and_can_be_mapped():
    unclear = {"LowerArm": 1.7, "Hand": 1.7}  # arms as long as legs
    data = glb_of(names=lambda name: f"Bone{SKELETON.index(name):03d}", lengths=unclear)
    model = parse_model(data, "anna.glb")
    with pytest.raises(ValueError, match=r"no hips, no head.*joints = \{ hips"):
        find_joints(model, {})
    said = {name: f"Bone{at:03d}" for at, name in enumerate(SKELETON.names)}
    assert find_joints(model, said)["leftHand"] == SKELETON.index("leftHand")
    with pytest.raises(ValueError, match="no bone is called 'Bon'"):
        find_joints(model, said | {"head": "Bon"})
    with pytest.raises(ValueError, match=r"would be .* and "):
        find_joints(model, said | {"head": "Bone000"})


@pytest.mark.long
def test_levels_have_fewer_triangles_and_keep_the_shape(tmp_path):
    path = tmp_path / "anna.glb"
    path.write_bytes(glb_of(level=2, image=striped_image()))
    loaded = load_character(CharacterFile("anna", str(path)))
    fine, light, coarse = (loaded.levels[level].body for level in (2, 1, 0))
    assert len(fine.triangle) == len(build_figure(2).triangle)
    for level, mesh in ((LIGHT, light), (COARSE, coarse)):
        assert 0.6 * TRIANGLES[level] < len(mesh.triangle) <= TRIANGLES[level]
        assert np.abs(mesh.position.max(axis=0) - fine.position.max(axis=0)).max() < 0.025  # toes are thin
        assert np.abs(mesh.position.min(axis=0) - fine.position.min(axis=0)).max() < 0.020
        edges = mesh.position[mesh.triangle] - mesh.position[mesh.triangle[:, [1, 2, 0]]]
        assert np.linalg.norm(edges, axis=2).max() < LONGEST_EDGE  # nothing is torn across the body
        assert np.allclose(mesh.weight.sum(axis=1), 1.0, atol=1e-5)
    assert _volume(light) == pytest.approx(_volume(fine), rel=0.06)


def _volume(mesh):
    """Volume below the neck; above it eyes, lids and hair lie within one another."""
    corners = mesh.position[mesh.triangle].astype(float) - (0.0, 1.46, 0.0)
    a, b, c = corners[corners[..., 1].max(axis=1) < 0.0].transpose(1, 0, 2)
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


def test_material_overrides_apply_by_name(tmp_path):
    path = tmp_path / "anna.glb"
    path.write_bytes(glb_of(image=striped_image()))
    red = CharacterFile("anna", str(path), materials=(("cloth", MaterialOverride(colour=(0.25, 0.0, 0.0), sheen=0.5)),))
    assert np.allclose(load_character(red).levels[2].tint, (0.5, 0.0, 0.0, 0.5))
    for name, worn, words in (
        ("hat", MaterialOverride(), "no material is called 'hat'"),
        ("cloth", MaterialOverride(hidden=True), "hidden"),
    ):
        with pytest.raises(PersonError, match=words):
            load_character(CharacterFile("anna", str(path), materials=((name, worn),)))
