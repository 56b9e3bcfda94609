"""Generated character files: the body as glTF, GLB or VRM, with other poses, proportions, units and names."""

import io
import json
import struct
from dataclasses import dataclass, field

import numpy as np
from PIL import Image

from live.motion import quaternion
from live.motion.skeleton import SKELETON
from live.render.body.body_lookup import build_figure
from live.render.body.body_mesh import LIGHT
from live.render.body.drawn_joints import ANCHORS

MIXAMO = {
    "hips": "Hips", "spine": "Spine", "chest": "Spine1", "upperChest": "Spine2", "neck": "Neck", "head": "Head",
    "Shoulder": "Shoulder", "UpperArm": "Arm", "LowerArm": "ForeArm", "Hand": "Hand", "UpperLeg": "UpLeg",
    "LowerLeg": "Leg", "Foot": "Foot", "Toes": "ToeBase",
}  # fmt: skip
UNREAL = {
    "hips": "pelvis", "spine": "spine_01", "chest": "spine_02", "upperChest": "spine_03", "neck": "neck_01",
    "head": "head", "Shoulder": "clavicle", "UpperArm": "upperarm", "LowerArm": "lowerarm", "Hand": "hand",
    "UpperLeg": "thigh", "LowerLeg": "calf", "Foot": "foot", "Toes": "ball",
}  # fmt: skip
RIGIFY = {
    "hips": "DEF-spine", "spine": "DEF-spine.001", "chest": "DEF-spine.002", "upperChest": "DEF-spine.003",
    "neck": "DEF-spine.004", "head": "DEF-spine.006", "Shoulder": "DEF-shoulder", "UpperArm": "DEF-upper_arm",
    "LowerArm": "DEF-forearm", "Hand": "DEF-hand", "UpperLeg": "DEF-thigh", "LowerLeg": "DEF-shin",
    "Foot": "DEF-foot", "Toes": "DEF-toe",
}  # fmt: skip


def _split(name):
    for side in ("left", "right"):
        if name.startswith(side):
            return side, name.removeprefix(side)
    return "", name


def mixamo(name):
    side, joint = _split(name)
    return "mixamorig:" + side.capitalize() + MIXAMO[joint]


def unreal(name):
    side, joint = _split(name)
    return UNREAL[joint] + (f"_{side[0]}" if side else "")


def rigify(name):
    side, joint = _split(name)
    return RIGIFY[joint] + (f".{side[0].upper()}" if side else "")


