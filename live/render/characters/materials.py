"""Materials of a glTF file: base colour, opacity, roughness; MToon's colours are the base colour's."""

from typing import Final

from live.motion.formats.json_place import JsonPlace
from live.render.characters.model import Material

BRIGHTEST: Final = 8.0
"""Most light that a material gives, of white cloth's in full light."""
_MASKED = {"MASK": 0.5, "BLEND": 0.35}
PLAIN = Material("", (0.8, 0.8, 0.8, 1.0), None, 0.0, False, 0.8, False)
"""What a part without a material is drawn with."""


def read_materials(root: JsonPlace) -> list[Material]:
    """All materials in their order; what blends is cut out, for dancers hide each other in any order."""
    return [_material(root, place, number) for number, place in enumerate(root.elements("materials"))]


def _material(root: JsonPlace, place: JsonPlace, number: int) -> Material:
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
    cutoff = place.number("alphaCutoff", _MASKED[mode]) if mode in _MASKED else 0.0
    plain = name, colour, image, min(cutoff, 0.95), place.flag("doubleSided"), rough, drawn
    if extensions is not None and extensions.has("KHR_materials_unlit"):
        return Material(*plain)
    return Material(*plain, *_bumps(root, place), *_glow(root, place, extensions))


def _bumps(root: JsonPlace, place: JsonPlace) -> tuple[int | None, float]:
    """The image of the normals, if it lies as the base colour does, and how strong they are."""
    if not place.has("normalTexture"):
        return None, 1.0
    texture = place.object("normalTexture")
    if _lies(texture) != texture_place(place):
        return None, 1.0
    return image_of(root, texture), min(max(texture.number("scale", 1.0), -4.0), 4.0)


def _glow(
    root: JsonPlace, place: JsonPlace, extensions: JsonPlace | None
) -> tuple[tuple[float, float, float], int | None]:
    """The light that it gives itself, and the image of it, which must lie as the base colour does."""
    strength = 1.0
    if extensions is not None and extensions.has("KHR_materials_emissive_strength"):
        strength = extensions.object("KHR_materials_emissive_strength").number("emissiveStrength", 1.0)
    strength = min(max(strength, 0.0), BRIGHTEST)
    r, g, b = (min(max(part, 0.0), 1.0) * strength for part in place.numbers("emissiveFactor", 3, (0.0, 0.0, 0.0)))
    if not place.has("emissiveTexture"):
        return (r, g, b), None
    texture = place.object("emissiveTexture")
    if _lies(texture) != texture_place(place):  # elsewhere it would glow where it should not
        return (0.0, 0.0, 0.0), None
    return (r, g, b), image_of(root, texture)


def image_of(root: JsonPlace, texture: JsonPlace) -> int | None:
    """The image that a reference to a texture leads to; None where another kind of image is meant."""
    source = root.element("textures", texture.whole("index", below=root.length("textures")))
    return source.whole("source", below=root.length("images")) if source.has("source") else None


def texture_place(place: JsonPlace) -> tuple[int, tuple[float, float], tuple[float, float]]:
    """Which texture coordinates a material's images take, and how they are moved and scaled: as the base colour says,
    or, without an image of that, the normals or the glow."""
    pbr = place.object("pbrMetallicRoughness") if place.has("pbrMetallicRoughness") else None
    if pbr is not None and pbr.has("baseColorTexture"):
        return _lies(pbr.object("baseColorTexture"))
    for name in ("normalTexture", "emissiveTexture"):
        if place.has(name):
            return _lies(place.object(name))
    return 0, (0.0, 0.0), (1.0, 1.0)


def _lies(texture: JsonPlace) -> tuple[int, tuple[float, float], tuple[float, float]]:
    uv = texture.whole("texCoord", 0, below=8)
    extensions = texture.object("extensions") if texture.has("extensions") else None
    if extensions is None or not extensions.has("KHR_texture_transform"):
        return uv, (0.0, 0.0), (1.0, 1.0)
    moved = extensions.object("KHR_texture_transform")
    u, v = moved.numbers("offset", 2, (0.0, 0.0))
    su, sv = moved.numbers("scale", 2, (1.0, 1.0))
    return moved.whole("texCoord", uv, below=8), (u, v), (su, sv)
