"""Tests of the glTF reader: against BVH and matrices, in all encodings, with VRM humanoid maps."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation, Slerp

from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.gltf_reader import parse_gltf
from live.motion.formats.source_motion import LocalPose, SourceMotion, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.joint_mapping import map_joints
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON
from tests.fixtures.mocap import mocap_file
from tests.motion.formats.made_gltf import MadeGltf, made_avatar, random_rotations


def world(motion: SourceMotion) -> np.ndarray:
    return world_pose(motion.parents, LocalPose(motion.translation, motion.rotation)).positions


def matrix(place: np.ndarray, turn: np.ndarray, scale: np.ndarray) -> np.ndarray:
    result = np.eye(4)
    result[:3, :3] = Rotation.from_quat(turn[[1, 2, 3, 0]]).as_matrix() * scale
    result[:3, 3] = place
    return result


@pytest.mark.long
@pytest.mark.shared
def test_glb_and_its_source_bvh_have_same_motion() -> None:
    glb = parse_gltf(mocap_file("group/perfume_aachan.glb").read_bytes(), "aachan.glb")
    path = mocap_file("group/perfume_aachan.bvh")
    bvh = bvh_to_source_motion(parse_bvh(path.read_bytes(), path.name), None)
    assert (glb.frame_count, glb.header_fps, glb.unit_m, glb.up) == (2820, 30.0, 1.0, "Y")
    assert glb.warnings == ()
    assert sorted(glb.names) == sorted(bvh.names)
    order = [glb.names.index(name) for name in bvh.names]
    np.testing.assert_allclose(world(glb)[:, order], 0.01 * world(bvh), atol=5e-5)
    assert map_joints(glb) == map_joints(bvh)
    # the nodes rest in the first frame's pose: only the skin's bind pose makes the two clips one
    ours, theirs = retarget(glb, name="glb"), retarget(bvh, name="bvh", fps=30.0)
    places = [forward_kinematics(clip.root_position, clip.rotation)[0] for clip in (ours, theirs)]
    np.testing.assert_allclose(*places, atol=1e-4)


@pytest.mark.parametrize("seed", range(6))
def test_joint_positions_match_node_matrices(seed: int) -> None:
    """Ancestors, nodes between joints, scales and a matrix in place of three properties are all included."""
    rng = np.random.default_rng(seed)
    made = MadeGltf()
    frames, count = 5, 12
    parents = [-1] + [int(rng.integers(0, n)) for n in range(1, count)]
    rest = [(rng.normal(size=3), turn, np.full(3, rng.uniform(0.2, 3.0))) for turn in random_rotations(count, rng)]
    for n, (place, turn, scale) in enumerate(rest):
        if n == 1:  # as a matrix; such a node must not be animated
            written = {"matrix": matrix(place, turn, scale).T.ravel().tolist()}
        else:
            written = {
                "translation": place.tolist(),
                "rotation": turn[[1, 2, 3, 0]].tolist(),
                "scale": scale.tolist(),
            }
        made.node(f"n{n}", parents[n] if n else None, **written)
    turned = {n: random_rotations(frames, rng) for n in range(count) if n not in (1, 2)}
    moved = {n: rng.normal(size=(frames, 3)) for n in range(0, count, 3)}
    tracks = {(n, "rotation"): values for n, values in turned.items()}
    tracks |= {(n, "translation"): values for n, values in moved.items()}
    made.animate(tracks, np.arange(frames) / 25.0)
    joints = sorted({int(n) for n in rng.choice(np.arange(2, count), 6, replace=False)})
    made.json["skins"] = [{"joints": joints}]
    motion = parse_gltf(made.glb(), "made.glb")
    assert motion.header_fps == 25.0
    assert {f"n{n}" for n in joints} <= set(motion.names)
    positions = world(motion)
    for frame in range(frames):
        matrices: list[np.ndarray] = []
        for n, (place, turn, scale) in enumerate(rest):
            own = matrix(moved.get(n, [place] * frames)[frame], turned.get(n, [turn] * frames)[frame], scale)
            matrices.append(own if parents[n] < 0 else matrices[parents[n]] @ own)
        for n in joints:
            np.testing.assert_allclose(
                positions[frame, motion.names.index(f"n{n}")], matrices[n][:3, 3], atol=2e-5, rtol=1e-5
            )


def two_joints(**hand: object) -> MadeGltf:
    made = MadeGltf()
    made.node("arm")
    made.node("hand", 0, translation=[0.0, 1.0, 0.0], **hand)
    return made


def joint_rotations(data: bytes, **options: object) -> np.ndarray:
    """Rotations of the first joint, w >= 0."""
    turns = parse_gltf(data, "made.gltf", **options).rotation[:, 0]
    assert (np.sum(turns[1:] * turns[:-1], axis=1) >= 0.0).all()  # each is the nearer one of q and -q
    return positive_w(turns)


def positive_w(turns: np.ndarray) -> np.ndarray:
    return turns * np.where(turns[:, :1] < 0.0, -1.0, 1.0)


@pytest.mark.parametrize(("kind", "tolerance"), [("i1", 6e-3), ("i2", 3e-5), ("u1", 4e-3), ("u2", 2e-5)])
def test_normalized_integers_give_same_rotations(kind: str, tolerance: float) -> None:
    turns = np.abs(random_rotations(9, np.random.default_rng(1)))
    made = two_joints()
    made.animate({(0, "rotation"): turns}, np.arange(9) / 30.0)
    largest = np.iinfo(kind).max
    stored = np.round(turns[:, [1, 2, 3, 0]] * largest).astype("<" + kind)
    made.json["animations"][0]["samplers"][0]["output"] = made.accessor(stored, normalized=True)
    np.testing.assert_allclose(joint_rotations(made.glb()), turns, atol=tolerance)


def test_lowest_integer_decodes_to_minus_one() -> None:
    made = two_joints()
    made.animate({(0, "rotation"): np.array([(1.0, 0, 0, 0)])}, np.zeros(1))
    stored = np.array([(-128, 0, 0, 0)], np.int8)
    made.json["animations"][0]["samplers"][0]["output"] = made.accessor(stored, normalized=True)
    np.testing.assert_allclose(joint_rotations(made.glb())[0], (0, -1, 0, 0), atol=1e-12)


def test_interleaved_sparse_embedded_and_external_data_are_equal() -> None:
    turns = random_rotations(10, np.random.default_rng(2))
    plain = two_joints()
    plain.animate({(0, "rotation"): turns}, np.arange(10) / 30.0)
    expected = joint_rotations(plain.glb())
    np.testing.assert_allclose(expected, positive_w(turns), atol=1e-6)
    np.testing.assert_array_equal(joint_rotations(plain.text()), expected)
    files = {"motion one.bin": bytes(plain.binary)}
    np.testing.assert_array_equal(joint_rotations(plain.text("motion%20one.bin"), resolve=files.__getitem__), expected)

    interleaved = two_joints()
    interleaved.animate({(0, "rotation"): turns}, np.arange(10) / 30.0)
    rows = np.zeros(10, np.dtype([("skip", "<f4", 2), ("turn", "<f4", 4), ("more", "<u2", 2)]))
    rows["turn"] = turns[:, [1, 2, 3, 0]]
    view = interleaved.view(rows.tobytes(), byteStride=rows.itemsize)
    interleaved.json["accessors"][1].update(bufferView=view, byteOffset=8)
    np.testing.assert_array_equal(joint_rotations(interleaved.glb()), expected)

    sparse = two_joints()
    others = turns.copy()
    others[[2, 7]] = (1.0, 0.0, 0.0, 0.0)
    sparse.animate({(0, "rotation"): others}, np.arange(10) / 30.0)
    sparse.json["accessors"][1]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": sparse.view(np.array([2, 7], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": sparse.view(turns[[2, 7]][:, [1, 2, 3, 0]].astype("<f4").tobytes())},
    }
    np.testing.assert_array_equal(joint_rotations(sparse.glb()), expected)


def test_linear_keys_are_slerped_and_step_keys_held() -> None:
    turns = random_rotations(4, np.random.default_rng(3))
    times = np.array((0.0, 0.1, 0.3, 0.4))
    for way in ("LINEAR", "STEP"):
        made = two_joints()
        made.animate({(0, "rotation"): turns}, times, interpolation=way)
        made.animate({(1, "translation"): np.zeros((2, 3))}, np.array((0.0, 1.0)), name="other")
        motion = parse_gltf(made.glb(), "made.glb")
        assert motion.header_fps == 20.0  # keys on a grid of 10 a second, doubled to keep what bends between them
        assert "2 animations" in motion.warnings[0].what
        at = np.arange(motion.frame_count) / 20.0
        if way == "LINEAR":
            expected = Slerp(times, Rotation.from_quat(turns[:, [1, 2, 3, 0]]))(np.minimum(at, 0.4))
        else:
            expected = Rotation.from_quat(turns[np.searchsorted(times, at + 1e-6, side="right") - 1][:, [1, 2, 3, 0]])
        got = Rotation.from_quat(motion.rotation[:, 0][:, [1, 2, 3, 0]])
        assert (got * expected.inv()).magnitude().max() < 1e-5


def test_cubic_spline_keys_match_hermite_splines() -> None:
    rng = np.random.default_rng(4)
    times, keys = np.array((0.0, 0.2, 0.3, 0.7)), rng.normal(size=(4, 3, 3))
    made = two_joints()
    made.animate({(1, "translation"): keys.reshape(12, 3)}, times, interpolation="CUBICSPLINE")
    motion = parse_gltf(made.glb(), "made.glb")
    hand = motion.translation[:, motion.names.index("hand")]
    at = np.arange(len(hand)) / motion.header_fps
    for n in range(3):  # one spline per gap: its tangents on both sides of a key may differ
        inside = (at >= times[n] - 1e-9) & (at <= times[n + 1] + 1e-9)
        ends = np.stack((keys[n, 2], keys[n + 1, 0]))
        spline = CubicHermiteSpline(times[n : n + 2], keys[n : n + 2, 1], ends)
        assert inside.sum() >= 3
        np.testing.assert_allclose(hand[inside], spline(at[inside]), atol=1e-5)


@pytest.mark.parametrize(
    ("times", "rate"),
    [
        (np.arange(50) / 30.0, 30.0),
        (0.5 + np.arange(50) / 59.94, 59.94),
        (np.delete(np.arange(50) / 120.0, [3, 4, 17, 30]), 120.0),
        (np.array((0.0, 2.0)), 60.0),
        (np.arange(9) / 8.0, 24.0),
        (np.array((0.0, 0.013, 0.2, 0.33, 0.71)), 60.0),
        (np.zeros(1), 60.0),
        (np.arange(72_000) / 120.0, 120.0),
        (900.0 + np.delete(np.arange(20_000), slice(50, 9000, 7)) / 59.94, 59.94),
    ],
)
def test_frame_rate_follows_keys(times: np.ndarray, rate: float) -> None:
    made = two_joints()
    made.animate({(0, "rotation"): np.tile((1.0, 0, 0, 0), (len(times), 1))}, times)
    motion = parse_gltf(made.glb(), "made.glb")
    assert motion.header_fps == pytest.approx(rate, rel=1e-4)
    assert motion.frame_count == round((times[-1] - times[0]) * rate) + 1


def humanoid(kind: str, bones: dict[str, int]) -> dict[str, object]:
    if kind == "VRM":
        return {"humanoid": {"humanBones": [{"bone": bone, "node": node} for bone, node in bones.items()]}}
    return {"humanoid": {"humanBones": {bone: {"node": node} for bone, node in bones.items()}}}


@pytest.mark.parametrize("kind", ["VRM", "VRMC_vrm", "VRMC_vrm_animation"])
def test_vrm_humanoid_maps_joints_to_bones(kind: str) -> None:
    made, bones = made_avatar()
    hair = made.node("hair", bones["head"])
    made.json["skins"] = [{"joints": [*bones.values(), hair]}]
    made.json["extensions"] = {kind: humanoid(kind, bones)}
    motion = parse_gltf(made.glb(), "avatar.vrm")
    assert sorted(motion.names) == sorted(SKELETON.names)
    assert map_joints(motion) == {name: name for name in SKELETON.names}
    left = motion.translation[0, motion.names.index("leftUpperArm")]
    assert left[0] > 0.1
    at_rest = world_pose(motion.parents, LocalPose(motion.offsets[None], motion.rest_rotation[None])).positions[0]
    toes = at_rest[motion.names.index("leftToes")] - at_rest[motion.names.index("leftFoot")]
    assert toes[2] * (-1.0 if kind == "VRM" else 1.0) > 0.1  # VRM 0.x files face -z, and these were made to face +z
    clip = retarget(motion, name="avatar")
    assert clip.sample_count == 15


def test_joint_names_are_kept_without_humanoid() -> None:
    made, bones = made_avatar()
    named = {bone: made.json["nodes"][node]["name"] for bone, node in bones.items()}
    assert map_joints(parse_gltf(made.glb(), "avatar.glb")) == named  # by its shape
    for node, place in zip(made.json["nodes"][1:], ("Hips", "Spine", "Spine1"), strict=False):
        node["name"] = "mixamorig:" + place
    assert parse_gltf(made.glb(), "avatar.glb").names[:3] == ("mixamorig:Hips", "mixamorig:Spine", "mixamorig:Spine1")


@pytest.mark.parametrize("turned", [(1.0, 0.0, 0.0, 0.0), (0.5, -0.5, 0.5, 0.5), (0.0, 0.0, 1.0, 0.0)])
def test_rest_pose_comes_from_skin_in_any_space(turned: tuple[float, ...]) -> None:
    """Nodes rest in the pose of the first frame; the bind pose, in axes of its own, has the true rest pose."""
    made, bones = made_avatar(frames=5)
    for bone, node in bones.items():
        made.json["nodes"][node]["name"] = bone
    joints = list(bones.values())
    made.json["skins"] = [{"joints": joints}]
    plain = retarget(parse_gltf(made.glb(), "plain.glb"), name="plain")
    places = dict(zip(joints, rest_places(made, joints), strict=True))
    space = np.eye(4)
    space[:3, :3] = 100.0 * Rotation.from_quat(np.array(turned)[[1, 2, 3, 0]]).as_matrix()
    matrices = []
    for joint in joints:
        world = np.eye(4)
        world[:3, 3] = places[joint]
        matrices.append(np.linalg.inv(space @ world).T.ravel())
    made.json["skins"][0]["inverseBindMatrices"] = made.accessor(np.array(matrices, "<f4"))
    made.json["skins"][0]["joints"] = joints
    for joint in joints:
        made.json["nodes"][joint]["rotation"] = [0.1, 0.2, -0.3, 0.9]
    bound = parse_gltf(made.glb(), "bound.glb")
    np.testing.assert_allclose(bound.rest_rotation[1:], np.tile((1.0, 0, 0, 0), (21, 1)), atol=1e-6)
    again = retarget(bound, name="bound")
    found = [forward_kinematics(clip.root_position, clip.rotation)[0] for clip in (again, plain)]
    np.testing.assert_allclose(*found, atol=1e-4)


def rest_places(made: MadeGltf, joints: list[int]) -> list[np.ndarray]:
    """Rest positions of joints whose nodes have translations alone."""
    nodes = made.json["nodes"]
    parents = {child: n for n, node in enumerate(nodes) for child in node.get("children", [])}

    def place(node: int) -> np.ndarray:
        own = np.array(nodes[node].get("translation", (0.0, 0.0, 0.0)))
        return own + place(parents[node]) if node in parents else own

    return [place(joint) for joint in joints]


def test_leaf_bones_become_ends_and_names_become_unique() -> None:
    made = two_joints()
    made.node("hand_end", 1, translation=[0.0, 0.2, 0.0])
    made.node("hat", 1, mesh=0)
    made.node("hand", 1)
    made.json["meshes"] = [{"primitives": []}]
    made.json["skins"] = [{"joints": [0, 1, 4]}]
    made.animate({(0, "rotation"): random_rotations(3, np.random.default_rng(5))}, np.arange(3) / 30.0)
    motion = parse_gltf(made.glb(), "made.glb")
    assert motion.names == ("arm", "hand", "hand.2")
    assert motion.end_parents.tolist() == [1]
    assert motion.end_offsets.tolist() == [[0.0, 0.2, 0.0]]


def test_unusual_but_usable_content_gives_warnings() -> None:
    made = two_joints()
    made.json["nodes"][0]["scale"] = [1.0, 2.0, 1.0]
    turns = random_rotations(3, np.random.default_rng(6))
    made.animate({(0, "rotation"): turns, (1, "rotation"): turns}, np.arange(3) / 30.0, name="dance")
    made.animate({(0, "rotation"): turns}, np.arange(3) / 30.0, name="idle")
    said = [warning.what for warning in parse_gltf(made.glb(), "made.glb").warnings]
    assert len(said) == 2
    assert "'dance'" in said[0]
    assert "'idle'" in said[0]
    assert "'arm'" in said[1]
    assert "differs along its axes" in said[1]


def test_skeleton_with_most_moving_joints_is_read() -> None:
    made = MadeGltf()
    tracks, skins = {}, []
    for count in (2, 4):
        joints = [made.node(f"{count}-0")]
        joints += [made.node(f"{count}-{n}", joints[0], translation=[0, n, 0]) for n in range(1, count)]
        tracks |= {(node, "rotation"): random_rotations(3, np.random.default_rng(7)) for node in joints}
        skins.append({"joints": joints})
    made.json["skins"] = skins
    made.animate(tracks, np.arange(3) / 30.0)
    motion = parse_gltf(made.glb(), "made.glb")
    assert motion.names == ("4-0", "4-1", "4-2", "4-3")
    assert "2 skeletons move" in motion.warnings[0].what
