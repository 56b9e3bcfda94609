"""The bodies that dancers can have, by name, and characters that are loaded from files.

All bodies share one skeleton and differ in their mesh.
"""

from dataclasses import dataclass
from typing import Final

DEFAULT_BODY: Final = "dancer"
"""The default body."""
BODIES: Final = (DEFAULT_BODY, "slim", "strong", "round", "child")
"""The built-in bodies. Joints are the same in each, so feet and hands reach the same places."""


MAX_CHARACTERS: Final = 12
"""Maximum number of characters in one show."""


@dataclass(frozen=True, slots=True)
class MaterialOverride:
    """Overrides of a character's material; None: as in its file."""

    colour: tuple[float, float, float] | None = None
    """Linear RGB factor for its texture."""
    sheen: float | None = None
    """Specular strength, 0 to 1."""
    hidden: bool = False


@dataclass(frozen=True, slots=True)
class CharacterFile:
    """A character of a scene: replaces the mesh of dancers whose body (`Scene.bodies`) has this name."""

    name: str
    path: str
    """An existing .glb, .gltf or .vrm file."""
    joints: tuple[tuple[str, str], ...] = ()
    """Engine joints and the nodes of the file that they map to, where the names differ."""
    materials: tuple[tuple[str, MaterialOverride], ...] = ()
    """Materials of the file by name."""
