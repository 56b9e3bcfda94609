"""Fingers, faces and blend shapes of characters: found in files of several programs, and drawn as plain matrices do."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.body.catalogue import CharacterFile
from live.base.body.expression import CURL, FACE_SIZE, FINGERS, SPREAD
from live.base.stage_snapshot import Camera, StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.adaptive_quality import HARDWARE
from live.render.body.body_lookup import Kind
from live.render.body.body_mesh import FINE
from live.render.body.drawn_joints import EXPRESSION_SIZE
from live.render.characters.bone_names import plain_name
from live.render.characters.character import load_character
from live.render.characters.detail_bones import _finger_of, find_details
from live.render.characters.expressions import CHANNEL_NAMES, CHANNELS, find_expressions
from live.render.characters.model_reader import parse_model
from live.render.characters.own_joints import FIRST
from live.render.characters.skeleton_fit import find_joints, fit
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.skinning import SKINS
from tests.fixtures.mostly_long import mostly_long
from tests.motion.cloth.test_springs import matrix_of, rotation_matrix
from tests.render.characters.detailed_figures import (
    ARKIT,
    KNUCKLES,
    REST,
    STYLES,
    Detailed,
    detailed_document,
    detailed_glb,
)
from tests.render.poses import LUNGE, pose
from tests.render.test_renderer import scene


def load(tmp_path, **wanted):
    path = tmp_path / "anna.glb"
    path.write_bytes(detailed_glb(**wanted))
    return load_character(CharacterFile("anna", str(path)))


@pytest.mark.parametrize(
    ("name", "finger"),
    [
        ("mixamorig:LeftHandPinky2", "Little"), ("CC_Base_L_Mid1", "Middle"), ("lMid2", "Middle"), ("lCarpal1", None),
        ("finger1-1.L", "Thumb"), ("finger4-2.R", "Ring"), ("Bip01 L Finger0", "Thumb"), ("Bip01 L Finger12", "Index"),
        ("Bip01 R Finger4", "Little"), ("thumb_01_l", "Thumb"), ("DEF-f_pinky.03.R", "Little"), ("Forearm_L", None),
        ("J_Bip_R_Ring3", "Ring"), ("Finger_B_1_L", "Index"), ("LeftFingerBase", None),
    ],
)  # fmt: skip
def test_finger_of_a_bone_is_told_by_its_name(name, finger):
    assert _finger_of(plain_name(name)) == finger


@mostly_long("style", STYLES, quick=[7, 8])
def test_fingers_and_face_are_found_whatever_program_named_them(style):
    figure = Detailed(**STYLES[style])
    _, _, nodes = detailed_document(figure)
    model = parse_model(detailed_glb(**STYLES[style]), "anna.glb")
    details = find_details(model, find_joints(model, {}))
    for side in ("left", "right"):
        for finger in FINGERS:
            assert details.fingers[side + finger] == tuple(nodes[f"{side}{finger}{bone}"] for bone in (1, 2, 3))
    wanted = {name: nodes[name] for name in ("leftEye", "rightEye", "jaw") if name in nodes}
    assert details.face == wanted
    assert set(details.missing) == {"leftEye", "rightEye", "jaw"} - set(wanted)


@mostly_long("style", [name for name in STYLES if name != "nothing said"], quick=[0])
def test_fingers_lie_where_the_dancer_has_its_hands(style, tmp_path):
    """At any unit, pose of the arms and direction."""
    own = load(tmp_path, **STYLES[style]).own
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for finger in FINGERS:
            rest = own.rest[own.names.index(f"{side}{finger}1")]
            wanted = REST[f"{side}Hand"] + np.array(KNUCKLES[finger][0]) * (sign, 1.0, 1.0)
            assert np.linalg.norm(rest - wanted) < 0.004


def test_hands_whose_palms_look_ahead_are_turned_down():
    model = parse_model(detailed_glb(vrm="1.0"), "anna.glb")
    joints = find_joints(model, {})
    details = find_details(model, joints)
    rolled = model.node_position.copy()
    about = rotation_matrix((1, 0, 0), -1.2)  # the little finger goes down
    for name, chain in details.fingers.items():
        if name.startswith("left"):
            rolled[list(chain)] = (rolled[list(chain)] - REST["leftHand"]) @ about.T + REST["leftHand"]
    fitted = fit(replace(model, node_position=rolled), joints, details.fingers)
    index, little = (
        fitted.transform.apply(rolled[[details.fingers[name][0]]], np.array([SKELETON.index("leftHand")]))[0]
        for name in ("leftIndex", "leftLittle")
    )
    assert little[2] < index[2] - 0.04
    assert abs(little[1] - index[1]) < 0.012
    straight = fit(model, joints, details.fingers)
    assert np.allclose(straight.transform.turn[SKELETON.index("leftHand")], (1, 0, 0, 0), atol=0.02)


def test_character_without_hands_and_face_dances_without_them(tmp_path):
    loaded = load(tmp_path, vrm="1.0", fingers=(), eyes=(), hair="", without=("leftHand", "rightHand"))
    assert loaded.own.count == 0
    assert loaded.details.missing == ("left fingers", "right fingers", "leftEye", "rightEye", "jaw")
    assert loaded.levels[FINE].body.joint.max() < FIRST


@pytest.mark.long
def test_hands_of_four_fingers_are_named_by_their_order():
    style = STYLES["nothing said"] | {"fingers": ("Thumb", "Index", "Middle", "Ring")}
    _, _, nodes = detailed_document(Detailed(**style))
    model = parse_model(detailed_glb(**style), "anna.glb")
    details = find_details(model, find_joints(model, {}))
    assert details.fingers["leftThumb"][0] == nodes["leftThumb1"]
    assert details.fingers["leftLittle"][0] == nodes["leftRing1"]
    assert "left ring finger" in details.missing


# -- expressions -----------------------------------------------------------------------------------------------------


def test_blend_shapes_are_found_by_names_and_presets():
    names = {0: ["eyeBlinkLeft", "eyeBlinkRight", "jawOpen", "mouthSmileLeft", "mouthSmileRight"]}
    found = find_expressions(names, {}).binds
    assert {CHANNEL_NAMES[channel] for channel in found} == {"blinkLeft", "blinkRight", "mouthOpen", "smile"}
    assert found[CHANNEL_NAMES.index("smile")] == (((0, 3), 0.8), ((0, 4), 0.8))
    vroid = {0: ["Face.M_F00_000_00_Fcl_EYE_Close_L", "Face.M_F00_000_00_Fcl_EYE_Close_R", "x_Fcl_MTH_A"]}
    assert find_expressions(vroid, {}).binds[CHANNEL_NAMES.index("mouthOpen")] == (((0, 2), 1.0),)
    presets = {"blink": (((1, 4), 1.0),), "aa": (((1, 0), 0.9),)}
    one_for_both = find_expressions({0: [], 1: [""] * 6}, presets)
    assert one_for_both.both_eyes == (((1, 4), 1.0),)
    assert one_for_both.binds == {CHANNEL_NAMES.index("mouthOpen"): (((1, 0), 0.9),)}


@mostly_long("vrm", ["0.x", "1.0"], quick=[1])
def test_expression_of_a_vrm_that_closes_both_eyes_is_split(vrm, tmp_path):
    both = {
        "both": lambda position, normal: (
            ARKIT["eyeBlinkLeft"](position, normal) + ARKIT["eyeBlinkRight"](position, normal)
        )
    }
    mouth = {"aa" if vrm == "1.0" else "a": {"mouth": 1.0}}
    loaded = load(
        tmp_path, vrm=vrm, turn=180.0 if vrm == "0.x" else 0.0, shapes=both | {"mouth": ARKIT["jawOpen"]},
        expressions={"blink": {"both": 1.0}} | mouth,
    )  # fmt: skip
    assert loaded.channels == ("blinkLeft", "blinkRight", "mouthOpen")
    morphs, position = loaded.levels[FINE].morphs, loaded.levels[FINE].body.position
    vertex = np.repeat(np.arange(len(position)), morphs.count)
    for channel, sign in ((0, 1.0), (1, -1.0)):
        moved = vertex[morphs.entry[:, 3] == channel]
        assert len(moved)
        assert (position[moved, 0] * sign > -0.011).all()


def movements_of(morphs, vertices):
    """Movements (K, V, 3) in metres from packed entries."""
    moved = np.zeros((len(CHANNELS), vertices, 3))
    vertex = np.repeat(np.arange(vertices), morphs.count)
    numbers = morphs.entry[:, :3].copy().view(np.uint16).astype(float)
    moved[morphs.entry[:, 3], vertex] = (numbers[:, :3] - 32768.0) / 32767.0 * 0.25
    return moved


@pytest.mark.long
def test_blend_shapes_move_the_fitted_face_as_in_the_file(tmp_path):
    loaded = load(tmp_path, shapes=ARKIT, **STYLES["Mixamo"])  # in centimetres
    body, morphs = loaded.levels[FINE].body, loaded.levels[FINE].morphs
    moved = movements_of(morphs, len(body.position))
    jaw = moved[CHANNEL_NAMES.index("mouthOpen")]
    deepest = np.argmin(jaw[:, 1])
    assert jaw[deepest, 1] == pytest.approx(-0.03 * 0.8 * loaded.fitted.transform.scale * 100.0, rel=0.25)
    assert np.linalg.norm(body.position[deepest] - (0.0, 1.54, 0.10)) < 0.03
    smile = moved[CHANNEL_NAMES.index("smile")]
    assert smile[body.position[:, 0] > 0.02][:, 0].max() > 0.003
    assert smile[body.position[:, 0] < -0.02][:, 0].min() < -0.003


# -- poses -----------------------------------------------------------------------------------------------------------


def own_frames(loaded, position, rotation, expression, spring):
    """World rotation and place of each own joint with matrices."""
    own, frames = loaded.own, []
    for m in range(own.count):
        j, p = int(own.joint[m]), int(own.parent[m])
        turn, at, rest = (
            (matrix_of(rotation[j]), position[j], REST[SKELETON.names[j]]) if p < 0 else (*frames[p], own.rest[p])
        )
        place = at + turn @ (own.rest[m] - rest)
        if own.spring[m] >= 0:
            frames.append((matrix_of(rotation[j]) @ matrix_of(spring[own.spring[m]]), place))
            continue
        around = sum(own.turn[m, k] * expression[own.column[m, k]] for k in range(2))
        size = np.linalg.norm(around)
        frames.append((turn @ (rotation_matrix(around, size) if size > 1e-9 else np.eye(3)), place))
    return frames


@pytest.mark.long
@pytest.mark.gl
def test_shader_skins_own_joints_and_blend_shapes_as_matrices_do(gl_context, tmp_path):
    """Vertices that one joint moves; faces, hands and springs of two dancers differ."""
    loaded = load(tmp_path, vrm="1.0", shapes=ARKIT, strands=2, jaw="Jaw", springs="1.0")
    random = np.random.default_rng(4)
    camera = Camera(eye=(0.0, 1.2, 3.0), target=(0.0, 1.0, 0.0), field_of_view_deg=60.0)
    file = CharacterFile("anna", str(tmp_path / "anna.glb"))
    stage = replace(scene(2, camera), bodies=("anna", "anna"), characters=(file,))
    view = StageView.allocate(2, JOINT_COUNT)
    for number in range(2):
        view.joint_position[number], view.joint_rotation[number] = pose(LUNGE, (number - 0.5, 0.2), 30.0 * number)
    view.face[:] = random.uniform(-1.0, 1.0, view.face.shape)
    view.hand[..., CURL], view.hand[..., SPREAD] = random.uniform(0.0, 1.0, (2, 2, 5)), random.uniform(-1, 1, (2, 2))
    spring = random.normal(size=(2, loaded.springs.rig.count, 4))
    view.spring = (spring / np.linalg.norm(spring, axis=-1, keepdims=True)).astype(np.float32)
    view.spring_slot = np.array([1, 0], np.int32)
    batch = DancerBatch(gl_context, stage, HARDWARE, (640, 360))
    batch.update(view, np.array([0.3, 0.9, 0.2], np.float32))
    batch.skin()
    texture = batch._skin.texture
    drawn = np.frombuffer(texture.read(), np.float32).reshape(-1, 4)[:, :3]
    close = SKINS.index("close")
    rows, mesh = batch._skin.rows, loaded.levels[HARDWARE.close_level]
    first = batch._places[0][close, batch.kinds.index(Kind("character", "anna"))]
    row = next(n for n in range(len(rows)) if rows[n, 0] == first and rows[n, 2] == 0)
    vertices, checked = len(mesh.body.position), 0
    for dancer in range(2):
        expression = np.zeros(EXPRESSION_SIZE)
        expression[:FACE_SIZE], expression[FACE_SIZE:] = view.face[dancer], view.hand[dancer].ravel()
        frames = own_frames(
            loaded, view.joint_position[dancer], view.joint_rotation[dancer], expression, view.spring[1 - dancer]
        )
        moved = movements_of(mesh.morphs, vertices)
        weights = [np.clip(expression[c.column] * c.factor, 0.0, 1.0) for c in CHANNELS]
        position = mesh.body.position + np.einsum("k,kvi->vi", weights, moved)
        place = drawn[(row << batch._skin.shift) + dancer * vertices :][:vertices]
        for vertex in np.flatnonzero(mesh.body.weight[:, 0] > 0.999).tolist():
            joint = int(mesh.body.joint[vertex, 0])
            if joint < FIRST:
                turn, at = matrix_of(view.joint_rotation[dancer, joint]), view.joint_position[dancer, joint]
                rest = REST[SKELETON.names[joint]]
            else:
                (turn, at), rest = frames[joint - FIRST], loaded.own.rest[joint - FIRST]
            assert np.abs(at + turn @ (position[vertex] - rest) - place[vertex]).max() < 2e-4
            checked += 1
    assert checked > 1000
    assert (np.abs(moved).max(axis=(1, 2)) > 0.005).sum() >= 5  # blend shapes did move vertices
    batch.release()


def test_closed_fist_brings_fingertips_to_the_palm(tmp_path):
    loaded = load(tmp_path, vrm="1.0", hair="")
    own, expression = loaded.own, np.zeros(EXPRESSION_SIZE)
    expression[FACE_SIZE + CURL.start : FACE_SIZE + CURL.stop] = 1.0
    position, rotation = pose({}, (0.0, 0.0), 0.0)
    frames = own_frames(loaded, position, rotation, expression, None)
    palm = REST["leftHand"] + (0.07, -0.02, 0.0)
    for finger in ("Index", "Middle", "Ring", "Little"):
        last = own.names.index(f"left{finger}3")
        turn, place = frames[last]
        tip = place + turn @ np.array([0.02, 0.0, 0.0])
        assert np.linalg.norm(tip - palm) < 0.055, finger
        assert tip[1] < REST["leftHand"][1] - 0.005  # below, not through the back of the hand
