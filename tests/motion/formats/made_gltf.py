"""glTF files for tests, built without the engine's writer: nodes, skins and animations as the test needs."""

import base64
import json
import struct
from typing import Any

import numpy as np

KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


class MadeGltf:
    """A document under construction; `json` may be changed freely before it is packed."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "nodes": [],
            "animations": [],
            "accessors": [],
            "bufferViews": [],
        }
        self.binary = bytearray()

    def node(self, name: str, parent: int | None = None, **properties: Any) -> int:
        """Add a node below another; the properties are written as they are given."""
        self.json["nodes"].append({"name": name, **properties})
        index = len(self.json["nodes"]) - 1
        if parent is not None:
            self.json["nodes"][parent].setdefault("children", []).append(index)
        return index

    def view(self, data: bytes, **properties: Any) -> int:
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **properties}
        )
        self.binary += data + bytes(-len(data) % 4)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array: np.ndarray, **properties: Any) -> int:
        """An accessor of a tightly packed array (n,) or (n, width)."""
        table = np.ascontiguousarray(array.reshape(len(array), -1))
        self.json["accessors"].append(
            {
                "bufferView": self.view(table.tobytes()),
                "componentType": COMPONENTS[table.dtype.str[1:]],
                "count": len(table),
                "type": KINDS[table.shape[1]],
                **properties,
            }
        )
        return len(self.json["accessors"]) - 1

    def animate(
        self,
        tracks: dict[tuple[int, str], np.ndarray],
        times: np.ndarray,
        *,
        interpolation: str = "LINEAR",
        name: str = "dance",
    ) -> None:
        """One animation; rotations (T, 4) as (w, x, y, z), with three values per key for CUBICSPLINE."""
        input_index = self.accessor(times.astype("<f4"))
        samplers, channels = [], []
        for (node, path), values in tracks.items():
            if path == "rotation":
                values = values[:, [1, 2, 3, 0]]
            output = self.accessor(values.astype("<f4"))
            samplers.append({"input": input_index, "output": output, "interpolation": interpolation})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": path}})
        self.json["animations"].append({"name": name, "samplers": samplers, "channels": channels})

    def text(self, uri: str | None = None) -> bytes:
        """A .gltf file: its buffer in a data URI, or beside it under `uri`."""
        data = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.binary)).decode()
        buffers = [{"byteLength": len(self.binary), "uri": data if uri is None else uri}]
        return json.dumps({**self.json, "buffers": buffers}).encode()

    def glb(self) -> bytes:
        """A .glb file."""
        document = {"buffers": [{"byteLength": len(self.binary)}], **self.json}
        return pack_glb(json.dumps(document).encode(), bytes(self.binary))


def pack_glb(text: bytes, binary: bytes) -> bytes:
    """Header and two chunks."""
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def random_rotations(count: int, rng: np.random.Generator) -> np.ndarray:
    """Unit quaternions (count, 4)."""
    turns = rng.normal(size=(count, 4))
    return turns / np.linalg.norm(turns, axis=1, keepdims=True)


BONES = (
    ("hips", ""), ("spine", "hips"), ("chest", "spine"), ("upperChest", "chest"), ("neck", "upperChest"),
    ("head", "neck"), ("leftShoulder", "upperChest"), ("leftUpperArm", "leftShoulder"),
    ("leftLowerArm", "leftUpperArm"), ("leftHand", "leftLowerArm"), ("rightShoulder", "upperChest"),
    ("rightUpperArm", "rightShoulder"), ("rightLowerArm", "rightUpperArm"), ("rightHand", "rightLowerArm"),
    ("leftUpperLeg", "hips"), ("leftLowerLeg", "leftUpperLeg"), ("leftFoot", "leftLowerLeg"),
    ("leftToes", "leftFoot"), ("rightUpperLeg", "hips"), ("rightLowerLeg", "rightUpperLeg"),
    ("rightFoot", "rightLowerLeg"), ("rightToes", "rightFoot"),
)  # fmt: skip
PLACES = {
    "hips": (0, 1, 0), "spine": (0, 0.1, 0), "chest": (0, 0.12, 0), "upperChest": (0, 0.12, 0), "neck": (0, 0.15, 0),
    "head": (0, 0.1, 0), "Shoulder": (0.03, 0.1, 0), "UpperArm": (0.13, 0, 0), "LowerArm": (0.26, 0, 0),
    "Hand": (0.25, 0, 0), "UpperLeg": (0.09, -0.05, 0), "LowerLeg": (0, -0.43, 0), "Foot": (0, -0.42, 0),
    "Toes": (0, -0.06, 0.13),
}  # fmt: skip


def made_avatar(seed: int = 3, frames: int = 8, names: str = "node-{}") -> tuple[MadeGltf, dict[str, int]]:
    """A dancer whose nodes have meaningless names, with a moving spine and limbs; node of each humanoid bone."""
    rng = np.random.default_rng(seed)
    made = MadeGltf()
    top = made.node("Root")
    bones: dict[str, int] = {}
    for number, (bone, parent) in enumerate(BONES):
        stem = bone.removeprefix("left").removeprefix("right")
        x, y, z = PLACES[stem]
        place = [-x if bone.startswith("right") else x, y, z]
        bones[bone] = made.node(names.format(number), bones.get(parent, top), translation=place)
    tracks = {}
    for bone, node in bones.items():
        turns = np.concatenate((np.ones((frames, 1)), 0.2 * rng.normal(size=(frames, 3))), axis=1)
        tracks[node, "rotation"] = turns / np.linalg.norm(turns, axis=1, keepdims=True)
        if bone == "hips":
            tracks[node, "translation"] = np.array((0.0, 1.0, 0.0)) + 0.1 * rng.normal(size=(frames, 3))
    made.animate(tracks, np.arange(frames) / 30.0)
    return made, bones
