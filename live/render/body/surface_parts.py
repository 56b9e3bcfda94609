"""Numbers of the parts of a dancer's surface: what the shaders paint (`BodyMesh.part`)."""

from typing import Final

BODY: Final = 0
"""Skin and close-fitting clothes, by place (`surface.glsl`)."""
FACE: Final = 1
"""Skin of a head with eyeballs, …"""
PAINTED_FACE: Final = 2
"""… and of one whose eyes are only painted (includes/head_surface.glsl)."""
EYE: Final = 3
TEETH: Final = 4
EAR: Final = 5
HAIR: Final = 6
NAIL: Final = 7
"""A finger's nail."""
GARMENT: Final = 8
"""A garment's part is this and the number of its material, see `wardrobe.py`: cloth, …"""
CLOTH: Final = GARMENT
SECOND_CLOTH: Final = GARMENT + 1
SHOE: Final = GARMENT + 4
SOLE: Final = GARMENT + 7
PART_COUNT: Final = 16
"""Shaders pass a dancer's number and a part as one: dancer * PART_COUNT + part."""
