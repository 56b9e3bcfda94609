"""Lookup of a scene's bodies by name: generated ones, and characters from files."""

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.stage_snapshot import Scene
from live.render.body.body_mesh import BodyMesh, build_body
from live.render.characters.character import Character, load_character


def bodies_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of the bodies in a scene: generated ones, then characters."""
    bodies = tuple(name for name in BODIES if name == DEFAULT_BODY or name in scene.bodies)
    return bodies + tuple(said.name for said in scene.characters)


def characters_of(scene: Scene) -> dict[str, Character]:
    """Return the characters of a scene by name; PersonError for one that cannot be drawn."""
    return {said.name: load_character(said) for said in scene.characters}


def mesh_of(scene: Scene, name: str, level: int) -> BodyMesh:
    """Return the mesh of a body of a scene at a level of detail; its joints are drawn joints, so those of a character
    move with the skeleton only."""
    for said in scene.characters:
        if said.name == name:
            return load_character(said).levels[level].rigid
    return build_body(level, name)
