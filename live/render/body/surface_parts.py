"""Numbers of the parts of a dancer's surface: what the shaders paint (`BodyMesh.part`)."""

from typing import Final

BODY: Final = 0
"""Skin and close-fitting clothes, by place (`surface.glsl`)."""
FACE: Final = 1
"""Skin of a head with eyeballs, …"""
PAINTED_FACE: Final = 2
"""… and of one whose eyes are only painted (`head_surface.glsl`)."""
EYE: Final = 3
TEETH: Final = 4
EAR: Final = 5
HAIR: Final = 6
NAIL: Final = 7
"""A finger's nail."""
PART_COUNT: Final = 16
"""Shaders pass a dancer's number and a part as one: dancer * PART_COUNT + part."""
