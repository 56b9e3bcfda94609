"""Reader for characters in glTF, GLB and VRM files, with size limits; all errors are MotionFileErrors."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion import quaternion
from live.motion.formats.file_error import MotionFileError, quoted
from live.motion.formats.gltf_accessors import AccessorReader, Resolve
from live.motion.formats.gltf_document import GltfFile, JsonObject, open_gltf
from live.motion.formats.gltf_skeleton import NodeTree
from live.render.characters.materials import PLAIN, material_transform, read_materials
from live.render.characters.model import TRIANGLE_LIMIT, Model, Part
from live.render.characters.spring_reader import springs_of
from live.render.characters.vrm_face import expressions_of
from live.render.characters.vrm_licence import bones_of, first_person, kind_of, licence_of

BYTE_LIMIT: Final = 100_000_000
"""Maximum size of a character's file, or of one that it refers to [bytes]."""
IMAGE_LIMIT: Final = 64
_INDEX_LIMIT: Final = 1 << 40
_TRIANGLES: Final = 4
_SMALLER: Final = "export it with fewer triangles (Blender: a Decimate modifier on each mesh) and images of 1024 pixels"


_UNCOMPRESSED: Final = (
    "export it without compression (Blender: Data > Compression off in the glTF export; images as PNG or JPEG)"
)
_WITH_ARMATURE: Final = (
    "export it with its armature (Blender: select mesh and armature, glTF export with Data > Skinning; the mesh needs "
    "an Armature modifier)"
)
_BLENDER: Final = "open it in Blender, then File > Export > glTF 2.0 (.glb) with Skinning and Shape Keys"
_OTHER_FORMATS: Final[tuple[tuple[bytes, str, str], ...]] = (
    (b"Kaydara FBX", "an FBX file", _BLENDER.replace("open it in Blender", "in Blender File > Import > FBX")),
    (b"; FBX", "an FBX file", _BLENDER.replace("open it in Blender", "in Blender File > Import > FBX")),
    (b"BLENDER", "a Blender file", _BLENDER),
    (b"\x28\xb5\x2f\xfd", "a compressed Blender file", _BLENDER),
    (b"PK\x03\x04", "a ZIP archive", "unpack it, and name the .glb, .gltf or .vrm in it"),
    (b"Pmx ", "an MMD model (PMX)", "convert it to VRM, for example with the VRM add-on for Blender"),
    (b"#usda", "a USD file", _BLENDER.replace("open it in Blender", "in Blender File > Import > USD")),
    (b"PXR-USDC", "a USD file", _BLENDER.replace("open it in Blender", "in Blender File > Import > USD")),
    (b"version https://git-lfs", "only a pointer of Git LFS, not the file itself", "fetch it: git lfs pull"),
    (b"<?xml", "an XML file (COLLADA?)", _BLENDER.replace("open it in Blender", "import it into Blender")),
    (b"<!DOCTYPE", "a web page, not the file itself", "download it again"),
    (b"<html", "a web page, not the file itself", "download it again"),
)
"""How files of other formats begin, what they are, and what to do."""


def _refuse_other_formats(data: bytes, file: str) -> None:
    begin = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    for magic, words, remedy in _OTHER_FORMATS:
        if begin.lower().startswith(magic.lower()):
            raise MotionFileError(file, None, f"this is {words}; characters are read from .glb, .gltf and .vrm", remedy)


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a character's file; MotionFileError if it is missing, not a file, or too large."""
    try:
        if not path.is_file():
            raise MotionFileError(str(path), None, "there is no such file", "a .glb, .gltf or .vrm file expected")
        size = path.stat().st_size
        if size > BYTE_LIMIT:
            words = f"{size / 1e6:.0f} MB; {BYTE_LIMIT / 1e6:.0f} MB at most are read"
            raise MotionFileError(str(path), None, words, _SMALLER)
        return path.read_bytes()
    except OSError as error:
        words = f"cannot be read: {error.strerror}"
        raise MotionFileError(str(path), None, words, "a readable file expected") from None


def read_model(path: Path) -> Model:
    """Return the character in a .glb, .gltf or .vrm file, which may only refer to files below its folder."""
    return parse_model(read_bytes(path), str(path), file_resolver(path))


