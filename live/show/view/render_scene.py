"""Initial scene of the renderer, built from a patch."""

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from live.base.body.catalogue import BODIES, DEFAULT_BODY, CharacterFile
from live.base.errors import PersonError, error_context
from live.base.projector_perspective import camera_from_corners
from live.base.set_geometry import SetItem
from live.base.stage_snapshot import GROUP_COLOURS, Background, Camera, Scene, SceneryFile
from live.motion.formats.file_error import MotionFileError
from live.motion.skeleton import JOINT_COUNT
from live.render.lettering.distance_field import EM, read_font
from live.render.media.media_files import NUMBER_SIGN, check_media
from live.render.media.set_model import read_set_model
from live.show.dancers.character_casting import bodies_of
from live.show.desk.look_settings import group_settings, world_settings
from live.show.desk.parameter_table import parse_value, split_key
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_resource
from live.show.patch.section_base import Setting, parameter_values
from live.show.patch.section_motion import GroupSection
from live.show.patch.section_stage import AnyCamera

if TYPE_CHECKING:
    from live.render.renderer import Renderer


def projector_camera(patch: Patch) -> Camera | None:
    """Return the camera of a patch's `[projector]`, if it has one; PersonError if no projector matches it."""
    section = patch.projector
    if section is None:
        return None
    with error_context("projector.corners", ("projector", "corners")):
        return camera_from_corners(section.at, section.corners, (patch.stage.width, patch.stage.depth), section.aspect)


def camera_of_section(section: AnyCamera) -> Camera:
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
            file = "" if section.file is None else _background_file(section.file, path, number)
        keys = section.model_dump(exclude={"name", "file", "input", "seen"})
        found.append(Background(file, **keys, input=section.input or ""))
    return tuple(found)


def _background_file(name: str, path: Path, number: int) -> str:
    with error_context("file", ("background", number, "file")):
        if NUMBER_SIGN in name:
            folder = find_resource(str(Path(name).parent), path)
            file = None if folder is None else folder / Path(name).name
        else:
            file = find_resource(name, path)
        if file is None:
            raise PersonError(f"there is no {name!r}", f"put it next to {path.name}, or correct the name")
        check_media(file)
    return str(file)


def make_scenery(patch: Patch, path: Path, *, whole: bool = True) -> tuple[SceneryFile, ...]:
    """Return the set pieces of the patch at `path`; PersonError for a file that is missing or cannot be drawn.

    Unless `whole`, such a set piece has no file and is not drawn.
    """
    found = []
    for number, section in enumerate(patch.scenery):
        file = ""
        with contextlib.nullcontext() if whole else contextlib.suppress(PersonError):
            file = _scenery_file(section.file, path, number)
        found.append(SceneryFile(file, **section.model_dump(exclude={"name", "file", "seen"})))
    return tuple(found)


def _scenery_file(name: str, path: Path, number: int) -> str:
    with error_context("file", ("scenery", number, "file")):
        file = find_resource(name, path)
        if file is None:
            raise PersonError(f"there is no {name!r}", f"put it next to {path.name}, or correct the name")
        try:
            read_set_model(file)
        except MotionFileError as error:
            raise PersonError(f"{name!r}: {error.problem}", error.expected) from None
    return str(file)


def make_fonts(patch: Patch, path: Path, *, whole: bool = True) -> tuple[tuple[str, str], ...]:
    """Return names and files of the fonts of the patch at `path`; PersonError for one that cannot be read.

    Unless `whole`, such a font is left out, and the usual one is drawn.
    """
    found: dict[str, str] = {}
    places = [(("title", number, "font"), each.font) for number, each in enumerate(patch.title)]
    for place, name in (*places, (("words", "font"), patch.words.font)):
        if name is None or name in found:
            continue
        with contextlib.nullcontext() if whole else contextlib.suppress(PersonError), error_context("font", place):
            file = find_resource(name, path)
            if file is None:
                raise PersonError(f"there is no {name!r}", f"put it next to {path.name}, or correct the name")
            try:
                read_font(str(file), EM)
            except (OSError, ValueError):
                raise PersonError(f"{name!r} is no font that can be read", "a .ttf or .otf file") from None
            found[name] = str(file)
    return tuple(found.items())


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
    world = {} if patch.look.world is None else world_settings(patch, patch.look.world)
    of_stage = {address: value for address, value in world.items() if split_key(address)[1] == "*"}
    styles = tuple(
        tuple((address, parse_value(address, value)) for address, value in _draw_values(world, group).items())
        for group in patch.group
    )
    known = {*BODIES, *(each.name for each in characters)}
    return Scene(
        stage_size=(patch.stage.width, patch.stage.depth),
        camera=initial_camera(patch),
        dancer_count=patch.dancer_count,
        joint_count=JOINT_COUNT,
        group_colours=colours,
        group_styles=styles,
        backgrounds=() if path is None else make_backgrounds(patch, path, whole=whole),
        scenery=() if path is None else make_scenery(patch, path, whole=whole),
        fonts=() if path is None else make_fonts(patch, path, whole=whole),
        items=set_items(patch),
        passes=patch.picture.passes,
        custom_passes=patch.picture.own_passes,
        start_values=(*_numbers(of_stage), *patch.picture.set.items(), *parameter_values("look", patch.look).items()),
        bodies=tuple(name if name in known else DEFAULT_BODY for name in bodies_of(patch)),
        characters=characters,
    )


def _draw_values(world: Mapping[str, Setting], group: GroupSection) -> dict[str, Setting]:
    """Return a group's drawing style by address: what its world sets, then its own."""
    of_world = {split_key(key)[0]: value for key, value in world.items() if split_key(key)[1] == group.name.strip()}
    return of_world | group_settings(group.name, group.draw)[0]


def _numbers(settings: Mapping[str, Setting]) -> Iterator[tuple[str, float | tuple[float, ...]]]:
    for address, value in settings.items():
        numbers = parse_value(address, value)
        yield address, numbers[0] if len(numbers) == 1 else numbers
