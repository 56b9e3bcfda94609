"""Character prepared for drawing: four levels of detail, images, and weights for the engine's skeleton."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int64
from live.base.body.catalogue import DEFAULT_BODY, MAX_CHARACTERS, CharacterFile, MaterialOverride
from live.base.errors import PersonError
from live.motion.formats.file_error import MotionFileError
from live.motion.skeleton import SKELETON
from live.render.body.body_mesh import CLOSE, COARSE, DISTANT, FINE, LIGHT, BodyMesh, strongest_weights
from live.render.body.body_variants import parts_of
from live.render.body.implicit_surface import Shape
from live.render.body.surface_parts import BODY
from live.render.characters.detail_bones import DetailBones, find_details
from live.render.characters.expressions import LOOKS
from live.render.characters.lod import simplify_to
from live.render.characters.materials import EXTRAS, Layers, extras_of, layers_of
from live.render.characters.model import Material, Model
from live.render.characters.model_reader import read_model
from live.render.characters.morphs import Morphs, Movements, channel_names, fitted_movements, pack, simplified
from live.render.characters.own_joints import FIRST, OwnJoints, drawn_weights, own_joints, own_weights
from live.render.characters.skeleton_fit import FittedCharacter, find_joints, fit, joint_of_node
from live.render.characters.spring_fit import FittedSprings, fit_springs
from live.render.characters.spring_reader import springs_by_name

TRIANGLES: Final = {COARSE: 1200, LIGHT: 3600, CLOSE: 12_000, FINE: 60_000}
"""Maximum number of triangles of each level that is made."""
_OCCLUSION_REACH: Final = (0.06, 0.10, 0.16)


@dataclass(frozen=True, slots=True, eq=False)
class CharacterMesh:
    """Mesh of a character at one level of detail, with its surface attributes (V vertices)."""

    body: BodyMesh
    """Its joints are drawn joints, then the character's own."""
    rigid: BodyMesh
    """The same with the skeleton's joints only, for what is drawn without fingers, face and springs."""
    morphs: Morphs
    uv: Float32
    """Texture coordinates, shape (V, 2)."""
    tint: Float32
    """Square root of the linear RGB factor of the image, and sheen, 0 to 1, shape (V, 4)."""
    finish: Float32
    """Layer, alpha cutoff, opacity, number of its extras / 255; all but the layer 0 to 1; shape (V, 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class Character:
    """A character prepared for drawing."""

    model: Model
    joints: Mapping[str, int | None]
    """The character's node for each of the engine's joints."""
    fitted: FittedCharacter
    levels: Mapping[int, CharacterMesh]
    """By each of `LEVELS`; far away a character is the light one."""
    layers: npt.NDArray[np.uint8]
    """Images, shape (L, S, S, 4): square roots of linear RGB, and opacity."""
    two_sided: bool
    """Whether some material is two-sided."""
    reach: float
    """Maximum distance of the surface from its joints [m]."""
    extras: Float32
    """Normal and emission parameters of materials, see `extras_of`."""
    details: DetailBones
    """The file's nodes of fingers and face."""
    own: OwnJoints
    """Joints of fingers, face and springs."""
    springs: FittedSprings
    channels: tuple[str, ...]
    """Names of the channels of its face that blend shapes draw."""


def load_character(character_file: CharacterFile) -> Character:
    """Return a character, cached until its file changes; PersonError if it cannot be drawn."""
    path = Path(character_file.path)
    try:
        stat = path.stat()
        stamp = stat.st_mtime_ns, stat.st_size
    except OSError:
        stamp = 0, 0
    try:
        return _load(character_file, stamp)
    except MotionFileError as error:
        raise PersonError(f"{error.file}: {error.problem}", error.expected) from None


@lru_cache(maxsize=MAX_CHARACTERS)
def _load(character_file: CharacterFile, stamp: tuple[int, int]) -> Character:
    model = read_model(Path(character_file.path))
    joints = find_joints(model, dict(character_file.joints))
    materials = _materials(model, dict(character_file.materials))
    hidden = {number for number, material in enumerate(materials) if material is None}
    kept = tuple(part for part in model.parts if part.material not in hidden)
    if not kept:
        raise MotionFileError(model.file, None, "all its materials are hidden", "leave one visible")
    layers, layer_of, notes = layers_of(model, [material for material, _ in filter(None, materials)])
    changed = {"parts": kept, "notes": (*model.notes, *notes)}
    model = Model(**{name: getattr(model, name) for name in Model.__dataclass_fields__} | changed)
    details = find_details(model, joints)
    fitted = fit(model, joints, details.fingers)
    extras = extras_of([None if known is None else known[0] for known in materials], layer_of)
    surface = _surface(model, materials, layer_of)
    triangle = np.concatenate(
        [part.triangle + first for part, first in zip(model.parts, _vertex_offsets(model), strict=True)]
    )
    springs, own, owned = _own(model, joints, details, fitted)
    eyes = owned[:, [own.names.index(name) for name in ("leftEye", "rightEye") if name in own.names]]
    movements = fitted_movements(model, fitted, LOOKS if eyes.any() else frozenset())
    shape = _Shape(fitted, drawn_weights(fitted.weight, own, owned), own, movements, surface, triangle)
    levels = {level: _level(shape, level, wanted) for level, wanted in TRIANGLES.items()}
    levels[DISTANT] = levels[LIGHT]
    two_sided = any(materials[part.material][0].two_sided for part in model.parts)  # type: ignore[index]
    model = replace(model, notes=(*model.notes, *springs.notes))
    reach = max(_reach(fitted), springs.reach)
    return Character(
        model, joints, fitted, levels, layers, two_sided, reach, extras, details, own, springs,
        channel_names(movements),
    )  # fmt: skip


