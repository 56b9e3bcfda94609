"""Materials of glTF files (for MToon the base colour), and their images as layers of one texture array.

Images are checked before they are decoded, and scaled to equal size. Normal maps and emission are layers with a table
of parameters.
"""

import contextlib
import io
from typing import Final

import numpy as np
from PIL import Image, UnidentifiedImageError

from live.base.arrays import Float32, UInt8
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_document import JsonObject
from live.render.characters.model import Material, Model

MAX_EMISSION: Final = 8.0
"""Maximum emission of a material, relative to white cloth in full light."""
_DEFAULT_CUTOFF = {"MASK": 0.5, "BLEND": 0.35}
PLAIN = Material("", (0.8, 0.8, 0.8, 1.0), None, 0.0, False, 0.8, False)
"""Material of parts without one."""


def read_materials(root: JsonObject) -> list[Material]:
    """Return all materials in order; blended ones become cut-outs, because dancers are drawn in any order."""
    return [_material(root, place, number) for number, place in enumerate(root.elements("materials"))]


def _material(root: JsonObject, place: JsonObject, number: int) -> Material:
    name = " ".join(place.text("name").split())[:100] or f"material {number}"
    pbr = place.object("pbrMetallicRoughness") if place.has("pbrMetallicRoughness") else None
    colour, image, rough = (1.0, 1.0, 1.0, 1.0), None, 0.9
    if pbr is not None:
        r, g, b, a = (min(max(part, 0.0), 1.0) for part in pbr.numbers("baseColorFactor", 4, colour))
        colour = r, g, b, a
        rough = min(max(pbr.number("roughnessFactor", 1.0), 0.0), 1.0)
        if pbr.has("baseColorTexture"):
            image = image_of(root, pbr.object("baseColorTexture"))
    extensions = place.object("extensions") if place.has("extensions") else None
    drawn = extensions is not None and any(
        extensions.has(each) for each in ("KHR_materials_unlit", "VRMC_materials_mtoon")
    )
    mode = place.text("alphaMode", "OPAQUE")
    cutoff = place.number("alphaCutoff", _DEFAULT_CUTOFF[mode]) if mode in _DEFAULT_CUTOFF else 0.0
    plain = name, colour, image, min(cutoff, 0.95), place.flag("doubleSided"), rough, drawn
    if extensions is not None and extensions.has("KHR_materials_unlit"):
        return Material(*plain)
    return Material(*plain, *_normal_map(root, place), *_emission(root, place, extensions))


def _normal_map(root: JsonObject, place: JsonObject) -> tuple[int | None, float]:
    """Return the normal map's image, if it is placed like the base colour, and its strength."""
    if not place.has("normalTexture"):
        return None, 1.0
    texture = place.object("normalTexture")
    if _texture_transform(texture) != material_transform(place):
        return None, 1.0
    return image_of(root, texture), min(max(texture.number("scale", 1.0), -4.0), 4.0)


def _emission(
    root: JsonObject, place: JsonObject, extensions: JsonObject | None
) -> tuple[tuple[float, float, float], int | None]:
    """Return the emission and its image, which must be placed like the base colour."""
    strength = 1.0
    if extensions is not None and extensions.has("KHR_materials_emissive_strength"):
        strength = extensions.object("KHR_materials_emissive_strength").number("emissiveStrength", 1.0)
    strength = min(max(strength, 0.0), MAX_EMISSION)
    r, g, b = (min(max(part, 0.0), 1.0) * strength for part in place.numbers("emissiveFactor", 3, (0.0, 0.0, 0.0)))
    if not place.has("emissiveTexture"):
        return (r, g, b), None
    texture = place.object("emissiveTexture")
    if _texture_transform(texture) != material_transform(place):  # placed differently, the wrong parts would glow
        return (0.0, 0.0, 0.0), None
    return (r, g, b), image_of(root, texture)


def image_of(root: JsonObject, texture: JsonObject) -> int | None:
    """Return the image of a texture reference; None for unsupported kinds of image."""
    source = root.element("textures", texture.integer("index", below=root.length("textures")))
    return source.integer("source", below=root.length("images")) if source.has("source") else None


def material_transform(place: JsonObject) -> tuple[int, tuple[float, float], tuple[float, float]]:
    """Return the set of texture coordinates of a material's images, their offset and scale: those of the base colour,
    or, if it has no image, of the normals or the emission."""
    pbr = place.object("pbrMetallicRoughness") if place.has("pbrMetallicRoughness") else None
    if pbr is not None and pbr.has("baseColorTexture"):
        return _texture_transform(pbr.object("baseColorTexture"))
    for name in ("normalTexture", "emissiveTexture"):
        if place.has(name):
            return _texture_transform(place.object(name))
    return 0, (0.0, 0.0), (1.0, 1.0)


def _texture_transform(texture: JsonObject) -> tuple[int, tuple[float, float], tuple[float, float]]:
    uv = texture.integer("texCoord", 0, below=8)
    extensions = texture.object("extensions") if texture.has("extensions") else None
    if extensions is None or not extensions.has("KHR_texture_transform"):
        return uv, (0.0, 0.0), (1.0, 1.0)
    moved = extensions.object("KHR_texture_transform")
    u, v = moved.numbers("offset", 2, (0.0, 0.0))
    su, sv = moved.numbers("scale", 2, (1.0, 1.0))
    return moved.integer("texCoord", uv, below=8), (u, v), (su, sv)


