"""Patch sections for stage, set, backgrounds, steering, projector, cameras and light (also `[[view]]`, `[[looks]]`)."""

from typing import Annotated, Final, Literal, Self

from pydantic import Field, ValidationInfo, model_validator

from live.base.errors import PersonError
from live.base.floor_corners import check_corners
from live.base.parameter import WORLD_NAMES
from live.base.stage_snapshot import parse_input
from live.show.patch.section_base import (
    Colour,
    Draw,
    InvalidEntry,
    Measures,
    Name,
    Place,
    Section,
    Share,
    WorldCoordinate,
    parameter_section,
    run_check,
)

Extent = Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)]
Shift = Annotated[float, Field(ge=-5, le=5, allow_inf_nan=False)]


class StageSection(Section):
    """`[stage]`: size of the floor."""

    width: Annotated[float, Field(ge=2, le=200)] = 12.0
    """Metres from side to side."""
    depth: Annotated[float, Field(ge=2, le=200)] = 8.0
    """Metres from back to front."""


class GateSection(Section):
    """`[[gate]]`: an entrance in the stage's edge; without any there are left, right and back."""

    name: Name
    """Its name for `/dance/enter` and `/dance/leave`."""
    at: Place
    """A point near its place on the edge (x, z) [m]."""
    width: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] = 3.0
    """Width [m]."""


class ObstacleSection(Section):
    """`[[obstacle]]`: an object that dancers avoid; they go around round ones, and slide along walls."""

    name: Name
    """Its name for `/dance/obstacle`."""
    at: Place
    """Its centre (x, z) [m]; for a wall one end."""
    radius: Annotated[float, Field(gt=0, le=50, allow_inf_nan=False)] = 0.5
    """Its radius [m]; without effect for a wall."""
    wall_to: Place | None = None
    """Makes it a wall from `at` to this point (x, z) [m]."""


class ItemSection(Section):
    """`[[item]]`: an item of the set that is drawn; an `[[obstacle]]` at its place keeps dancers away from it."""

    name: Name | None = None
    """Its name for edits of the show's files."""
    form: Literal["box", "cylinder", "steps"] = "box"
    """Its shape."""
    at: Place
    """Its centre (x, z) [m]."""
    size: tuple[Extent, Extent, Extent] = (1.0, 0.5, 1.0)
    """Width, height and depth [m]."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Rotation: 0 faces the audience, positive towards +x."""
    lift: Annotated[float, Field(ge=0, le=50)] = 0.0
    """Height of its underside above the floor [m]."""
    colour: Colour = (0.10, 0.10, 0.12)
    """Its colour."""
    steps: Annotated[int, Field(ge=1, le=40)] = 4
    """Number of steps for `steps`; they rise away from the audience."""


class BackgroundSection(Section):
    """`[[background]]`: an image, a video, an image sequence or a live input, behind, below or in front of the dancers,
    shown by `/dance/background`."""

    name: Name
    """Its name for `/dance/background`."""
    file: Annotated[str, Field(min_length=1, max_length=400)] | None = None
    """The file, looked up in the patch's folder, then in the project's patches; `rain_####.png` is a sequence of
    numbered images, a sign for each digit."""
    input: Annotated[str, Field(min_length=1, max_length=400)] | None = None
    """Instead of a file: a capture device `camera:0`, another show's `shm:NAME`, or a stream such as
    `udp://0.0.0.0:5000`."""
    place: Literal["behind", "floor", "front"] = "behind"
    """Behind the dancers, on the floor, or in front of them, as a gauze."""
    fit: Literal["wall", "picture"] = "wall"
    """A rectangle in the space (at the back it is on the wall), or over the whole picture."""
    at: Place | None = None
    """Its centre (x, z) [m]; left out: on the back wall, in the middle of the floor, or at the stage's front edge."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Rotation on the floor: 0 reads from the audience, positive as a dancer turns towards +x."""
    blend: Literal["over", "add"] = "over"
    """Whether it covers what is behind it (where it is not transparent), or adds its light: black is clear then."""
    end: Literal["loop", "hold"] = "loop"
    """What a video or sequence does at its end: it loops, or it holds its last picture; it begins when it is shown."""
    fps: Annotated[float, Field(gt=0, le=240)] = 25.0
    """Pictures per second of an image sequence."""
    beats: Annotated[float, Field(gt=0, le=4096)] | None = None
    """Beats in which a video or sequence runs once; left out: at its own speed."""
    width: Annotated[float, Field(gt=0, le=500)] | None = None
    """Width [m]; left out: 1.5 times the stage's, on the floor the stage's."""
    bottom: Annotated[float, Field(ge=-5, le=50)] = 0.0
    """Height of its lower edge above the floor [m]."""
    brightness: Annotated[float, Field(ge=0, le=4)] = 0.8
    """Brightness."""
    seen: Share = 0.0
    """Opacity when the show begins."""

    @model_validator(mode="after")
    def _shows_something(self) -> "BackgroundSection":
        if (self.file is None) == (self.input is None):
            raise ValueError(f"{self.name!r} needs a file or an input, and one of them only")
        if self.place == "floor" and self.fit == "picture":
            raise InvalidEntry(
                'a picture on the floor cannot fill the picture: leave fit out, or place = "behind"', "fit"
            )
        if self.input is not None:
            try:
                parse_input(self.input)
            except PersonError as error:
                raise InvalidEntry(str(error), "input") from None
        return self


