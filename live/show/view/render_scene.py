"""Initial scene of the renderer, built from a patch."""

import contextlib
from dataclasses import fields
from pathlib import Path
from typing import Final

from live.base.body_catalogue import BODIES, USUAL, CharacterFile
from live.base.errors import PersonError, named
from live.base.projector_perspective import matched
from live.base.set_geometry import Item
from live.base.stage_snapshot import Background, Camera, Look, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.media_background import check_background
from live.show.dancers.character_casting import bodies_of
from live.show.desk.parameter_table import numbers_of
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import find_beside
from live.show.patch.section_picture import drawn
from live.show.patch.section_stage import CameraSection

_LOOK: Final = {field.name for field in fields(Look)}


def projector_camera(patch: Patch) -> Camera | None:
    """Return the camera of a patch's `[projector]`, if it has one; PersonError if no projector matches it."""
    section = patch.projector
    if section is None:
        return None
    with named("projector.corners", ("projector", "corners")):
        return matched(section.at, section.corners, (patch.stage.width, patch.stage.depth), section.aspect)


def camera_of_section(section: CameraSection) -> Camera:
    """Return the camera of a `[camera]` or `[[view]]`."""
    return Camera(section.eye, section.target, section.field_of_view_deg, section.roll_deg, section.shift)


def camera_at_first(patch: Patch) -> Camera:
    """Return the initial camera: `[camera]` if the patch has it, else that of the `[projector]`."""
    projector = None if "camera" in patch.model_fields_set else projector_camera(patch)
    return projector or camera_of_section(patch.camera)


def backgrounds_of(patch: Patch, path: Path, *, whole: bool = True) -> tuple[Background, ...]:
    """Return the backgrounds of the patch at `path`; PersonError for a file that is missing or cannot be shown.

    Unless `whole`, such a background has no file and is not drawn.
    """
    found = []
    for number, section in enumerate(patch.background):
        file = ""
        with contextlib.nullcontext() if whole else contextlib.suppress(PersonError):
            file = _background_file(section.file, path, number)
        keys = section.fit, section.beats, section.width, section.bottom, section.brightness
        found.append(Background(file, *keys))
    return tuple(found)


def _background_file(name: str, path: Path, number: int) -> str:
    with named("file", ("background", number, "file")):
        file = find_beside(name, path)
        if file is None:
            raise PersonError(f"there is no {name!r}", f"put it next to {path.name}, or correct the name")
        check_background(file)
    return str(file)


def scene_of(
    patch: Patch, path: Path | None = None, characters: tuple[CharacterFile, ...] = (), *, whole: bool = True
) -> Scene:
    """Return the scene of a patch; `characters`: the files of its own characters. `whole`: see `backgrounds_of`."""
    look = {key: value for key, value in patch.look.model_dump().items() if value is not None and key in _LOOK}
    defaults = Look()
    colours = tuple(
        group.colour if group.colour is not None else defaults.group_colours[i % len(defaults.group_colours)]
        for i, group in enumerate(patch.group)
    )
    styles = tuple(
        tuple((address, numbers_of(address, value)) for address, value in drawn(group.draw).items())
        for group in patch.group
    )
    known = {*BODIES, *(each.name for each in characters)}
    return Scene(
        stage_size=(patch.stage.width, patch.stage.depth),
        look=Look(**look, group_colours=colours, group_styles=styles),
        camera=camera_at_first(patch),
        dancer_count=patch.dancer_count,
        joint_count=JOINT_COUNT,
        backgrounds=() if path is None else backgrounds_of(patch, path, whole=whole),
        items=tuple(Item(**section.model_dump()) for section in patch.item),
        passes=patch.picture.passes,
        own=patch.picture.own_passes,
        start=patch.picture.start(),
        bodies=tuple(name if name in known else USUAL for name in bodies_of(patch)),
        characters=characters,
    )
