"""What a character's materials have beside their colours: normals and light of their own, as layers and a table."""

import contextlib
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.formats.file_error import MotionFileError
from live.render.characters.model import Material, Model
from live.render.characters.textures import WHOLE, read_layers

Float32 = npt.NDArray[np.float32]
UInt8 = npt.NDArray[np.uint8]
Layers = dict[tuple[int, bool], int]
"""Which layer an image is, by its number and whether it holds normals."""

EXTRAS: Final = 32
"""Materials that the table has, less one; as in surface.glsl."""
LEFT_OUT: Final = "images of normals and glow are left out: too many, too large or broken"


def layers_of(model: Model, worn: list[Material]) -> tuple[UInt8, Layers, tuple[str, ...]]:
    """All images that are drawn as layers, which is which, and what is told of it.

    Normals and glow come only where they take nothing from the colours' size, and are left out if they are broken.
    MotionFileError for colours that are.
    """
    colours = {(each.image, False) for each in worn if each.image is not None}
    glow = {(each.glow_image, False) for each in worn if each.glow_image is not None and max(each.glow) > 0.0}
    bumps = {(each.normal, True) for each in worn if each.normal is not None}
    first, more = sorted(colours), [*sorted(glow - colours), *sorted(bumps)]
    if more and len(first) + len(more) <= WHOLE:
        with contextlib.suppress(MotionFileError):
            return *_read(model, [*first, *more]), ()
    return *_read(model, first), (LEFT_OUT,) if more else ()


def _read(model: Model, wanted: list[tuple[int, bool]]) -> tuple[UInt8, Layers]:
    used = [(image, bump) for image, bump in wanted if model.images[image]]
    numbers = frozenset(place for place, (_, bump) in enumerate(used) if bump)
    layers = read_layers([model.images[image] or b"" for image, _ in used], model.file, numbers)
    return layers, {key: number + 1 for number, key in enumerate(used)}


def extras_of(materials: list[Material | None], layers: Layers) -> Float32:
    """Normals and glow of material n in rows 2 (n + 1) and the next, shape (2 EXTRAS, 4): layer of the normals
    (0: none), their strength, layer of the glow, 1 if there is any; its linear RGB. Materials beyond that have none."""
    rows = np.zeros((2 * EXTRAS, 4), np.float32)
    for number, material in enumerate(materials[: EXTRAS - 1], start=1):
        if material is None:
            continue
        bumps = 0 if material.normal is None else layers.get((material.normal, True), 0)
        glow = 0 if material.glow_image is None else layers.get((material.glow_image, False), -1)
        glows = glow >= 0 and max(material.glow) > 0.0  # without its image it would glow all over
        rows[2 * number] = bumps, material.bumps, max(glow, 0), glows
        rows[2 * number + 1, :3] = material.glow
    return rows
