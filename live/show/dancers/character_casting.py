"""The characters of a patch: where their files are, whether they can be drawn, and which dancers wear them."""

import contextlib
from pathlib import Path

import numpy as np

from live.base.body_catalogue import USUAL, CharacterFile, Worn
from live.base.errors import PersonError
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import find_beside
from live.show.patch.section_picture import CharacterSection

_BODIES_SEED = 23
_CHARACTERS_SEED = 29


def files_of(patch: Patch, path: Path) -> tuple[CharacterFile, ...]:
    """The patch's characters with their files; `path` is the patch's own. PersonError for a file that is not there."""
    return tuple(_file_of(section, number, path) for number, section in enumerate(patch.character))


def _file_of(section: CharacterSection, number: int, path: Path) -> CharacterFile:
    place = ("character", number, "file")
    found = find_beside(section.file, path)
    if found is None or not found.is_file():
        raise PersonError(f"there is no file {section.file!r}", f"put it beside {path.name}", place)
    if Path(section.file).is_absolute() or not found.resolve().is_relative_to(path.parent.resolve()):
        raise PersonError(f"{section.file!r} lies outside of {path.parent}", "copy it into the patch's folder", place)
    materials = tuple(
        (name, Worn(changed.colour, changed.sheen, changed.hidden)) for name, changed in section.materials.items()
    )
    return CharacterFile(section.name, str(found), tuple(section.joints.items()), materials)


def check_characters(patch: Patch, path: Path) -> None:
    """Read all characters of a patch; PersonError, with its place, for one that cannot be drawn."""
    if not patch.character:
        return
    from live.render.characters.character import load_character  # images and their decoders

    for number, said in enumerate(files_of(patch, path)):
        try:
            load_character(said)
        except PersonError as error:
            raise PersonError(error.message, error.remedy, ("character", number, "file")) from None


def drawable(patch: Patch, path: Path) -> tuple[CharacterFile, ...]:
    """The characters of a patch that can be drawn now: whoever goes on with a show takes what there is."""
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


def bodies_of(patch: Patch) -> tuple[str, ...]:
    """The body of each dancer, drawn from the bodies or characters of the group in which she begins, then of those in
    reserve, drawn from everybody's; nothing if all have the usual one."""
    if not patch.character and all(group.bodies is None for group in patch.group):
        return ()
    chance = np.random.default_rng([patch.seed, _BODIES_SEED])
    chosen = np.random.default_rng([patch.seed, _CHARACTERS_SEED])
    names: list[str] = []
    for group in patch.group:
        bodies = group.bodies or (USUAL,)
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
