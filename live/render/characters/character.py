"""A character ready to be drawn: in three levels of detail, with its images, on the engine's skeleton."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.body_catalogue import MOST, USUAL, CharacterFile, Worn
from live.base.errors import PersonError
from live.motion.formats.file_error import MotionFileError
from live.motion.skeleton import SKELETON
from live.render.body.body_mesh import COARSE, FINE, LIGHT, BodyMesh, strongest
from live.render.body.body_variants import parts_of
from live.render.body.implicit_surface import Shape
from live.render.characters.lod import reduce_to
from live.render.characters.materials import EXTRAS, Layers, extras_of, layers_of
from live.render.characters.model import Material, Model
from live.render.characters.model_reader import read_model
from live.render.characters.skeleton_fit import Fitted, find_joints, fit

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

TRIANGLES: Final = {COARSE: 1200, LIGHT: 3600, FINE: 60_000}
"""Triangles of each level at most."""
_REACHES: Final = (0.06, 0.10, 0.16)


@dataclass(frozen=True, slots=True, eq=False)
class WornMesh:
    """A level of a character's surface, and what lies on it (V vertices)."""

    body: BodyMesh
    uv: Float32
    """Place on its image, shape (V, 2)."""
    tint: Float32
    """Square root of linear RGB that the image is multiplied by, and sheen, 0 to 1, shape (V, 4)."""
    finish: Float32
    """Layer, opacity where there is nothing left, opacity, unused; the first as it is, the others 0 to 1; (V, 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class Character:
    """One character."""

    model: Model
    joints: Mapping[str, int | None]
    """Node of each of the engine's joints."""
    fitted: Fitted
    levels: Mapping[int, WornMesh]
    """By `COARSE`, `LIGHT`, `FINE`."""
    layers: npt.NDArray[np.uint8]
    """Images, shape (L, S, S, 4): square roots of linear RGB, and opacity."""
    two_sided: bool
    """Whether some of it is seen from behind, too."""
    reach: float
    """How far it reaches beyond its joints [m]."""
    extras: Float32
    """What some materials have beside their colours, see `extras_of`."""


def load_character(said: CharacterFile) -> Character:
    """The character of a scene, read once while its file stays as it is; PersonError if it cannot be drawn."""
    path = Path(said.path)
    try:
        stat = path.stat()
        stamp = stat.st_mtime_ns, stat.st_size
    except OSError:
        stamp = 0, 0
    try:
        return _loaded(said, stamp)
    except MotionFileError as error:
        raise PersonError(f"{error.file}: {error.problem}", error.expected) from None


@lru_cache(maxsize=MOST)
def _loaded(said: CharacterFile, stamp: tuple[int, int]) -> Character:
    model = read_model(Path(said.path))
    joints = find_joints(model, dict(said.joints))
    materials = _materials(model, dict(said.materials))
    hidden = {number for number, material in enumerate(materials) if material is None}
    kept = tuple(part for part in model.parts if part.material not in hidden)
    if not kept:
        raise MotionFileError(model.file, None, "all its materials are hidden", "leave one to be seen")
    layers, layer_of, notes = layers_of(model, [material for material, _ in filter(None, materials)])
    changed = {"parts": kept, "notes": (*model.notes, *notes)}
    model = Model(**{name: getattr(model, name) for name in Model.__dataclass_fields__} | changed)
    fitted = fit(model, joints)
    extras = extras_of([None if known is None else known[0] for known in materials], layer_of)
    surface = _surface(model, materials, layer_of)
    triangle = np.concatenate([part.triangle + first for part, first in zip(model.parts, _firsts(model), strict=True)])
    openness = _openness(fitted)
    levels = {level: _level(fitted, surface, openness, triangle, wanted) for level, wanted in TRIANGLES.items()}
    two_sided = any(materials[part.material][0].two_sided for part in model.parts)  # type: ignore[index]
    return Character(model, joints, fitted, levels, layers, two_sided, _reach(fitted), extras)


def _firsts(model: Model) -> list[int]:
    return [0, *np.cumsum([len(part.position) for part in model.parts]).tolist()][:-1]


def _materials(model: Model, said: Mapping[str, Worn]) -> list[tuple[Material, Worn] | None]:
    """All materials with what is changed of them, None for those that are hidden."""
    for name in said:
        if all(material.name != name for material in model.materials):
            known = ", ".join(material.name for material in model.materials[:20])
            raise MotionFileError(model.file, None, f"no material is called {name!r}", f"there are: {known}")
    changed = [(material, said.get(material.name, Worn())) for material in model.materials]
    return [None if worn.hidden else (material, worn) for material, worn in changed]


def _surface(model: Model, materials: list[tuple[Material, Worn] | None], layer_of: Layers) -> Float64:
    """uv, tint, finish and number of the material of all vertices, shape (V, 11)."""
    rows = []
    for part in model.parts:
        known = materials[part.material]
        assert known is not None
        material, worn = known
        colour = np.array(material.colour[:3]) * (1.0 if worn.colour is None else np.array(worn.colour))
        sheen = (0.06 if material.drawn else 0.35 * (1.0 - material.rough)) if worn.sheen is None else worn.sheen
        layer = 0 if material.image is None else layer_of.get((material.image, False), 0)
        extra = part.material + 1 if material.has_more and part.material < EXTRAS - 1 else 0
        row = [*np.sqrt(colour), sheen, layer, material.cutoff, material.colour[3], extra / 255.0, part.material]
        rows.append(np.column_stack([part.uv, np.tile(row, (len(part.uv), 1))]))
    return np.concatenate(rows)


def _openness(fitted: Fitted) -> Float64:
    """How much of the light around reaches each vertex: as on the usual body, which has the same joints."""
    shape, points = Shape(parts_of(USUAL)), fitted.position
    inside = np.minimum(shape.distance(points), 0.0)
    total = np.zeros(len(points))
    for reach in _REACHES:
        total += np.clip((shape.distance(points + fitted.normal * reach) - inside) / reach, 0.25, 1.0)
    return total / len(_REACHES)


def _level(fitted: Fitted, surface: Float64, openness: Float64, triangle: Int64, wanted: int) -> WornMesh:
    position, normal, weight = fitted.position, fitted.normal, fitted.weight
    if len(triangle) > wanted:
        level = reduce_to(position, weight, surface[:, -1].astype(np.int64), triangle, wanted)
        position, normal, weight, surface = level.places(position), *map(level.mean, (normal, weight, surface))
        openness, triangle = level.mean(openness[:, None])[:, 0], level.triangle
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    joint, share = strongest(weight)
    body = BodyMesh(_packed(position), _packed(normal), joint, share, _packed(openness), triangle.astype(np.int32))
    return WornMesh(body, _packed(surface[:, :2]), _packed(surface[:, 2:6]), _packed(surface[:, 6:10]))


def _packed(array: Float64) -> Float32:
    return np.ascontiguousarray(array, np.float32)


def _reach(fitted: Fitted) -> float:
    rest = SKELETON.rest_positions()
    main = rest[fitted.weight.argmax(axis=1)]
    return float(np.linalg.norm(fitted.position - main, axis=1).max())