SIDE_LIMIT: Final = 8192
"""Maximum width or height of an image [pixels]."""
PIXEL_LIMIT: Final = 150_000_000
"""Maximum number of pixels of all images of a character."""
_SIDE: Final = 1024
_TEXEL_LIMIT: Final = 24 << 20
"""Maximum number of texels of all layers."""
FULL_SIZE_IMAGES: Final = _TEXEL_LIMIT // (_SIDE * _SIDE) - 1
"""Up to so many images keep their size."""
_SMALLER: Final = "export the character with images of 1024 or 2048 pixels"

_LINEAR: Final = np.arange(256) / 255.0
_LINEAR_OF: Final = np.where(_LINEAR <= 0.04045, _LINEAR / 12.92, ((_LINEAR + 0.055) / 1.055) ** 2.4)
_SQRT_LINEAR: Final = np.rint(np.sqrt(_LINEAR_OF) * 255.0).astype(np.uint8)
"""Square root of linear light for each sRGB byte (IEC 61966-2-1); all colours of dancers are stored so."""


def read_layers(images: list[bytes], file: str, numbers: frozenset[int] = frozenset()) -> UInt8:
    """Return layers (L, S, S, 4): a white one, then one per image, as square roots of linear RGB, and opacity. Images
    whose index is in `numbers` hold no colours and are not converted.

    MotionFileError for a file that is no PNG, JPEG or WebP, is broken, or is too large.
    """
    opened = [_open(data, number, file) for number, data in enumerate(images)]
    if sum(image.width * image.height for image in opened) > PIXEL_LIMIT:
        raise MotionFileError(file, None, f"images of more than {PIXEL_LIMIT // 10**6} megapixels", _SMALLER)
    side = 4
    longest = max((max(image.size) for image in opened), default=1)
    while side < min(longest, _SIDE) and (2 * side) ** 2 * (len(opened) + 1) <= _TEXEL_LIMIT:
        side *= 2
    layers = np.full((len(opened) + 1, side, side, 4), 255, np.uint8)
    for number, image in enumerate(opened):
        layers[number + 1] = _pixels(image, side, number, file)
    for number in range(len(layers)):
        if number - 1 not in numbers:
            layers[number, ..., :3] = _SQRT_LINEAR[layers[number, ..., :3]]
    return layers


def _open(data: bytes, number: int, file: str) -> Image.Image:
    try:
        image = Image.open(io.BytesIO(data), formats=("PNG", "JPEG", "WEBP"))
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        raise MotionFileError(file, None, f"image {number} is no PNG, JPEG or WebP", "export it again") from None
    if max(image.size) > SIDE_LIMIT:
        words = f"image {number} has {image.width} x {image.height} pixels"
        raise MotionFileError(file, None, words, f"{SIDE_LIMIT} at most: {_SMALLER}")
    return image


def _pixels(image: Image.Image, side: int, number: int, file: str) -> UInt8:
    try:
        image.draft("RGB", (side, side))
        whole = image.convert("RGBA")
        return np.asarray(
            whole.resize((side, side), Image.Resampling.BOX if side < whole.width else Image.Resampling.BILINEAR)
        )
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        words = f"image {number} is broken: {' '.join(str(error).split())[:80]}"
        raise MotionFileError(file, None, words, "export it again") from None


Layers = dict[tuple[int, bool], int]
"""Layer of an image, by its number and whether it holds normals."""

EXTRAS: Final = 32
"""Size of the table of extras, one more than its materials; as in surface.glsl."""
LEFT_OUT_NOTE: Final = "images of normals and glow are left out: too many, too large or broken"


def layers_of(model: Model, materials: list[Material]) -> tuple[UInt8, Layers, tuple[str, ...]]:
    """Return all drawn images as layers, the layer of each, and notes.

    Normals and emission are only included if the colours keep their size, and left out if they are broken.
    MotionFileError for broken colours.
    """
    colours = {(each.image, False) for each in materials if each.image is not None}
    glow = {
        (each.emission_image, False)
        for each in materials
        if each.emission_image is not None and max(each.emission) > 0.0
    }
    bumps = {(each.normal_image, True) for each in materials if each.normal_image is not None}
    first, more = sorted(colours), [*sorted(glow - colours), *sorted(bumps)]
    if more and len(first) + len(more) <= FULL_SIZE_IMAGES:
        with contextlib.suppress(MotionFileError):
            return *_read(model, [*first, *more]), ()
    return *_read(model, first), (LEFT_OUT_NOTE,) if more else ()


def _read(model: Model, wanted: list[tuple[int, bool]]) -> tuple[UInt8, Layers]:
    used = [(image, bump) for image, bump in wanted if model.images[image]]
    numbers = frozenset(place for place, (_, bump) in enumerate(used) if bump)
    layers = read_layers([model.images[image] or b"" for image, _ in used], model.file, numbers)
    return layers, {key: number + 1 for number, key in enumerate(used)}


def extras_of(materials: list[Material | None], layers: Layers) -> Float32:
    """Return the table of normals and emission, shape (2 EXTRAS, 4). Material n has rows 2 (n + 1) and the next: layer
    of the normals (0: none), their strength, layer of the emission, 1 if there is any; its linear RGB. Materials
    beyond the table have none."""
    rows = np.zeros((2 * EXTRAS, 4), np.float32)
    for number, material in enumerate(materials[: EXTRAS - 1], start=1):
        if material is None:
            continue
        bumps = 0 if material.normal_image is None else layers.get((material.normal_image, True), 0)
        glow = 0 if material.emission_image is None else layers.get((material.emission_image, False), -1)
        glows = glow >= 0 and max(material.emission) > 0.0  # without its image the whole material would glow
        rows[2 * number] = bumps, material.normal_strength, max(glow, 0), glows
        rows[2 * number + 1, :3] = material.emission
    return rows
