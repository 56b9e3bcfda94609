"""The picture's parameters: light, colours and camera as one row of numbers that may change while a show runs.

One table says all of them, with address, range, start value and unit: controls, scenes, fades, the reference and the
renderer are made from it. A new one is a new line here, and a use in the renderer. Colours are linear RGB.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base import cameras, lights, styles
from live.base.custom_pass import MOST_PASSES, NUMBERS, own_numbers
from live.base.stage_snapshot import Camera, Look, Scene
from live.base.styles import Kind

Float64 = npt.NDArray[np.float64]

GROUPS: Final = 16
"""Groups that have a colour of their own."""
COLOUR_OF_GROUP: Final = "/dance/group/colour"


@dataclass(frozen=True, slots=True)
class PictureParameter:
    """One parameter: a number, a colour (r, g, b) or a place or direction (x, y, z)."""

    address: str
    kind: Kind
    low: float
    high: float
    start: tuple[float, ...]
    """Where it is if patch and scene say nothing."""
    unit: str
    words: str
    first: int
    """Where its first number lies in the row."""

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return 1 if self.kind == "number" else 3

    @property
    def where(self) -> slice:
        """Its numbers in the row."""
        return slice(self.first, self.first + self.size)


_LOOK: Final = Look()
_CAMERA: Final = Camera()
_Line = tuple[str, Kind, float, float, tuple[float, ...], str, str]
_LINES: Final[tuple[_Line, ...]] = (
    ("/dance/light/level", "number", 0, 2, (1.0,), "", "All light together; 1 is the usual light, 0 is dark."),
    ("/dance/light/key", "number", 0, 4, (1.0,), "", "Strength of the light from the front, which casts the shadows."),
    ("/dance/light/key/colour", "colour", 0, 1, _LOOK.key_light, "", "Colour of the light from the front."),
    (
        "/dance/light/key/direction", "place", -100, 100, _LOOK.key_direction, "",
        "Where the light from the front goes: x, y (up), z; its length means nothing.",
    ),
    ("/dance/light/rim", "number", 0, 4, (1.0,), "", "Strength of the light from behind, and of its beams."),
    ("/dance/light/rim/colour", "colour", 0, 1, _LOOK.rim_light, "", "Colour of the light from behind."),
    ("/dance/light/ambient", "number", 0, 1, (_LOOK.ambient,), "", "Strength of the light from everywhere."),
    ("/dance/light/ambient/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Tint of the light from everywhere."),
    ("/dance/light/haze", "number", 0, 1, (_LOOK.haze,), "1/m", "How fast the depth of the stage fades."),
    ("/dance/light/background", "colour", 0, 1, _LOOK.background, "", "Colour of the dark behind the stage."),
    ("/dance/light/floor", "colour", 0, 1, _LOOK.floor, "", "Colour of the floor."),
    ("/dance/light/saturation", "number", 0, 2, (1.0,), "", "How colourful all is; 0 is black and white."),
    ("/dance/camera/eye", "place", -1000, 1000, _CAMERA.eye, "m", "Where the camera stands: x, y (up), z."),
    ("/dance/camera/target", "place", -1000, 1000, _CAMERA.target, "m", "What the camera looks at: x, y (up), z."),
    (
        "/dance/camera/field_of_view", "number", 5, 120, (_CAMERA.field_of_view_deg,), "degrees",
        "The camera's vertical angle of view.",
    ),
    *cameras.LINES,
    *lights.LINES,
    ("/dance/pass/shadow", "number", 0, 1, (1.0,), "", "How dark the dancers' shadows are; 0: none."),
    ("/dance/pass/mirror", "number", 0, 1, (1.0,), "", "How bright the dancers' images in the floor are; 0: none."),
    (
        "/dance/pass/trails", "number", 0, 1, (0.0,), "",
        "Trails behind whatever is bright and moves; less is shorter, 0: none.",
    ),
    (
        "/dance/pass/trails/beats", "number", 0.05, 64, (1.0,), "beats",
        "After how many beats a trail is half as bright.",
    ),
    ("/dance/pass/trails/zoom", "number", -2, 2, (0.0,), "1/beat", "How fast trails grow out of the middle."),
    ("/dance/pass/trails/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "What white trails turn to as they fade."),
    ("/dance/pass/bloom", "number", 0, 4, (1.0,), "", "Glow around what is bright, where quality allows; 0: none."),
    ("/dance/pass/ink", "number", 0, 1, (0.0,), "", "Lines of ink around dancers and where they bend; 0: none."),
    ("/dance/pass/ink/width", "number", 0.5, 8, (1.5,), "px", "How wide they are, in a picture of 720 lines."),
    ("/dance/pass/ink/colour", "colour", 0, 1, (0.004, 0.004, 0.008), "", "Colour of the ink."),
    ("/dance/pass/ink/paper", "number", 0, 1, (0.0,), "", "How much the picture under the ink gives way to paper."),
    ("/dance/pass/ink/paper/colour", "colour", 0, 1, (0.90, 0.80, 0.64), "", "Colour of the paper."),
    ("/dance/pass/grade", "number", 0, 1, (1.0,), "", "How much of the colour grade is seen."),
    ("/dance/pass/grade/lift", "colour", -1, 1, (0.0, 0.0, 0.0), "", "What the grade adds to the darks."),
    ("/dance/pass/grade/gamma", "colour", 0.2, 5, (1.0, 1.0, 1.0), "", "How bright the grade makes the middle."),
    ("/dance/pass/grade/gain", "colour", 0, 4, (1.0, 1.0, 1.0), "", "By what the grade multiplies the brights."),
    ("/dance/pass/grade/contrast", "number", 0, 2, (1.0,), "", "Contrast about mid grey."),
    ("/dance/pass/grade/temperature", "number", -1, 1, (0.0,), "", "Colder below 0, warmer above."),
    ("/dance/pass/vignette", "number", 0, 1.5, (1.0,), "", "How much darker the picture's corners are; 0: not at all."),
)  # fmt: skip


def _laid_out() -> tuple[PictureParameter, ...]:
    first, table = 0, []
    for address, kind, low, high, start, unit, words in _LINES:
        table.append(PictureParameter(address, kind, low, high, start, unit, words, first))
        first += table[-1].size
    return tuple(table)


PARAMETERS: Final = _laid_out()
"""All of them but what every group has for itself, in the order of the row."""
BY_ADDRESS: Final = {parameter.address: parameter for parameter in PARAMETERS}
OWN: Final = slice(
    PARAMETERS[-1].first + PARAMETERS[-1].size, PARAMETERS[-1].first + PARAMETERS[-1].size + MOST_PASSES * NUMBERS
)
"""The numbers of a patch's own passes (`own_pass.own_numbers`)."""
COLOURS: Final = OWN.stop
"""Where the groups' colours begin, three numbers for each."""
STYLES: Final = COLOURS + 3 * GROUPS
"""Where the groups' styles begin, `STYLE_SIZE` numbers for each."""
STYLE_OF_GROUP: Final = "/dance/draw/"
"""What the addresses of all styles begin with."""