class ScenerySection(Section):
    """`[[scenery]]`: a set piece from a glTF file that stands on the stage, shown by `/dance/scenery`. An
    `[[obstacle]]` at its place keeps dancers away from it."""

    name: Name
    """Its name for edits of the show's files."""
    file: Annotated[str, Field(min_length=1, max_length=400)]
    """A .glb or .gltf file in the patch's folder or below it: `set/tree.glb`."""
    at: Place = (0.0, 0.0)
    """Where the middle of its underside stands (x, z) [m]."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Rotation: 0 as in the file, positive as a dancer turns towards +x."""
    lift: Annotated[float, Field(ge=-20, le=50)] = 0.0
    """Height of its underside above the floor [m]."""
    scale: Annotated[float, Field(gt=0, le=1000)] = 1.0
    """Factor of the file's metres."""
    height: Annotated[float, Field(gt=0, le=100)] | None = None
    """Its height [m], instead of `scale`."""
    seen: Share = 1.0
    """How much of it is seen when the show begins."""


class SteeringSection(Section):
    """`[steering]`: collision avoidance, and how the commands of several elements are combined."""

    avoidance: Literal["predictive", "thesis"] = "predictive"
    """By predicted time to collision, or by two distances as in the thesis (T108)."""
    combine: Literal["blended", "switched"] = "blended"
    """Commands of several elements are summed, or the more urgent ones use up the speed first (T083)."""
    acceleration: Annotated[float, Field(gt=0, le=50)] = 6.0
    """Largest acceleration [m/s²]."""
    turn_deg_s: Annotated[float, Field(ge=10, le=3600)] = 290.0
    """Largest turn rate of the path [degrees per second]."""
    separation: Annotated[float, Field(ge=0, le=3)] = 1.25
    """Distance [m] below which dancers moved by elements separate."""
    near: Annotated[float, Field(ge=0, le=10)] = 0.8
    """d_s of the thesis' rule [m]: nearer than this only the other dancer counts, and the speed is limited."""
    far: Annotated[float, Field(ge=0, le=10)] = 2.0
    """d_f of the thesis' rule [m]: nearer than this all forces are combined."""

    @model_validator(mode="after")
    def _near_is_nearer(self) -> "SteeringSection":
        if self.near >= self.far:
            raise ValueError(f"near {self.near:g} has to be less than far {self.far:g}")
        return self


