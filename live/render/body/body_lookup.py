"""Kinds of pieces that a scene's dancers are drawn with: bodies (or characters from files), heads and hair.

Heads and hair are meshes of their own, so that any face and any hair style goes with any body at the cost of their own
triangles. The coarsest levels of a body have a head of their own; what a kind lacks at a level is not drawn.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Int32
from live.base.body.appearance import BODY, COSTUME, COSTUMES, HAIR, HAIRS, SHOES, SHOES_WORN
from live.base.body.catalogue import BODIES, DEFAULT_BODY, MEN
from live.base.stage_snapshot import Scene
from live.motion.cloth.garment_catalogue import MOVING_HAIR
from live.render.body.body_mesh import BodyMesh, build_body, merged
from live.render.body.face_shape import FACE_COUNT
from live.render.body.garment_mesh import GARMENTS, build_garment
from live.render.body.hair_mesh import build_hair
from live.render.body.head_mesh import build_head
from live.render.characters.character import Character, load_character

FAMILIES: Final = ("body", "head", "hair", "costume", "shoes")
"""Families of kinds; a dancer is drawn with at most one piece of each, in this order."""
_FACE_SEED: Final = 23


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of piece."""

    family: str
    """One of `FAMILIES`, or `character`: a body from a file, which has no other pieces."""
    body: str
    """Name of the body that it belongs to."""
    style: int = 0
    """The face, or the place among `HAIRS`, `COSTUMES` or `SHOES`."""


def bodies_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of the bodies in a scene: generated ones, then characters."""
    bodies = tuple(name for name in BODIES if name == DEFAULT_BODY or name in scene.bodies)
    return bodies + tuple(said.name for said in scene.characters)


def kinds_of(scene: Scene) -> tuple[Kind, ...]:
    """Return the kinds of a scene, those of bodies first, in the order of `bodies_of`."""
    names = {said.name for said in scene.characters}
    bodies = bodies_of(scene)
    generated = [name for name in bodies if name not in names]
    return (
        *(Kind("character" if name in names else "body", name) for name in bodies),
        *(Kind("head", name, face) for name in generated for face in range(FACE_COUNT)),
        *(Kind("hair", name, style) for name in generated for style in range(1, len(HAIRS))),
        *(
            Kind(family, name, style)
            for name in generated
            for family, styles in (("costume", COSTUMES), ("shoes", SHOES))
            for style, style_name in enumerate(styles)
            if style_name in GARMENTS
        ),
    )


def _hair_of(body: str, style: int) -> int:
    """Return the place among `HAIRS` of a hair style on a body: what is usual depends on it."""
    return HAIRS.index("crop" if body in MEN else "bun") if HAIRS[style] == "usual" else style


def pieces_of(kinds: tuple[Kind, ...], scene: Scene, appearance: Int32) -> Int32:
    """Return the kinds of the pieces of A dancers of an appearance (A, APPEARANCE_SIZE), shape (A, len(FAMILIES)); -1
    is none."""
    number = {kind: at for at, kind in enumerate(kinds)}
    names = bodies_of(scene)
    sizes = {"head": FACE_COUNT, "hair": len(HAIRS), "costume": len(COSTUMES), "shoes": len(SHOES)}
    tables = {
        family: np.array([[number.get(Kind(family, name, style), -1) for style in range(size)] for name in names])
        for family, size in sizes.items()
    }
    hair = np.array([[_hair_of(name, style) for style in range(sizes["hair"])] for name in names])
    tables["hair"] = np.take_along_axis(tables["hair"], hair, axis=1)
    count = len(appearance)
    usual = np.zeros(count, np.int32)
    known = scene.bodies[:count]
    usual[: len(known)] = [names.index(name) for name in known]
    body = np.where(appearance[:, BODY] < 0, usual, np.minimum(appearance[:, BODY], len(names) - 1))
    face = np.random.default_rng(_FACE_SEED).integers(FACE_COUNT, size=count)  # the same dancer always looks the same
    styles = {"head": face} | {
        family: np.clip(appearance[:, column], 0, sizes[family] - 1)
        for family, column in (("hair", HAIR), ("costume", COSTUME), ("shoes", SHOES_WORN))
    }
    pieces = [body, *(tables[family][body, styles[family]] for family in FAMILIES[1:])]
    return np.ascontiguousarray(np.column_stack(pieces), np.int32)


def characters_of(scene: Scene) -> dict[str, Character]:
    """Return the characters of a scene by name; PersonError for one that cannot be drawn."""
    return {said.name: load_character(said) for said in scene.characters}


def mesh_of(scene: Scene, kind: Kind, level: int) -> BodyMesh:
    """Return the mesh of a kind of a scene at a level of detail; without triangles if it has none there. Its joints are
    drawn joints, so that of a character moves with the skeleton only."""
    if kind.family == "head":
        return build_head(level, kind.body, kind.style)
    if kind.family == "hair":
        style = HAIRS[kind.style]
        return build_hair(level, kind.body, style, hanging=style not in MOVING_HAIR)
    if kind.family in ("costume", "shoes"):
        return build_garment(level, kind.body, (COSTUMES if kind.family == "costume" else SHOES)[kind.style])
    for said in scene.characters:
        if said.name == kind.body:
            return load_character(said).levels[level].rigid
    return build_body(level, kind.body)


def build_figure(level: int, name: str = DEFAULT_BODY) -> BodyMesh:
    """Return a whole generated body with its first face and hair style, as one mesh."""
    return merged(
        [build_body(level, name), build_head(level, name, 0), build_hair(level, name, HAIRS[_hair_of(name, 0)])]
    )