def colour_of_group(group: int) -> PictureParameter:
    """The colour of a group, by its index below `GROUPS`."""
    words = "Colour of the clothes of a group."
    return PictureParameter(COLOUR_OF_GROUP, "colour", 0, 1, (0.8, 0.8, 0.8), "", words, COLOURS + 3 * group)


def _styles() -> dict[str, PictureParameter]:
    first, table = STYLES, {}
    for name, kind, low, high, start, unit, words in styles.LINES:
        address = STYLE_OF_GROUP + name
        table[address] = PictureParameter(address, kind, low, high, start, unit, words, first)
        first += table[address].size
    return table


OF_GROUPS: Final = {COLOUR_OF_GROUP: colour_of_group(0)} | _styles()
"""What every group has for itself, by address, where the first group has it."""
STYLE_SIZE: Final = sum(known.size for known in OF_GROUPS.values()) - 3
SIZE: Final = STYLES + STYLE_SIZE * GROUPS
"""Numbers of the row."""


def of_group(address: str, group: int) -> PictureParameter:
    """The parameter of `OF_GROUPS` at an address, of a group by its index below `GROUPS`."""
    known = OF_GROUPS[address]
    stride = 3 if address == COLOUR_OF_GROUP else STYLE_SIZE
    return replace(known, first=known.first + stride * group)


def _where(*addresses: str) -> npt.NDArray[np.intp]:
    return np.concatenate([np.arange(SIZE)[BY_ADDRESS[address].where] for address in addresses])


