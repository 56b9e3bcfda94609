"""The characters of a patch: their files, a check that they can be drawn, and the body of each dancer."""

import contextlib
from pathlib import Path

import numpy as np

from live.base.body.catalogue import DEFAULT_BODY, CharacterFile, MaterialOverride
from live.base.errors import PersonError
from live.motion.cloth.spring_rig import SpringRig
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_resource
from live.show.patch.section_picture import CharacterSection

_BODIES_SEED = 23
_CHARACTERS_SEED = 29


def character_files(patch: Patch, path: Path) -> tuple[CharacterFile, ...]:
    """Return the patch's characters with their files; `path` is the patch's own. Raises PersonError for missing
    files."""
    return tuple(_file_of(section, number, path) for number, section in enumerate(patch.character))


def _file_of(section: CharacterSection, number: int, path: Path) -> CharacterFile:
    place = ("character", number, "file")
    found = find_resource(section.file, path)
    if found is None or not found.is_file():
        raise PersonError(f"there is no file {section.file!r}", f"put it next to {path.name}", place)
    if Path(section.file).is_absolute() or not found.resolve().is_relative_to(path.parent.resolve()):
        raise PersonError(f"{section.file!r} is outside of {path.parent}", "copy it into the patch's folder", place)
    materials = tuple(
        (name, MaterialOverride(changed.colour, changed.sheen, changed.hidden))
        for name, changed in section.materials.items()
    )
    return CharacterFile(section.name, str(found), tuple(section.joints.items()), materials)


def check_characters(patch: Patch, path: Path) -> None:
    """Read all characters of a patch. Raises PersonError, with its place, for one that cannot be drawn."""
    if not patch.character:
        return
    from live.render.characters.character import load_character  # late, as it loads image decoders

    for number, said in enumerate(character_files(patch, path)):
        try:
            load_character(said)
        except PersonError as error:
            raise PersonError(error.message, error.remedy, ("character", number, "file")) from None


def drawable_characters(patch: Patch, path: Path) -> tuple[CharacterFile, ...]:
    """Return the characters of a patch that can be drawn now. Others are skipped, so that a show can be resumed."""
    if not patch.character:
        return ()
    from live.render.characters.character import load_character

    kept = []
    for number, section in enumerate(patch.character):
        with contextlib.suppress(PersonError):
            said = _file_of(section, number, path)
            load_character(said)
            kept.append(said)
    return tuple(kept)


def character_springs(patch: Patch, path: Path) -> dict[str, SpringRig]:
    """Return the springs of a patch's characters that can be drawn now, by name."""
    if not patch.character:
        return {}
    from live.render.characters.character import load_character

    return {said.name: load_character(said).springs.rig for said in drawable_characters(patch, path)}


def bodies_of(patch: Patch) -> tuple[str, ...]:
    """Return the body of each dancer, or nothing if all have the usual one.

    Bodies are drawn from the bodies or characters of the dancer's first group. For dancers in reserve, they are drawn
    from the bodies of all others.
    """
    if not patch.character and all(group.bodies is None for group in patch.group):
        return ()
    chance = np.random.default_rng([patch.seed, _BODIES_SEED])
    chosen = np.random.default_rng([patch.seed, _CHARACTERS_SEED])
    names: list[str] = []
    for group in patch.group:
        bodies = group.bodies or (DEFAULT_BODY,)
        drawn = [bodies[index] for index in chance.integers(len(bodies), size=group.dancers).tolist()]
        worn = [each.name for each in patch.character if _wears(each, group.name)]
        if worn:
            drawn = [worn[index] for index in chosen.integers(len(worn), size=group.dancers).tolist()]
        names += drawn
    for each in patch.character:
        for dancer in each.dancers:
            names[dancer - 1] = each.name
    if patch.character:
        names += [names[index] for index in chosen.integers(len(names), size=patch.reserve).tolist()]
    return tuple(names)


def _wears(each: CharacterSection, group: str) -> bool:
    if not each.groups:
        return not each.dancers
    return any(name.casefold() == group.casefold() for name in each.groups)
