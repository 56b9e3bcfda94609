"""Stage, camera and light of a patch."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from live.base.errors import PersonError
from live.base.projector_perspective import check_corners
from live.show.patch.section_base import Amiss, Colour, Far, Name, Place, Section, Share

Extent = Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)]
Shift = Annotated[float, Field(ge=-5, le=5, allow_inf_nan=False)]


class StageSection(Section):
    """`[stage]`: size of the floor."""

    width: Annotated[float, Field(ge=2, le=200)] = 12.0
    """Metres from side to side."""
    depth: Annotated[float, Field(ge=2, le=200)] = 8.0
    """Metres from back to front."""


class GateSection(Section):
    """`[[gate]]`: an opening in the stage's edge for dancers who come and go; left, right and back if there is none."""

    name: Name
    """What `/dance/enter` and `/dance/leave` call it."""
    at: Place
    """Near which place of the edge it is (x, z) [m]."""
    width: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] = 3.0
    """How wide it is [m]."""


class ObstacleSection(Section):
    """`[[obstacle]]`: an item of the set; dancers go around round ones, and slide along walls."""

    name: Name
    """What `/dance/obstacle` calls it."""
    at: Place
    """Its middle (x, z) [m]; of a wall, where it begins."""
    radius: Annotated[float, Field(gt=0, le=50, allow_inf_nan=False)] = 0.5
    """How far it reaches around that [m]; of no meaning for a wall."""
    wall_to: Place | None = None
    """It is a wall from `at` to here (x, z) [m]."""


class ItemSection(Section):
    """`[[item]]`: an item of the set that is drawn; an `[[obstacle]]` at its place keeps dancers away from it."""

    form: Literal["box", "cylinder", "steps"] = "box"
    """What it is."""
    at: Place
    """Its middle (x, z) [m]."""
    size: tuple[Extent, Extent, Extent] = (1.0, 0.5, 1.0)
    """Width, height and depth [m]."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """How far it is turned: 0 faces the audience, positive towards +x."""
    lift: Annotated[float, Field(ge=0, le=50)] = 0.0
    """How high its underside is above the floor [m]."""
    colour: Colour = (0.10, 0.10, 0.12)
    """Its colour."""
    steps: Annotated[int, Field(ge=1, le=40)] = 4
    """How many steps `steps` have; they rise away from the audience."""


class BackgroundSection(Section):
    """`[[background]]`: an image or a video behind the dancers, seen by `/dance/background`."""

    name: Name
    """What `/dance/background` calls it."""
    file: Annotated[str, Field(min_length=1, max_length=400)]
    """The file, looked up in the patch's folder, then in the project's patches."""
    fit: Literal["wall", "picture"] = "wall"
    """On the wall behind the stage, or over the whole picture, as for a projection on a gauze."""
    beats: Annotated[float, Field(gt=0, le=4096)] | None = None
    """A video comes again in so many beats; left out: as fast as it is."""
    width: Annotated[float, Field(gt=0, le=500)] | None = None
    """How wide it is on the wall [m]; left out: half as wide again as the stage."""
    bottom: Annotated[float, Field(ge=-5, le=50)] = 0.0
    """Its lower edge above the floor [m]."""
    brightness: Annotated[float, Field(ge=0, le=4)] = 0.8
    """How bright it is."""
    seen: Share = 0.0
    """How much of it is seen when the show begins."""


class SteeringSection(Section):
    """`[steering]`: how dancers make way for each other, and how their wishes are combined."""

    avoidance: Literal["predictive", "thesis"] = "predictive"
    """By the time to the collision that is coming, or by two distances as in the thesis (T108)."""
    combine: Literal["blended", "switched"] = "blended"
    """Wishes of several elements are summed, or the more urgent ones take the speed first (T083)."""
    acceleration: Annotated[float, Field(gt=0, le=50)] = 6.0
    """Largest acceleration [m/s²]."""
    turn_deg_s: Annotated[float, Field(ge=10, le=3600)] = 290.0
    """Fastest turn of the way [degrees a second]."""
    separation: Annotated[float, Field(ge=0, le=3)] = 1.25
    """Distance [m] under which dancers whom elements move push each other away."""
    near: Annotated[float, Field(ge=0, le=10)] = 0.8
    """d_s of the thesis' rule [m]: nearer than this only the other one counts, and the speed is limited."""
    far: Annotated[float, Field(ge=0, le=10)] = 2.0
    """d_f of the thesis' rule [m]: nearer than this all forces are combined."""

    @model_validator(mode="after")
    def _near_is_nearer(self) -> "SteeringSection":
        if self.near >= self.far:
            raise ValueError(f"near {self.near:g} has to be less than far {self.far:g}")
        return self