def _own(
    model: Model, joints: Mapping[str, int | None], details: DetailBones, fitted: FittedCharacter
) -> tuple[FittedSprings, OwnJoints, Float32]:
    """Return springs, own joints and the skin weights of these (V, M)."""
    body = {node for node in joints.values() if node is not None}
    detailed = {node for chain in details.fingers.values() for node in chain} | set(details.face.values())
    owner, springs = joint_of_node(model, joints), model.springs
    if not springs.bones:
        springs = springs_by_name(model.names, model.parents, model.order, model.joints, body | detailed)
    fitted_springs = fit_springs(model, springs, fitted, owner, body | detailed)
    own = own_joints(model, details, fitted, fitted_springs, owner, body)
    return fitted_springs, own, own_weights(model, own, body)


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """All of a character that its levels of detail are made of (V vertices)."""

    fitted: FittedCharacter
    weight: Float32
    """For drawn and own joints, (V, FIRST + M)."""
    own: OwnJoints
    movements: Movements
    surface: Float64
    triangle: Int64


def _vertex_offsets(model: Model) -> list[int]:
    return [0, *np.cumsum([len(part.position) for part in model.parts]).tolist()][:-1]


def _materials(
    model: Model, overrides: Mapping[str, MaterialOverride]
) -> list[tuple[Material, MaterialOverride] | None]:
    """Return all materials with their changes, None for hidden ones."""
    for name in overrides:
        if all(material.name != name for material in model.materials):
            known = ", ".join(material.name for material in model.materials[:20])
            raise MotionFileError(model.file, None, f"no material is called {name!r}", f"there are: {known}")
    changed = [(material, overrides.get(material.name, MaterialOverride())) for material in model.materials]
    return [None if worn.hidden else (material, worn) for material, worn in changed]


def _surface(model: Model, materials: list[tuple[Material, MaterialOverride] | None], layer_of: Layers) -> Float64:
    """Return uv, tint, finish and material number of all vertices, shape (V, 11)."""
    rows = []
    for part in model.parts:
        known = materials[part.material]
        assert known is not None
        material, worn = known
        colour = np.array(material.colour[:3]) * (1.0 if worn.colour is None else np.array(worn.colour))
        sheen = (
            (0.06 if material.toon_shaded else 0.35 * (1.0 - material.roughness)) if worn.sheen is None else worn.sheen
        )
        layer = 0 if material.image is None else layer_of.get((material.image, False), 0)
        extra = part.material + 1 if material.has_extras and part.material < EXTRAS - 1 else 0
        row = [*np.sqrt(colour), sheen, layer, material.cutoff, material.colour[3], extra / 255.0, part.material]
        rows.append(np.column_stack([part.uv, np.tile(row, (len(part.uv), 1))]))
    return np.concatenate(rows)


def _openness(points: Float64, normal: Float64) -> Float64:
    """Return the share of ambient light at each vertex, from the usual body, which has the same joints."""
    shape = Shape(parts_of(DEFAULT_BODY))
    inside = np.minimum(shape.distance(points), 0.0)
    total = np.zeros(len(points))
    for reach in _OCCLUSION_REACH:
        total += np.clip((shape.distance(points + normal * reach) - inside) / reach, 0.25, 1.0)
    return total / len(_OCCLUSION_REACH)


def _level(shape: _Shape, number: int, wanted: int) -> CharacterMesh:
    fitted, weight, surface, triangle = shape.fitted, shape.weight, shape.surface, shape.triangle
    position, normal, movements = fitted.position, fitted.normal, {} if number == COARSE else shape.movements
    if len(triangle) > wanted:
        level = simplify_to(position, fitted.weight, surface[:, -1].astype(np.int64), triangle, wanted)
        movements = simplified(movements, level)
        coarse = number == COARSE  # its cells are as large as limbs: planes would draw out its edges
        position = level.mean_positions(position) if coarse else level.surface_positions(position, triangle)
        normal, surface = level.mean(normal), level.mean(surface)
        weight = level.mean(weight.astype(np.float64)).astype(np.float32)
        triangle = level.triangle
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    joint, share = strongest_weights(weight.astype(np.float64))
    openness = _as_float32(_openness(position, normal))
    body = BodyMesh(
        _as_float32(position), _as_float32(normal), joint, share, openness, triangle.astype(np.int32),
        _as_float32(position), np.full(len(position), BODY, np.int32),
    )  # fmt: skip
    carriers = np.concatenate([np.arange(FIRST, dtype=np.int32), shape.own.joint])
    rigid = replace(body, joint=carriers[joint])
    columns = _as_float32(surface[:, :2]), _as_float32(surface[:, 2:6]), _as_float32(surface[:, 6:10])
    return CharacterMesh(body, rigid, pack(movements, len(position)), *columns)


def _as_float32(array: Float64) -> Float32:
    return np.ascontiguousarray(array, np.float32)


def _reach(fitted: FittedCharacter) -> float:
    rest = SKELETON.rest_positions()
    main = rest[fitted.weight.argmax(axis=1)]
    return float(np.linalg.norm(fitted.position - main, axis=1).max())
