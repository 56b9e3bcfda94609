"""The bodies that dancers can have, by name: one skeleton, other flesh on it.

Characters that people bring along: which file is drawn in the place of the usual body, and how.
"""

from dataclasses import dataclass
from typing import Final

USUAL: Final = "dancer"
"""The body of everybody of whom nothing else is said."""
BODIES: Final = (USUAL, "slim", "strong", "round", "child")
"""All bodies; a dancer's joints are the same in each, so her feet stand and her hands meet as they should."""


MOST: Final = 12
"""Characters in one show at most."""


@dataclass(frozen=True, slots=True)
class Worn:
    """What is changed of a character's material; None: as in its file."""

    colour: tuple[float, float, float] | None = None
    """Linear RGB that its texture is multiplied by."""
    sheen: float | None = None
    """How much it shines in the light, 0 to 1."""
    hidden: bool = False


@dataclass(frozen=True, slots=True)
class CharacterFile:
    """A character of a scene: dancers whose body (`Scene.bodies`) has its name are drawn as it."""

    name: str
    path: str
    """A .glb, .gltf or .vrm file that is there."""
    joints: tuple[tuple[str, str], ...] = ()
    """Engine joints and the nodes of the file that are meant, where names do not say it."""
    materials: tuple[tuple[str, Worn], ...] = ()
    """Materials of the file by name."""