def striped_image(side=64):
    """A PNG with a different colour at every height (skin, striped shirt, dark legs), and green on the left."""
    image = np.zeros((side, side, 3), np.uint8)
    for row in range(side):
        height = 1.0 - row / side
        image[row] = (225, 170, 140) if height > 0.83 else (200, 40, 40) if int(height * 24) % 2 else (240, 240, 230)
        if height < 0.5:
            image[row] = (40, 50, 110)
    image[:, side // 2 + side // 16 :, 1] = np.maximum(image[:, side // 2 + side // 16 :, 1], 120)
    out = io.BytesIO()
    Image.fromarray(image).save(out, "PNG")
    return out.getvalue()


@dataclass
class Figure:
    """Options of a generated character; the defaults are the generated body unchanged."""

    names: object = str
    arms_down: float = 0.0
    """How far the arms hang in the rest pose [degrees]: an A-pose has 45."""
    lengths: dict = field(default_factory=dict)
    """Factor of a bone's length by the joint at its end, without its side: {"LowerLeg": 1.2}."""
    unit: float = 1.0
    """Units a metre: 100 for centimetres."""
    turn: float = 0.0
    """Turned about the upright axis [degrees]."""
    without: tuple = ()
    """Joints that it lacks; their skin goes with the joint above."""
    vrm: str = ""
    image: bytes | None = None
    colour: tuple = (1.0, 1.0, 1.0, 1.0)
    level: int = LIGHT
    double: bool = False


SKELETAL = np.concatenate([np.arange(len(SKELETON.names)), ANCHORS])
"""The joint of the skeleton for each drawn joint."""


def body_of(figure):
    """Mesh, positions, normals and joint positions of the figure in its rest pose; weights (V, J)."""
    mesh = build_figure(figure.level)
    rest = SKELETON.rest_positions().astype(float)
    turn = np.tile((1.0, 0.0, 0.0, 0.0), (len(rest), 1))
    for joint, name in enumerate(SKELETON.names):
        side, bone = _split(name)
        if bone in ("UpperArm", "LowerArm", "Hand"):
            way = -1.0 if side == "left" else 1.0
            turn[joint] = quaternion.from_axis_angle(np.array([0, 0, way]), np.radians(figure.arms_down))
    place = rest.copy()
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            factor = figure.lengths.get(_split(SKELETON.names[joint])[1], 1.0)
            place[joint] = place[parent] + factor * quaternion.rotate(turn[parent], rest[joint] - rest[parent])
    weight = np.zeros((len(mesh.position), len(rest)))
    np.add.at(weight, (np.arange(len(weight))[:, None], SKELETAL[mesh.joint]), mesh.weight)
    position = np.zeros(mesh.position.shape)
    normal = np.zeros(mesh.position.shape)
    for joint in range(len(rest)):
        own = weight[:, joint : joint + 1]
        scaled = mesh.position - rest[joint]
        for child in np.flatnonzero(SKELETON.parents == joint):
            factor = figure.lengths.get(_split(SKELETON.names[child])[1], 1.0)
            along = (rest[child] - rest[joint]) / np.linalg.norm(rest[child] - rest[joint])
            if factor != 1.0:
                scaled = scaled + (factor - 1.0) * (scaled @ along)[:, None] * along
        position += own * (place[joint] + quaternion.rotate(turn[joint], scaled))
        normal += own * quaternion.rotate(turn[joint], mesh.normal)
    return mesh, position, quaternion.unit(normal), place, weight


def _strongest_weights(weight):
    order = np.argsort(-weight, axis=1)[:, :4]
    values = np.take_along_axis(weight, order, axis=1)
    return order.astype(np.uint8), (values / values.sum(axis=1, keepdims=True)).astype(np.float32)


def parents_of(figure):
    """Parent of each joint that the figure has, by name."""
    result = {}
    for joint, name in enumerate(SKELETON.names):
        if name in figure.without:
            continue
        parent = SKELETON.parents[joint]
        while parent >= 0 and SKELETON.names[parent] in figure.without:
            parent = SKELETON.parents[parent]
        result[name] = None if parent < 0 else SKELETON.names[parent]
    return result


def document(figure):
    """The JSON and the binary chunk of a figure."""
    mesh, position, normal, place, weight = body_of(figure)
    half = np.radians(figure.turn)
    axes = np.array([[np.cos(half), 0, np.sin(half)], [0, 1, 0], [-np.sin(half), 0, np.cos(half)]])
    position, normal, place = ((each @ axes.T) for each in (position, normal, place))
    position, place = position * figure.unit, place * figure.unit
    parents = parents_of(figure)
    kept = list(parents)
    for joint, name in enumerate(SKELETON.names):
        if name in figure.without:
            parent = joint
            while SKELETON.names[parent] in figure.without:
                parent = int(SKELETON.parents[parent])
            weight[:, parent] += weight[:, joint]
            weight[:, joint] = 0.0
    weight = weight[:, [SKELETON.index(name) for name in kept]]
    joints, weights = _strongest_weights(weight)
    places = {name: place[SKELETON.index(name)] for name in kept}
    binds = np.tile(np.eye(4), (len(kept), 1, 1))
    binds[:, :3, 3] = [-places[name] for name in kept]
    uv = np.column_stack([mesh.position[:, 0] / 1.8 + 0.5, 1.0 - mesh.position[:, 1] / 1.75])
    chunk, views, accessors = bytearray(), [], []

    def add(array, kind, component):
        views.append({"buffer": 0, "byteOffset": len(chunk), "byteLength": array.nbytes})
        chunk.extend(np.ascontiguousarray(array).tobytes())
        chunk.extend(bytes(-len(chunk) % 4))
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind})
        return len(accessors) - 1

    attributes = {
        "POSITION": add(position.astype(np.float32), "VEC3", 5126),
        "NORMAL": add(normal.astype(np.float32), "VEC3", 5126),
        "TEXCOORD_0": add(uv.astype(np.float32), "VEC2", 5126),
        "JOINTS_0": add(joints, "VEC4", 5121),
        "WEIGHTS_0": add(weights, "VEC4", 5126),
    }
    indices = add(mesh.triangle.astype(np.uint32).reshape(-1, 1), "SCALAR", 5125)
    inverse = add(binds.transpose(0, 2, 1).reshape(-1, 16).astype(np.float32), "MAT4", 5126)
    nodes = []
    for name in kept:
        parent = parents[name]
        at = places[name] - (0.0 if parent is None else places[parent])
        children = [number for number, each in enumerate(kept) if parents[each] == name]
        nodes.append({"name": figure.names(name), "translation": [float(x) for x in at]})
        if children:
            nodes[-1]["children"] = children
    nodes.append({"name": "figure", "mesh": 0, "skin": 0})
    pbr = {"baseColorFactor": list(figure.colour), "metallicFactor": 0.0, "roughnessFactor": 0.8}
    root = {
        "asset": {"version": "2.0", "generator": "tests", "copyright": "nobody"},
        "scene": 0,
        "scenes": [{"nodes": [0, len(kept)]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "skins": [{"joints": list(range(len(kept))), "inverseBindMatrices": inverse}],
        "materials": [{"name": "cloth", "doubleSided": figure.double, "pbrMetallicRoughness": pbr}],
    }
    if figure.image is not None:
        views.append({"buffer": 0, "byteOffset": len(chunk), "byteLength": len(figure.image)})
        chunk.extend(figure.image)
        chunk.extend(bytes(-len(chunk) % 4))
        root["images"] = [{"bufferView": len(views) - 1, "mimeType": "image/png"}]
        root["textures"] = [{"source": 0}]
        pbr["baseColorTexture"] = {"index": 0}
    root |= {"accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(chunk)}]}
    if figure.vrm:
        root["extensions"] = _vrm(figure, kept)
        root["extensionsUsed"] = list(root["extensions"])
    return root, bytes(chunk)


def _vrm(figure, kept):
    if figure.vrm == "1.0":
        bones = {name: {"node": number} for number, name in enumerate(kept)}
        meta = {"name": "Anna", "authors": ["somebody"], "licenseUrl": "https://vrm.dev/licenses/1.0/"}
        return {"VRMC_vrm": {"specVersion": "1.0", "meta": meta, "humanoid": {"humanBones": bones}}}
    bones = [{"bone": name, "node": number} for number, name in enumerate(kept)]
    meta = {"title": "Anna", "author": "somebody", "licenseName": "CC0", "commercialUssageName": "Allow"}
    return {"VRM": {"meta": meta, "humanoid": {"humanBones": bones}}}


def glb(root, chunk):
    """A GLB file of a JSON document and its binary chunk."""
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(chunk)
    head = struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<II", len(text), 0x4E4F534A)
    return head + text + struct.pack("<II", len(chunk), 0x004E4942) + chunk


def glb_of(**wanted):
    """The GLB file of a figure."""
    return glb(*document(Figure(**wanted)))
