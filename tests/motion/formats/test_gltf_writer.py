"""Tests of the GLB writer: read back by pygltflib, by matrices and by the engine; the rules of glTF."""

import json
import struct
from typing import Any

import numpy as np
import pygltflib
import pytest
from scipy.spatial.transform import Rotation

from live.motion.clip import Clip
from live.motion.formats.bone_mesh import bone_mesh
from live.motion.formats.gltf_reader import parse_gltf
from live.motion.formats.gltf_writer import write_glb
from live.motion.formats.source_motion import LocalPose, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import BODY_HEIGHT, JOINT_COUNT, SKELETON
from tests.fixtures.mocap import mocap_file
from tests.motion.test_clip import made_clip

TYPES = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
DTYPES = {5121: "<u1", 5123: "<u2", 5126: "<f4"}


def positions(clip: Clip) -> np.ndarray:
    return forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))[0]


def document(data: bytes) -> tuple[dict[str, Any], bytes]:
    """JSON and binary chunk, parsed by hand."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    binary_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    assert 28 + size + binary_size == len(data)
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def array(content: dict[str, Any], binary: bytes, index: int) -> np.ndarray:
    accessor = content["accessors"][index]
    view = content["bufferViews"][accessor["bufferView"]]
    width, dtype = TYPES[accessor["type"]], np.dtype(DTYPES[accessor["componentType"]])
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.frombuffer(binary, dtype, accessor["count"] * width, start).reshape(-1, width)


def matrices_at(content: dict[str, Any], binary: bytes, frame: int) -> list[np.ndarray]:
    """World matrix of every node at a key, by 4 x 4 products alone."""
    local = []
    for node in content["nodes"]:
        assert "matrix" not in node
        local.append(
            {"translation": node.get("translation", [0, 0, 0]), "rotation": node.get("rotation", [0, 0, 0, 1])}
        )
    animation = content["animations"][0]
    for channel in animation["channels"]:
        values = array(content, binary, animation["samplers"][channel["sampler"]]["output"])
        local[channel["target"]["node"]][channel["target"]["path"]] = values[frame]
    parents = {child: n for n, node in enumerate(content["nodes"]) for child in node.get("children", [])}
    world: dict[int, np.ndarray] = {}

    def of(node: int) -> np.ndarray:
        if node not in world:
            own = np.eye(4)
            own[:3, :3] = Rotation.from_quat(local[node]["rotation"]).as_matrix()
            own[:3, 3] = local[node]["translation"]
            world[node] = of(parents[node]) @ own if node in parents else own
        return world[node]

    return [of(n) for n in range(len(content["nodes"]))]


def test_node_matrices_give_joint_positions() -> None:
    clip = made_clip(12, 60.0)
    content, binary = document(write_glb(clip))
    expected = positions(clip)
    names = [node["name"] for node in content["nodes"]]
    for frame in range(12):
        world = matrices_at(content, binary, frame)
        found = np.array([world[names.index(name)][:3, 3] for name in SKELETON.names])
        np.testing.assert_allclose(found, expected[frame], atol=1e-5)


def test_skin_leaves_mesh_unchanged_in_rest_pose() -> None:
    clip = Clip(
        "rest",
        SKELETON.offsets[:1].copy(),
        np.tile(np.float32((1, 0, 0, 0)), (1, JOINT_COUNT, 1)),
        60.0,
        np.ones((1, 2), np.bool_),
    )
    content, binary = document(write_glb(clip))
    world = matrices_at(content, binary, 0)
    skin = content["skins"][0]
    bind = array(content, binary, skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    for joint, matrix in zip(skin["joints"], bind, strict=True):
        np.testing.assert_allclose(world[joint] @ matrix, np.eye(4), atol=1e-5)
    corners = array(content, binary, content["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
    assert corners[:, 1].max() == pytest.approx(BODY_HEIGHT, abs=1e-3)
    assert corners[:, 1].min() > 0.0


def test_document_follows_gltf_rules() -> None:
    """As in the Khronos validator: bounds, alignment, targets, ascending times, one root, unit quaternions."""
    clip = made_clip(50, 60.0)
    content, binary = document(write_glb(clip))
    assert content["asset"] == {"version": "2.0", "generator": "ChoreoGraphics Live"}
    assert content["buffers"][0]["byteLength"] <= len(binary) < content["buffers"][0]["byteLength"] + 4
    end = 0
    for view in content["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] >= end
        end = view["byteOffset"] + view["byteLength"]
    assert end <= content["buffers"][0]["byteLength"]
    for index, accessor in enumerate(content["accessors"]):
        values = array(content, binary, index)
        assert values.nbytes <= content["bufferViews"][accessor["bufferView"]]["byteLength"]
        if "min" in accessor:
            assert accessor["min"] == values.min(axis=0).tolist()
            assert accessor["max"] == values.max(axis=0).tolist()
    primitive = content["meshes"][0]["primitives"][0]
    attributes = {name: content["accessors"][n] for name, n in primitive["attributes"].items()}
    assert "min" in attributes["POSITION"]
    assert len({accessor["count"] for accessor in attributes.values()}) == 1
    targets = [content["bufferViews"][accessor["bufferView"]]["target"] for accessor in attributes.values()]
    assert set(targets) == {34962}
    indices = content["accessors"][primitive["indices"]]
    assert content["bufferViews"][indices["bufferView"]]["target"] == 34963
    assert array(content, binary, primitive["indices"]).max() < attributes["POSITION"]["count"]
    np.testing.assert_allclose(array(content, binary, primitive["attributes"]["WEIGHTS_0"]).sum(axis=1), 1.0)
    assert array(content, binary, primitive["attributes"]["JOINTS_0"]).max() < len(content["skins"][0]["joints"])
    animation = content["animations"][0]
    times = array(content, binary, animation["samplers"][0]["input"])[:, 0]
    assert "min" in content["accessors"][animation["samplers"][0]["input"]]
    assert times[0] == 0.0
    assert (np.diff(times) > 0.0).all()
    aims = [(channel["target"]["node"], channel["target"]["path"]) for channel in animation["channels"]]
    assert len(set(aims)) == len(aims) == JOINT_COUNT + 1
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        values = array(content, binary, sampler["output"])
        assert len(values) == len(times)
        if channel["target"]["path"] == "rotation":
            np.testing.assert_allclose(np.linalg.norm(values, axis=1), 1.0, atol=1e-6)
            assert (np.sum(values[1:] * values[:-1], axis=1) >= 0.0).all()
    children = [child for node in content["nodes"] for child in node.get("children", [])]
    assert len(set(children)) == len(children)
    assert sorted(children + content["scenes"][0]["nodes"]) == list(range(len(content["nodes"])))
    assert all(node["children"] for node in content["nodes"] if "children" in node)
    assert content["nodes"][content["skins"][0]["skeleton"]]["children"] == [0]
    figure = next(node for node in content["nodes"] if "mesh" in node)
    assert figure["skin"] == 0
    assert content["nodes"].index(figure) in content["scenes"][0]["nodes"]


def test_pygltflib_reads_clip() -> None:
    read = pygltflib.GLTF2().load_from_bytes(write_glb(made_clip(5, 60.0)))
    assert read.asset.copyright is None
    assert [node.name for node in read.nodes][:JOINT_COUNT] == list(SKELETON.names)
    assert read.animations[0].name == "made"
    assert read.skins[0].joints == list(range(JOINT_COUNT))


def test_engine_reads_clip_back_unchanged() -> None:
    clip = made_clip(30, 60.0)
    motion = parse_gltf(write_glb(clip), "written.glb")
    assert (motion.names, motion.frame_count, motion.header_fps) == (SKELETON.names, 30, 60.0)
    assert motion.warnings == ()
    found = world_pose(motion.parents, LocalPose(motion.translation, motion.rotation)).positions
    np.testing.assert_allclose(found, positions(clip), atol=1e-5)


@pytest.mark.shared
def test_recording_survives_round_trip() -> None:
    clip = retarget(parse_gltf(mocap_file("group/perfume_aachan.glb").read_bytes(), "aachan.glb"), name="aachan")
    again = retarget(parse_gltf(write_glb(clip), "written.glb"), name="again")
    np.testing.assert_allclose(positions(again), positions(clip), atol=1e-5)


def test_rate_is_sixty_or_clip_rate() -> None:
    clip = made_clip(121, 120.0)
    assert parse_gltf(write_glb(clip), "written.glb").header_fps == 60.0
    motion = parse_gltf(write_glb(clip, rate=None), "written.glb")
    assert (motion.header_fps, motion.frame_count) == (120.0, 121)


def test_mesh_faces_point_outward() -> None:
    figure = bone_mesh()
    corners = figure.positions.reshape(-1, 8, 3, 3).astype(np.float64)
    middle = corners.mean(axis=(1, 2))[:, None]
    outwards = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    assert (np.sum((corners.mean(axis=2) - middle) * outwards, axis=-1) > 0.0).all()
    normals = figure.normals.reshape(-1, 8, 3, 3)[:, :, 0]
    assert (np.sum(normals * outwards, axis=-1) > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(figure.normals, axis=1), 1.0, atol=1e-6)
    mirrored = figure.positions * np.float32((-1, 1, 1))
    gaps = np.abs(figure.positions[None] - mirrored[:, None]).max(axis=-1).min(axis=1)
    assert gaps.max() < 1e-5