EYE: Final = BY_ADDRESS["/dance/camera/eye"].where
TARGET: Final = BY_ADDRESS["/dance/camera/target"].where
FIELD_OF_VIEW: Final = BY_ADDRESS["/dance/camera/field_of_view"].first
ROLL: Final = BY_ADDRESS["/dance/camera/roll"].first
"""Here begin, side by side: roll, lens shift to the right and upwards, stretch, skew."""
ORBIT: Final = BY_ADDRESS["/dance/camera/orbit"].first
FOLLOWING: Final = BY_ADDRESS["/dance/camera/following"].first
ALONG: Final = BY_ADDRESS["/dance/camera/along"].first
PLAN: Final = BY_ADDRESS["/dance/camera/plan"].first
LEVEL: Final = BY_ADDRESS["/dance/light/level"].first
SHADOW: Final = BY_ADDRESS["/dance/pass/shadow"].first
MIRROR: Final = BY_ADDRESS["/dance/pass/mirror"].first
VIGNETTE: Final = BY_ADDRESS["/dance/pass/vignette"].first
CAMERA: Final = slice(EYE.start, PLAN + 1)
"""The camera's numbers, which lie side by side."""
LENS: Final = slice(EYE.start, ORBIT)
"""Those of them that a picture depends on: where the camera is, and how it sees."""
STANDING: Final = _where(
    "/dance/light/key", "/dance/light/key/colour", "/dance/light/rim", "/dance/light/rim/colour",
    "/dance/light/haze", "/dance/light/background", "/dance/light/floor",
    *lights.STANDING,
    *(known.address for known in PARAMETERS if EYE.start <= known.first < ORBIT),
)  # fmt: skip
"""The numbers on which floor, back wall and light in the haze depend: what the renderer keeps while they stand."""


def camera_values(camera: Camera) -> dict[str, float | tuple[float, float, float]]:
    """A camera's values by address: places [m], angles [degrees], the others are shares."""
    return {
        "/dance/camera/eye": camera.eye,
        "/dance/camera/target": camera.target,
        "/dance/camera/field_of_view": camera.field_of_view_deg,
        "/dance/camera/roll": camera.roll_deg,
        "/dance/camera/shift_x": camera.shift[0],
        "/dance/camera/shift_y": camera.shift[1],
        "/dance/camera/stretch": camera.stretch,
        "/dance/camera/skew": camera.skew,
    }


def picture_of(scene: Scene) -> Float64:
    """The row of a scene's camera and look, shape (SIZE,): float64, so that it is exactly what the scene says."""
    row = np.zeros(SIZE)
    look, camera = scene.look, scene.camera
    said: dict[str, float | tuple[float, ...]] = {
        "/dance/light/level": look.level,
        "/dance/light/key": look.key,
        "/dance/light/key/colour": look.key_light,
        "/dance/light/key/direction": look.key_direction,
        "/dance/light/rim": look.rim,
        "/dance/light/rim/colour": look.rim_light,
        "/dance/light/ambient": look.ambient,
        "/dance/light/ambient/colour": look.ambient_colour,
        "/dance/light/saturation": look.saturation,
        "/dance/light/haze": look.haze,
        "/dance/light/background": look.background,
        "/dance/light/floor": look.floor,
        **camera_values(camera),
    }
    for parameter in PARAMETERS:
        row[parameter.where] = said.get(parameter.address, parameter.start)
    own = own_numbers(scene.own)
    for number in own.values():
        row[OWN.start + number.place] = number.start
    for address, numbers in scene.start:
        if address in own:
            row[OWN.start + own[address].place] = numbers[0]
        else:
            row[BY_ADDRESS[address].where] = numbers
    colours = look.group_colours or ((0.8, 0.8, 0.8),)
    row[COLOURS:STYLES] = [value for group in range(GROUPS) for value in colours[group % len(colours)]]
    row[STYLES:] = [value for group in range(GROUPS) for value in _drawn(look, group)]
    return row


def _drawn(look: Look, group: int) -> Float64:
    """The numbers of a group's styles, shape (STYLE_SIZE,): the table's, and what the look says of this group."""
    said = dict(look.group_styles[group]) if group < len(look.group_styles) else {}
    numbers = [said.get(address, known.start) for address, known in OF_GROUPS.items() if address != COLOUR_OF_GROUP]
    return np.concatenate([np.atleast_1d(np.asarray(value, np.float64)) for value in numbers])


def camera_of(row: Float64) -> Camera:
    """The camera of a row."""
    eye, target = row[EYE].tolist(), row[TARGET].tolist()
    roll, right, up, stretch, skew = row[ROLL : ROLL + 5].tolist()
    angle = float(row[FIELD_OF_VIEW])
    return Camera((eye[0], eye[1], eye[2]), (target[0], target[1], target[2]), angle, roll, (right, up), stretch, skew)