class CameraSection(Section):
    """`[camera]`: where the picture is seen from [m], vertical field of view [degrees]."""

    eye: tuple[Far, Far, Far] = (0.0, 3.4, 11.5)
    """Where the camera stands: x, y (up), z [m]."""
    target: tuple[Far, Far, Far] = (0.0, 0.9, 0.0)
    """What it looks at [m]."""
    field_of_view_deg: Annotated[float, Field(ge=5, le=120)] = 40.0
    """Vertical angle of view."""
    roll_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """How far it is turned about its axis, clockwise as seen from behind."""
    shift: tuple[Shift, Shift] = (0.0, 0.0)
    """Lens shift: how many of its widths to the right and of its heights above the axis the picture lies."""
    orbit_measures: Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)] = 0.0
    """It goes around what it looks at once in so many measures, to its right; below 0 to its left, 0: it stands."""
    follow: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Whom it follows: a group, or groups, attributes, numbers and places as in `ember & left + 12`; * is all."""
    along: Share = 0.0
    """How far it goes along with whom it follows; 0: it only turns, 1: it keeps its distance."""
    plan: Share = 0.0
    """How much of the plan is drawn: circles with triangles for dancers, and where they came from."""

    @model_validator(mode="after")
    def _look_somewhere(self) -> "CameraSection":
        if sum((a - b) ** 2 for a, b in zip(self.eye, self.target, strict=True)) < 1e-6:
            raise ValueError("eye and target are the same point: the camera looks nowhere")
        if 0.0 < abs(self.orbit_measures) < 0.25:
            raise ValueError(f"orbit_measures {self.orbit_measures:g}: once in a quarter of a measure is the fastest")
        return self


FloorCorners = Annotated[tuple[tuple[Shift, Shift], ...], Field(min_length=4, max_length=4)]


class ProjectorSection(Section):
    """`[projector]`: its perspective, from where it stands and where the floor's corners are in its picture."""

    at: tuple[Far, Far, Far]
    """Where the projector's lens is: x, y (up), z [m]."""
    corners: FloorCorners
    """Where the picture has the floor's corners: back left, back right, front right, front left as the audience sees
    them; each to the right and down, from 0 to 1."""
    aspect: Annotated[float, Field(gt=0.1, le=20)] = 16 / 9
    """Width of that picture by its height."""

    @model_validator(mode="after")
    def _a_floor(self) -> "ProjectorSection":
        refuse_no_floor(self.corners)
        return self


def refuse_no_floor(corners: FloorCorners) -> None:
    """Amiss, at `corners`, for corners that no floor has in a picture."""
    try:
        check_corners(corners)
    except PersonError as error:
        raise Amiss(str(error), "corners") from None


class LookSection(Section):
    """`[look]`: light and colour (linear RGB from 0 to 1); what is left out keeps its default."""

    background: Colour | None = None
    """Colour of the dark behind the stage."""
    floor: Colour | None = None
    """Colour of the floor."""
    key_light: Colour | None = None
    """Colour of the light from the front, which casts the shadows."""
    key: Annotated[float, Field(ge=0, le=4)] | None = None
    """Strength of the light from the front; 1 is usual."""
    key_direction: tuple[Far, Far, Far] | None = None
    """Where it goes: x, y (up), z."""
    rim_light: Colour | None = None
    """Colour of the light from behind."""
    rim: Annotated[float, Field(ge=0, le=4)] | None = None
    """Strength of the light from behind; 1 is usual."""
    ambient: Share | None = None
    """Strength of the light from everywhere."""
    ambient_colour: Colour | None = None
    """Tint of the light from everywhere."""
    level: Annotated[float, Field(ge=0, le=2)] | None = None
    """All light together; 1 is usual."""
    saturation: Annotated[float, Field(ge=0, le=2)] | None = None
    """How colourful all is; 0 is black and white."""
    haze: Annotated[float, Field(ge=0, le=1)] | None = None
    """How fast the depth of the stage fades [1/m]."""
    side: Annotated[float, Field(ge=0, le=4)] | None = None
    """Strength of the light from both sides; none if nothing is said."""
    side_left: Colour | None = None
    """Colour of the light from the left."""
    side_right: Colour | None = None
    """Colour of the light from the right."""
    back: Annotated[float, Field(ge=0, le=4)] | None = None
    """Strength of the light from straight behind and above."""
    back_light: Colour | None = None
    """Its colour."""
    beams: Annotated[float, Field(ge=0, le=4)] | None = None
    """Strength of the beams that are seen in the haze."""
    beams_colour: Colour | None = None
    """Colour of every other beam; those between are warmer."""
    beams_width: Annotated[float, Field(ge=0.01, le=0.5)] | None = None
    """How fast a beam grows wider on its way."""
    beams_fan: Annotated[float, Field(ge=-2, le=2)] | None = None
    """Where the beams meet the floor: 1 below their lamps, 0 all in the middle, -1 crossed."""
    beams_sway: Share | None = None
    """How far the beams swing, there and back in eight beats."""
    pulse: Share | None = None
    """How much all light answers the beat."""
    energy: Share | None = None
    """How much all light follows the energy of the music."""
    stage: Share | None = None
    """How much of floor and wall is seen; 0: dancers alone before true black, as for a gauze."""
    gradient: Share | None = None
    """How much the wall behind is a gradient of two colours."""
    gradient_top: Colour | None = None
    """Its colour above."""
    gradient_bottom: Colour | None = None
    """Its colour at the floor."""

    @model_validator(mode="after")
    def _light_goes_somewhere(self) -> "LookSection":
        if self.key_direction is not None and max(map(abs, self.key_direction)) < 1e-3:
            raise ValueError("key_direction is [0, 0, 0]: the light goes nowhere")
        return self
