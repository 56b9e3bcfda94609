"""Set pieces from glTF files: every mesh of a scene in its place, as one list of triangles with images.

They are read as characters are, with the same limits; skins are drawn in their rest pose. A file with too many
triangles is refused with a remedy; where the processor draws, large pieces are simplified.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int64, UInt8
from live.base.stage_snapshot import SceneryFile
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_document import open_gltf
from live.motion.skeleton import JOINT_COUNT
from live.render.characters.lod import simplify_to
from live.render.characters.materials import EXTRAS, extras_of, layers_of
from live.render.characters.model import Model, Part
from live.render.characters.model_reader import ModelReader, file_resolver, read_bytes

SOFTWARE_TRIANGLES: Final = 16_000
"""Maximum number of triangles of a set piece where the processor draws."""
MAX_SIZE: Final = 1000.0
"""Maximum extent of a set piece on the stage [m]."""
_MIN_SIZE: Final = 1e-6
_CELLS_EXTENT: Final = 7.5
"""Extent to which positions are scaled for `simplify_to`, whose cells are as large as for a body [m]."""
_OPEN_HEIGHT: Final = 0.5
"""Height [m] below which ambient light is reduced."""


class _SetReader(ModelReader):
    """Reads all meshes, whether or not they move with a skin."""

    def read(self) -> Model:
        parts = list(self._parts())
        if not parts:
            raise self._root.error("meshes", "hold no triangles", "export at least one mesh")
        return self._model(parts)

    def _parts(self) -> Iterator[Part]:
        skins = list(self._root.elements("skins"))
        for node in self._nodes.order:
            place = self._nodes.json_object(node)
            if not place.has("mesh"):
                continue
            mesh = place.integer("mesh", below=self._root.length("meshes"))
            own = skins[place.integer("skin", below=len(skins))] if place.has("skin") else None
            for primitive in self._root.element("meshes", mesh).elements("primitives"):
                part = self._part(primitive, node, own, mesh)
                if part is not None:
                    yield part


@dataclass(frozen=True, slots=True, eq=False)
class SetModel:
    """Triangles of a set piece in the file's metres, its middle above the origin and its underside at 0 (V vertices).

    Attributes as in `characters/character.py`.
    """

    position: Float64
    """Shape (V, 3)."""
    normal: Float64
    """Unit, shape (V, 3)."""
    surface: Float64
    """uv, tint (square root of the colour, sheen) and finish (layer, alpha cutoff, opacity, extras), shape (V, 10)."""
    triangle: Int64
    """Shape (T, 3)."""
    layers: UInt8
    """Images, shape (L, S, S, 4)."""
    extras: Float32
    """Normals and emission of the materials, shape (64, 4)."""
    two_sided: bool
    """Whether some material is two-sided."""

    @property
    def height(self) -> float:
        """Height [m of the file]."""
        return float(self.position[:, 1].max())

    def simplified(self, max_triangles: int) -> "SetModel":
        """Return it with at most so many triangles (Rossignac and Borrel 1993), or itself if it has no more."""
        if len(self.triangle) <= max_triangles:
            return self
        scale = _CELLS_EXTENT / float(np.ptp(self.position, axis=0).max())
        weight = np.zeros((len(self.position), JOINT_COUNT))
        material = np.unique(self.surface[:, 2:], axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)
        middle = self.position.min(axis=0)
        mesh = simplify_to((self.position - middle) * scale, weight, material, self.triangle, max_triangles)
        normal = mesh.mean(self.normal)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
        position = mesh.surface_positions(self.position, self.triangle)
        return SetModel(
            position, normal, mesh.mean(self.surface), mesh.triangle, self.layers, self.extras, self.two_sided,
        )  # fmt: skip


def read_set_model(path: Path) -> SetModel:
    """Return the set piece in a .glb or .gltf file, cached until it changes; MotionFileError if it cannot be drawn."""
    try:
        stat = path.stat()
        stamp = stat.st_mtime_ns, stat.st_size
    except OSError:
        stamp = 0, 0
    return _read(path, stamp)


@lru_cache(maxsize=8)
def _read(path: Path, stamp: tuple[int, int]) -> SetModel:
    file = str(path)
    try:
        model = _SetReader(open_gltf(read_bytes(path), file), file_resolver(path)).read()
        return _prepared(model)
    except MemoryError:
        raise MotionFileError(file, None, "not enough memory", "export it with fewer triangles") from None


def _prepared(model: Model) -> SetModel:
    materials = list(model.materials)
    layers, layer_of, _ = layers_of(model, materials)
    first = [0, *np.cumsum([len(part.position) for part in model.parts]).tolist()][:-1]
    position = np.concatenate([part.position for part in model.parts])
    low, high = position.min(axis=0), position.max(axis=0)
    extent = float((high - low).max())
    if not math.isfinite(extent) or extent < _MIN_SIZE:
        raise MotionFileError(model.file, None, "its meshes have no extent", "export it in metres")
    rows = []
    for part in model.parts:
        material = materials[part.material]
        layer = 0 if material.image is None else layer_of.get((material.image, False), 0)
        extra = part.material + 1 if material.has_extras and part.material < EXTRAS - 1 else 0
        sheen = 0.06 if material.toon_shaded else 0.35 * (1.0 - material.roughness)
        row = [*np.sqrt(material.colour[:3]), sheen, layer, material.cutoff, material.colour[3], extra]
        rows.append(np.column_stack([part.uv, np.tile(row, (len(part.uv), 1))]))
    return SetModel(
        position=position - np.array([0.5 * (low[0] + high[0]), low[1], 0.5 * (low[2] + high[2])]),
        normal=np.concatenate([part.normal for part in model.parts]),
        surface=np.concatenate(rows),
        triangle=np.concatenate([part.triangle + begin for part, begin in zip(model.parts, first, strict=True)]),
        layers=layers,
        extras=extras_of(list(materials), layer_of),
        two_sided=any(materials[part.material].two_sided for part in model.parts),
    )


def place_on_stage(model: SetModel, said: SceneryFile) -> tuple[Float32, Float32, Float32]:
    """Return positions on the stage [m] and normals of all vertices, (V, 3), and their ambient openness, (V, 1)."""
    scale = said.scale if said.height is None else said.height / max(model.height, _MIN_SIZE)
    scale = min(scale, MAX_SIZE / float(np.ptp(model.position, axis=0).max()))
    cos, sin = math.cos(math.radians(said.turn_deg)), math.sin(math.radians(said.turn_deg))
    about = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    position = model.position @ about.T * scale + np.array([said.at[0], said.lift, said.at[1]])
    openness = np.clip(0.55 + 0.45 * position[:, 1:2] / _OPEN_HEIGHT, 0.0, 1.0)
    return position.astype(np.float32), (model.normal @ about.T).astype(np.float32), openness.astype(np.float32)
