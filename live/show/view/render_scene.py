"""Initial scene of the renderer, built from a patch."""

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from live.base.body.catalogue import BODIES, DEFAULT_BODY, CharacterFile
from live.base.errors import PersonError, error_context
from live.base.projector_perspective import camera_from_corners
from live.base.set_geometry import SetItem
from live.base.stage_snapshot import GROUP_COLOURS, Background, Camera, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.media_background import check_background
from live.show.dancers.character_casting import bodies_of
from live.show.desk.look_settings import group_settings
from live.show.desk.parameter_table import parse_value
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_resource
from live.show.patch.section_base import parameter_values
from live.show.patch.section_stage import CameraSection

if TYPE_CHECKING:
    from live.render.renderer import Renderer


def projector_camera(patch: Patch) -> Camera | None:
    """Return the camera of a patch's `[projector]`, if it has one; PersonError if no projector matches it."""
    section = patch.projector
    if section is None:
        return None
    with error_context("projector.corners", ("projector", "corners")):
        return camera_from_corners(section.at, section.corners, (patch.stage.width, patch.stage.depth), section.aspect)


def camera_of_section(section: CameraSection) -> Camera:
    """Return the camera of a `[camera]` or `[[view]]`."""
    return Camera(section.eye, section.target, section.field_of_view_deg, section.roll_deg, section.shift)


def initial_camera(patch: Patch) -> Camera:
    """Return the initial camera: `[camera]` if the patch has it, else that of the `[projector]`."""
    projector = None if "camera" in patch.model_fields_set else projector_camera(patch)
    return projector or camera_of_section(patch.camera)


def make_backgrounds(patch: Patch, path: Path, *, whole: bool = True) -> tuple[Background, ...]:
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
    with error_context("file", ("background", number, "file")):
        file = find_resource(name, path)
        if file is None:
            raise PersonError(f"there is no {name!r}", f"put it next to {path.name}, or correct the name")
        check_background(file)
    return str(file)


def set_items(patch: Patch) -> tuple[SetItem, ...]:
    """Return the props of a patch."""
    return tuple(SetItem(**section.model_dump(exclude={"name"})) for section in patch.item)


def draw_patch(renderer: "Renderer", patch: Patch) -> None:
    """Have a running renderer draw the stage, the props and the custom passes of another patch.

    PersonError if a pass does not compile: its last version stays.
    """
    renderer.set_stage((patch.stage.width, patch.stage.depth), set_items(patch))
    renderer.set_custom_passes(patch.picture.own_passes)


def make_scene(
    patch: Patch, path: Path | None = None, characters: tuple[CharacterFile, ...] = (), *, whole: bool = True
) -> Scene:
    """Return the scene of a patch; `characters`: the files of its own characters. `whole`: see `make_backgrounds`."""
    colours = tuple(
        group.colour if group.colour is not None else GROUP_COLOURS[i % len(GROUP_COLOURS)]
        for i, group in enumerate(patch.group)
    )
    drawn = [group_settings(group.name, group.draw)[0] for group in patch.group]
    styles = tuple(tuple((address, parse_value(address, value)) for address, value in one.items()) for one in drawn)
    known = {*BODIES, *(each.name for each in characters)}
    return Scene(
        stage_size=(patch.stage.width, patch.stage.depth),
        camera=initial_camera(patch),
        dancer_count=patch.dancer_count,
        joint_count=JOINT_COUNT,
        group_colours=colours,
        group_styles=styles,
        backgrounds=() if path is None else make_backgrounds(patch, path, whole=whole),
        items=set_items(patch),
        passes=patch.picture.passes,
        custom_passes=patch.picture.own_passes,
        start_values=(*patch.picture.set.items(), *parameter_values("look", patch.look).items()),
        bodies=tuple(name if name in known else DEFAULT_BODY for name in bodies_of(patch)),
        characters=characters,
    )