def file_resolver(path: Path) -> Resolve:
    """Return a function that reads the files that a file refers to, if they lie below its folder."""

    def beside(name: str) -> bytes:
        found, folder = (path.parent / name).resolve(), path.parent.resolve()
        if not found.is_relative_to(folder):
            raise MotionFileError(str(path), None, f"{quoted(name)} leads out of its folder", "export it as .glb")
        if not found.is_file():
            raise MotionFileError(str(path), None, f"{quoted(name)} is missing", f"put it into {folder}")
        return read_bytes(found)

    return beside


def parse_model(data: bytes, file: str, resolve: Resolve | None = None) -> Model:
    """Return the character in a file's bytes; `resolve` returns the files that it refers to."""
    _refuse_other_formats(data, file)
    try:
        return ModelReader(open_gltf(data, file), resolve).read()
    except MemoryError:
        raise MotionFileError(file, None, "not enough memory", _SMALLER) from None


class ModelReader:
    """Reader of one character; `live.render.media.set_model` reads set pieces with it."""

    def __init__(self, gltf: GltfFile, resolve: Resolve | None) -> None:
        self._gltf = gltf
        self._root = JsonObject(gltf.json, "", gltf.file)
        for each in self._root.texts("extensionsRequired"):
            if each in ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu"):
                raise self._root.error("", f"needs {each}", _UNCOMPRESSED)
        self._nodes = NodeTree(self._root)
        self._accessors = AccessorReader(gltf, resolve, files=IMAGE_LIMIT + 4, folders=True)
        self._matrix = self._matrices()
        self._materials = read_materials(self._root)
        self._expressions = expressions_of(self._root, self._nodes)
        self._shapes = self._expressions.by_mesh()
        self._joints: set[int] = set()
        self._notes: list[str] = []
        self._triangles = 0

    def read(self) -> Model:
        if not self._root.length("skins"):
            raise self._root.error("", "has no skin, so it cannot be animated", _WITH_ARMATURE)
        parts = list(self._parts())
        if not parts:
            raise self._root.error("meshes", "hold no triangles that move with a skin", "export mesh and armature")
        return self._model(parts)

    def _model(self, parts: list[Part]) -> Model:
        """Return the file's content with these parts."""
        used = set().union(*(self._materials[part.material].images for part in parts))
        images = self._root.length("images")
        if images > IMAGE_LIMIT:
            raise self._root.error("images", f"are {images}", f"at most {IMAGE_LIMIT} expected")
        return Model(
            file=self._gltf.file,
            size=self._gltf.size,
            kind=kind_of(self._root),
            names=tuple(self._nodes.name(node) for node in range(self._nodes.count)),
            parents=tuple(self._nodes.parents),
            order=tuple(self._nodes.order),
            node_position=self._matrix[:, :3, 3].copy(),
            node_matrix=self._matrix,
            joints=frozenset(self._joints),
            bones=bones_of(self._root, self._nodes),
            parts=tuple(parts),
            materials=tuple(self._materials),
            images=tuple(self._image(number) if number in used else None for number in range(images)),
            springs=springs_of(self._root, self._nodes),
            expressions=self._expressions,
            licence=licence_of(self._root),
            notes=tuple(dict.fromkeys(self._notes)),
        )

    def _image(self, number: int) -> bytes:
        return bytes(self._accessors.content(self._root.element("images", number)))

    def _matrices(self) -> Float64:
        """Return matrices from each node's space to the world in the rest pose, (N, 4, 4)."""
        matrix = np.tile(np.eye(4), (self._nodes.count, 1, 1))
        for node in self._nodes.order:
            rest = self._nodes.rest(node)
            axes = np.stack([quaternion.rotate(rest.rotation, axis) for axis in np.eye(3)], axis=1)
            matrix[node, :3, :3], matrix[node, :3, 3] = axes * rest.scale, rest.translation
            parent = self._nodes.parents[node]
            if parent >= 0:
                matrix[node] = matrix[parent] @ matrix[node]
        return matrix

    def _parts(self) -> Iterator[Part]:
        own_meshes, own_nodes = first_person(self._root, self._nodes)
        skins = list(self._root.elements("skins"))
        for skin in skins:
            self._joints.update(skin.integers("joints", below=self._nodes.count))
        for node in self._nodes.order:
            place = self._nodes.json_object(node)
            if not place.has("mesh"):
                continue
            mesh = place.integer("mesh", below=self._root.length("meshes"))
            if mesh in own_meshes or node in own_nodes:
                self._notes.append("meshes for the first-person view are left out")
                continue
            own = skins[place.integer("skin", below=len(skins))] if place.has("skin") else None
            if own is None and not self._is_under_joint(node):
                self._notes.append(f"{self._nodes.name(node)!r} is attached to no bone and is left out")
                continue
            for primitive in self._root.element("meshes", mesh).elements("primitives"):
                part = self._part(primitive, node, own, mesh)
                if part is not None:
                    yield part

    def _is_under_joint(self, node: int) -> bool:
        while node >= 0 and node not in self._joints:
            node = self._nodes.parents[node]
        return node >= 0

    def _part(self, primitive: JsonObject, node: int, skin: JsonObject | None, mesh: int) -> Part | None:
        if primitive.integer("mode", _TRIANGLES, below=7) != _TRIANGLES:
            self._notes.append("points, lines, strips and fans are left out")
            return None
        if primitive.has("extensions") and primitive.object("extensions").has("KHR_draco_mesh_compression"):
            raise primitive.error("", "is compressed (Draco)", _UNCOMPRESSED)
        attributes = primitive.object("attributes")
        position = self._accessors.read(attributes.integer("POSITION", below=_INDEX_LIMIT), "VEC3")
        triangle = self._triangles_of(primitive, len(position))
        if not len(triangle):
            return None
        number, uv = self._material_of(primitive, attributes, len(position))
        normal = self._normals(attributes, position, triangle)
        if skin is None:
            nodes, weight = np.full((len(position), 1), node, np.int64), np.ones((len(position), 1))
            moved = np.broadcast_to(self._matrix[node], (len(position), 4, 4))
        else:
            nodes, weight, moved = self._skinning(attributes, skin, len(position))
        place = np.einsum("vij,vj->vi", moved[:, :3, :3], position) + moved[:, :3, 3]
        turned = np.einsum("vij,vj->vi", moved[:, :3, :3], normal)
        morphs = self._morphs(primitive, mesh, moved[:, :3, :3])
        return Part(place, np.asarray(quaternion.unit(turned)), uv, nodes, weight, triangle, number, morphs)

    def _morphs(self, primitive: JsonObject, mesh: int, moved: Float64) -> dict[int, tuple[Float64, Float64]]:
        """Return the blend shapes that faces move, by channel: sums of the file's, (V, 3) for positions and normals."""
        wanted = self._shapes.get(mesh, {})
        found: dict[int, tuple[Any, Any]] = {}
        for number in sorted(set(wanted) & set(range(primitive.length("targets")))):
            target = primitive.element("targets", number)
            shifts = [self._shift(target, key, len(moved)) for key in ("POSITION", "NORMAL")]
            turned = [np.einsum("vij,vj->vi", moved, shift) for shift in shifts]
            for channel, weight in wanted[number]:
                before = found.get(channel, (0.0, 0.0))
                found[channel] = before[0] + weight * turned[0], before[1] + weight * turned[1]
        return {channel: shift for channel, shift in found.items() if np.abs(shift[0]).max(initial=0.0) > 0.0}

    def _shift(self, target: JsonObject, key: str, count: int) -> Float64:
        if not target.has(key):
            return np.zeros((count, 3))
        shift = self._accessors.read(target.integer(key, below=_INDEX_LIMIT), "VEC3")
        if len(shift) != count:
            raise target.error(key, f"has {len(shift)} elements for {count} vertices", "one for each expected")
        return shift

    def _material_of(self, primitive: JsonObject, attributes: JsonObject, count: int) -> tuple[int, Float64]:
        """Return the number of the material, and texture coordinates (V, 2)."""
        if not primitive.has("material"):
            if PLAIN not in self._materials:
                self._materials.append(PLAIN)
            return self._materials.index(PLAIN), np.zeros((count, 2))
        number = primitive.integer("material", below=self._root.length("materials"))
        which, offset, scale = material_transform(self._root.element("materials", number))
        key = f"TEXCOORD_{which}"
        if not attributes.has(key):
            return number, np.zeros((count, 2))
        uv = self._accessors.read(attributes.integer(key, below=_INDEX_LIMIT), "VEC2")
        if len(uv) != count:
            raise attributes.error(key, f"has {len(uv)} elements for {count} vertices", "one for each expected")
        return number, uv * scale + offset

    def _triangles_of(self, primitive: JsonObject, count: int) -> Int64:
        if primitive.has("indices"):
            self._check_size(primitive)
            numbers = self._accessors.read(primitive.integer("indices", below=_INDEX_LIMIT), "SCALAR")[:, 0].astype(
                np.int64
            )
        else:
            numbers = np.arange(count, dtype=np.int64)
        if len(numbers) and not 0 <= int(numbers.min()) <= int(numbers.max()) < count:
            raise primitive.error("indices", f"refer to vertex {numbers.max()} of {count}", "a whole file expected")
        triangle = numbers[: len(numbers) // 3 * 3].reshape(-1, 3)
        self._triangles += len(triangle)
        self._refuse_above_limit(self._triangles)
        return triangle

    def _check_size(self, primitive: JsonObject) -> None:
        """Refuse too many triangles before they are read."""
        accessor = self._root.element("accessors", primitive.integer("indices", below=_INDEX_LIMIT))
        self._refuse_above_limit(self._triangles + accessor.integer("count", below=_INDEX_LIMIT) // 3)

    def _refuse_above_limit(self, triangles: int) -> None:
        if triangles > TRIANGLE_LIMIT:
            raise self._root.error(
                "meshes", f"have {triangles:,} triangles; {TRIANGLE_LIMIT:,} at most are read", _SMALLER
            )

    def _normals(self, attributes: JsonObject, position: Float64, triangle: Int64) -> Float64:
        if attributes.has("NORMAL"):
            normal = self._accessors.read(attributes.integer("NORMAL", below=_INDEX_LIMIT), "VEC3")
            if len(normal) == len(position):
                return np.asarray(quaternion.unit(normal))
        a, b, c = (position[triangle[:, corner]] for corner in range(3))
        facing = np.cross(b - a, c - a)
        total = np.zeros_like(position)
        for corner in range(3):
            np.add.at(total, triangle[:, corner], facing)
        return np.asarray(quaternion.unit(total))

    def _skinning(self, attributes: JsonObject, skin: JsonObject, count: int) -> tuple[Int64, Float64, Float64]:
        """Return nodes (V, K) and weights (V, K) of each vertex, and its matrix to the rest pose, (V, 4, 4)."""
        joints = np.array(skin.integers("joints", below=self._nodes.count), np.int64)
        numbers, weights = [], []
        for which in range(2):
            if not attributes.has(f"JOINTS_{which}"):
                continue
            number = self._accessors.read(attributes.integer(f"JOINTS_{which}", below=_INDEX_LIMIT), "VEC4").astype(
                np.int64
            )
            weight = self._accessors.read(attributes.integer(f"WEIGHTS_{which}", below=_INDEX_LIMIT), "VEC4")
            if len(number) != count or len(weight) != count:
                raise attributes.error(f"JOINTS_{which}", f"has {len(number)} elements for {count}", "one for each")
            if number.size and not 0 <= int(number.min()) <= int(number.max()) < len(joints):
                words = f"refers to joint {number.max()} of {len(joints)}"
                raise attributes.error(f"JOINTS_{which}", words, "a file whose references fit expected")
            numbers.append(number)
            weights.append(np.maximum(weight, 0.0))
        if not numbers:
            raise attributes.error("JOINTS_0", "is missing, so this mesh cannot be animated", _WITH_ARMATURE)
        number, weight = np.concatenate(numbers, axis=1), np.concatenate(weights, axis=1)
        weight[weight.sum(axis=1) <= 0.0, 0] = 1.0
        weight /= weight.sum(axis=1, keepdims=True)
        each = self._matrix[joints] @ self._inverse_binds(skin, len(joints))
        moved = np.einsum("vk,vkij->vij", weight, each[number])
        return joints[number], weight, moved

    def _inverse_binds(self, skin: JsonObject, count: int) -> Float64:
        if not skin.has("inverseBindMatrices"):
            return np.tile(np.eye(4), (count, 1, 1))
        numbers = self._accessors.read(skin.integer("inverseBindMatrices", below=_INDEX_LIMIT), "MAT4")
        if len(numbers) < count:
            words = f"has {len(numbers)} matrices for {count} joints"
            raise skin.error("inverseBindMatrices", words, "one for each joint expected")
        return numbers[:count].reshape(-1, 4, 4).transpose(0, 2, 1)