class AnyCamera(parameter_section("camera")):  # type: ignore[misc]
    """Position [m], direction, lens and motion of a camera."""

    shift: tuple[Shift, Shift] = (0.0, 0.0)
    """Lens shift of the picture to the right, in widths, and upwards, in heights."""
    orbit_measures: Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)] = 0.0
    """Measures of one orbit around the target, to the right; below 0 to the left, 0: no orbit."""
    follow: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Dancers that it follows: groups, attributes, numbers and places as in `ember & left + 12`; * is all."""

    @model_validator(mode="after")
    def _look_somewhere(self) -> Self:
        if sum((a - b) ** 2 for a, b in zip(self.eye, self.target, strict=True)) < 1e-6:
            raise ValueError("eye and target are the same point: the camera looks nowhere")
        if 0.0 < abs(self.orbit_measures) < 0.25:
            raise ValueError(f"orbit_measures {self.orbit_measures:g}: once in a quarter of a measure is the fastest")
        return self

    @property
    def asks_for_director(self) -> bool:
        """Whether it names the director or a mood of it."""
        return self.director if "director" in self.model_fields_set else "mood" in self.model_fields_set


class CameraSection(AnyCamera):
    """`[camera]`: position [m], direction, lens and motion of the camera, or the mood of its director."""

    lock: bool = False
    """Whether the director never leads it, because the picture has to match the hall."""
    aspect: Annotated[float, Field(ge=0.2, le=10)] = 16 / 9
    """Aspect ratio of the picture for which the director frames, width by height."""

    @model_validator(mode="after")
    def _locked_or_directed(self) -> Self:
        if self.lock and self.asks_for_director:
            raise ValueError("lock = true keeps the director off this camera: leave out lock, or director and mood")
        return self


class ViewSection(AnyCamera):
    """`[[view]]`: a further camera, for `/dance/camera` and scenes."""

    name: Name
    """Its name."""


PROJECTOR: Final = "projector"
"""The view of a patch with a `[projector]`."""
FloorCorners = Annotated[tuple[tuple[Shift, Shift], ...], Field(min_length=4, max_length=4)]


class ProjectorSection(Section):
    """`[projector]`: its perspective, given by its position and the floor's corners in its picture."""

    at: tuple[WorldCoordinate, WorldCoordinate, WorldCoordinate]
    """Position of the projector's lens: x, y (up), z [m]."""
    corners: FloorCorners
    """The floor's corners in the picture: back left, back right, front right, front left as the audience sees them;
    each to the right and down, from 0 to 1."""
    aspect: Annotated[float, Field(gt=0.1, le=20)] = 16 / 9
    """Aspect ratio of that picture, width by height."""

    @model_validator(mode="after")
    def _corners_are_valid(self) -> "ProjectorSection":
        check_floor_corners(self.corners)
        return self


def check_floor_corners(corners: FloorCorners) -> None:
    """Raise Amiss, at `corners`, if no perspective of a floor has these corners."""
    try:
        check_corners(corners)
    except PersonError as error:
        raise InvalidEntry(str(error), "corners") from None


class LookSection(parameter_section("look", optional=True)):  # type: ignore[misc]
    """`[look]`: light and colour (linear RGB from 0 to 1); keys left out keep their defaults."""

    world: Literal[WORLD_NAMES] | None = None  # type: ignore[valid-type]
    """The world in which the show is danced: it has defaults of its own for all other keys."""

    key_direction: tuple[WorldCoordinate, WorldCoordinate, WorldCoordinate] | None = None
    """Direction of the key light, from the front: x, y (up), z; its length is ignored."""

    @model_validator(mode="after")
    def _light_goes_somewhere(self) -> "LookSection":
        if self.key_direction is not None and max(map(abs, self.key_direction)) < 1e-3:
            raise ValueError("key_direction is [0, 0, 0]: the light goes nowhere")
        return self


class NamedLookSection(LookSection):
    """`[[looks]]`: a further light setting, for `/dance/look` and scenes; keys left out keep their values."""

    name: Name
    """Its name."""
    measures: Measures = 1.0
    """Length of the cross-fade in measures, unless the call gives one."""
    draw: Draw = Field(default={})
    """How dancers are drawn, as in `[group.draw]`, for all groups or with a selection of dancers behind the key:
    `{ ink = 1, "solid ember & left" = 0 }`."""

    @model_validator(mode="after")
    def _draw_is_valid(self, info: ValidationInfo) -> "NamedLookSection":
        run_check(info, "looks", self)
        return self
