"""The picture's parameters: light, colours, camera, passes and drawing styles as one row of numbers.

Tables give address, kind, range, start value and unit of each. Controls, scenes, fades, the reference and the renderer
use them: a new parameter is one new line here and its use in the renderer. Colours are linear RGB. Styles are
amounts from 0 to 1 that add up, so that one can fade into another; every group has its own.
"""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.custom_pass import MAX_PASSES, NUMBERS_PER_PASS, custom_pass_numbers
from live.base.parameter import SPOT_COUNT, Kind, Parameter
from live.base.stage_snapshot import Camera, Look, Scene

CAMERA_LINES: Final[tuple[tuple[str, Kind, float, float, tuple[float, ...], str, str], ...]] = (
    ("/dance/camera/roll", "number", -360, 360, (0.0,), "degrees", "How far the camera is turned about its axis."),
    (
        "/dance/camera/shift_x", "number", -5, 5, (0.0,), "widths",
        "Lens shift to the right: how far the middle of the picture lies beside the camera's axis.",
    ),
    (
        "/dance/camera/shift_y", "number", -5, 5, (0.0,), "heights",
        "Lens shift upwards: how far the middle of the picture lies above the camera's axis.",
    ),
    ("/dance/camera/stretch", "number", 0.1, 10, (1.0,), "", "How much wider than high a square is drawn."),
    ("/dance/camera/skew", "number", -5, 5, (0.0,), "", "How far a square's upper edge is pushed to the right."),
    (
        "/dance/camera/orbit", "number", -4, 4, (0.0,), "turns/measure",
        "How fast the camera circles its target, to its right; 0.125 is once in eight measures.",
    ),
    (
        "/dance/camera/following", "number", 0, 1, (0.0,), "",
        "How far the camera turns towards the dancers it follows; 0: it looks at its target.",
    ),
    (
        "/dance/camera/along", "number", 0, 1, (0.0,), "",
        "How far the camera moves along with the dancers it follows; 0: it only turns.",
    ),
    (
        "/dance/camera/plan", "number", 0, 1, (0.0,), "",
        "Opacity of the plan over the picture: circles with triangles, and where the dancers came from.",
    ),
)  # fmt: skip
"""Camera: address, kind, minimum, maximum, start, unit, description."""


STYLE_NAMES: Final = ("solid", "silhouette", "ink", "particles", "ribbons", "trails", "xray")
"""The styles; each group's amount of a style is at `/dance/draw/NAME`."""
MAX_GHOSTS: Final = 8
LONGEST_RIBBON: Final = 8.0
"""[beats]"""

STYLE_LINES: Final[tuple[tuple[str, Kind, float, float, tuple[float, ...], str, str], ...]] = (
    ("solid", "number", 0, 1, (1.0,), "", "Amount of the group's dancers drawn as lit bodies."),
    ("silhouette", "number", 0, 1, (0.0,), "", "Amount of flat silhouettes, for projection on gauze."),
    ("silhouette/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Colour of the silhouettes."),
    ("ink", "number", 0, 1, (0.0,), "", "Amount of ink lines along the contours."),
    ("ink/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Colour of the ink."),
    ("ink/width", "number", 0.5, 8, (2.4,), "pixels", "Width of the ink in a picture 1080 pixels high."),
    ("particles", "number", 0, 1, (0.0,), "", "Amount of points of light on the skin."),
    ("particles/share", "number", 0, 1, (0.7,), "", "Share of the points that is drawn."),
    ("particles/drift", "number", 0, 1, (0.35,), "", "How far points drift from the skin and rise while they fade."),
    ("ribbons", "number", 0, 1, (0.0,), "", "Amount of ribbons behind hands and feet."),
    ("ribbons/beats", "number", 0.25, LONGEST_RIBBON, (2.0,), "beats", "How long the ribbons stay."),
    ("trails", "number", 0, 1, (0.0,), "", "Amount of ghosts that dancers leave behind on the beat."),
    ("trails/ghosts", "number", 1, MAX_GHOSTS, (4.0,), "", "How many ghosts each dancer leaves."),
    ("trails/spacing", "number", 0.25, 16, (1.0,), "beats", "How many beats lie between two ghosts."),
    ("xray", "number", 0, 1, (0.0,), "", "Amount of a glowing skeleton in a body of glass."),
    ("variety", "number", 0, 1, (0.2,), "", "How much the colours of a group's dancers differ."),
    ("pulse", "number", 0, 1, (0.0,), "", "How much the dancers' colours pulse with the beat."),
    ("sheen", "number", 0, 3, (1.0,), "", "How much the clothes shine in the light."),
    ("emission", "number", 0, 2, (0.0,), "", "How much light the clothes emit."),
)
"""Name under `/dance/draw/`, kind, minimum, maximum, start, unit, description."""


_Line = tuple[str, Kind, float, float, tuple[float, ...], str, str]

MAX_BACKGROUNDS: Final = 8
"""Maximum number of background images and videos of a patch."""


def _spot(number: int) -> tuple[_Line, ...]:
    at = f"/dance/spot/{number}"
    return (
        (
            at,
            "number",
            0,
            4,
            (0.0,),
            "",
            f"Strength of follow spot {number}; 1 is usual.",
        ),
        (f"{at}/colour", "colour", 0, 1, (1.0, 0.95, 0.86), "", f"Colour of follow spot {number}."),
        (
            f"{at}/radius",
            "number",
            0.2,
            8,
            (0.9,),
            "m",
            f"Radius of follow spot {number}.",
        ),
    )


LIGHT_LINES: Final[tuple[_Line, ...]] = (
    ("/dance/light/side", "number", 0, 4, (0.0,), "", "Strength of the light from both sides, low, as for dance."),
    ("/dance/light/side/left", "colour", 0, 1, (1.0, 0.42, 0.16), "", "Colour of the light from the left."),
    ("/dance/light/side/right", "colour", 0, 1, (0.16, 0.36, 1.0), "", "Colour of the light from the right."),
    ("/dance/light/back", "number", 0, 4, (0.0,), "", "Strength of the light from straight behind and above."),
    ("/dance/light/back/colour", "colour", 0, 1, (1.0, 0.86, 0.70), "", "Colour of the light from straight behind."),
    ("/dance/light/beams", "number", 0, 4, (0.0,), "", "Strength of the beams that are seen in the haze."),
    ("/dance/light/beams/colour", "colour", 0, 1, (0.5, 0.7, 1.0), "", "Colour of the beams; every other is warmer."),
    ("/dance/light/beams/width", "number", 0.01, 0.5, (0.07,), "", "How fast a beam grows wider on its way."),
    (
        "/dance/light/beams/fan", "number", -2, 2, (0.5,), "",
        "Where the beams meet the floor: 1 below their lamps, 0 all in the middle, -1 crossed.",
    ),
    ("/dance/light/beams/sway", "number", 0, 1, (0.35,), "", "How far the beams swing, there and back in eight beats."),
    ("/dance/light/pulse", "number", 0, 1, (0.06,), "", "How much all light pulses with the beat."),
    ("/dance/light/energy", "number", 0, 1, (0.0,), "", "How much all light follows the energy of the music."),
    (
        "/dance/light/stage", "number", 0, 1, (1.0,), "",
        "How much of floor and wall is visible; 0: only the dancers on true black, as for a gauze.",
    ),
    ("/dance/background/gradient", "number", 0, 1, (0.0,), "", "How much the wall is a gradient of two colours."),
    ("/dance/background/top", "colour", 0, 1, (0.02, 0.03, 0.12), "", "Colour of that gradient above."),
    ("/dance/background/bottom", "colour", 0, 1, (0.30, 0.07, 0.05), "", "Colour of that gradient below."),
    *(
        (f"/dance/background/{number}", "number", 0, 1, (0.0,), "", f"How much of [[background]] {number} is seen.")
        for number in range(1, MAX_BACKGROUNDS + 1)
    ),
    *(line for number in range(1, SPOT_COUNT + 1) for line in _spot(number)),
)  # fmt: skip
"""Light and backgrounds: address, kind, minimum, maximum, start, unit, description."""
BACKDROP_PARAMETERS: Final = ("/dance/background/gradient", "/dance/background/top", "/dance/background/bottom")
"""Parameters that the cached backdrop depends on."""


GROUP_COUNT: Final = 16
"""Number of groups with their own colour."""
GROUP_COLOUR_ADDRESS: Final = "/dance/group/colour"


_LOOK: Final = Look()
_CAMERA: Final = Camera()
_LINES: Final[tuple[_Line, ...]] = (
    ("/dance/light/level", "number", 0, 2, (1.0,), "", "Level of all light; 1 is the default, 0 is dark."),
    ("/dance/light/key", "number", 0, 4, (1.0,), "", "Strength of the light from the front, which casts the shadows."),
    ("/dance/light/key/colour", "colour", 0, 1, _LOOK.key_light, "", "Colour of the light from the front."),
    (
        "/dance/light/key/direction", "place", -100, 100, _LOOK.key_direction, "",
        "Direction of the light from the front: x, y (up), z; its length is ignored.",
    ),
    ("/dance/light/rim", "number", 0, 4, (1.0,), "", "Strength of the light from behind, and of its beams."),
    ("/dance/light/rim/colour", "colour", 0, 1, _LOOK.rim_light, "", "Colour of the light from behind."),
    ("/dance/light/ambient", "number", 0, 1, (_LOOK.ambient,), "", "Strength of the ambient light."),
    ("/dance/light/ambient/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Tint of the ambient light."),
    ("/dance/light/haze", "number", 0, 1, (_LOOK.haze,), "1/m", "How fast the depth of the stage fades."),
    ("/dance/light/background", "colour", 0, 1, _LOOK.background, "", "Colour of the dark behind the stage."),
    ("/dance/light/floor", "colour", 0, 1, _LOOK.floor, "", "Colour of the floor."),
    ("/dance/light/saturation", "number", 0, 2, (1.0,), "", "Colour saturation; 0 is black and white."),
    ("/dance/camera/eye", "place", -1000, 1000, _CAMERA.eye, "m", "Where the camera stands: x, y (up), z."),
    ("/dance/camera/target", "place", -1000, 1000, _CAMERA.target, "m", "What the camera looks at: x, y (up), z."),
    (
        "/dance/camera/field_of_view", "number", 5, 120, (_CAMERA.field_of_view_deg,), "degrees",
        "The camera's vertical angle of view.",
    ),
    *CAMERA_LINES,
    *LIGHT_LINES,
    ("/dance/pass/shadow", "number", 0, 1, (1.0,), "", "How dark the dancers' shadows are; 0: none."),
    ("/dance/pass/mirror", "number", 0, 1, (1.0,), "", "Brightness of the dancers' reflections in the floor; 0: none."),
    (
        "/dance/pass/trails", "number", 0, 1, (0.0,), "",
        "Trails behind bright moving parts; less is shorter, 0: none.",
    ),
    (
        "/dance/pass/trails/beats", "number", 0.05, 64, (1.0,), "beats",
        "After how many beats a trail is half as bright.",
    ),
    ("/dance/pass/trails/zoom", "number", -2, 2, (0.0,), "1/beat", "How fast trails grow out of the middle."),
    ("/dance/pass/trails/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Colour that white trails take as they fade."),
    ("/dance/pass/bloom", "number", 0, 4, (1.0,), "", "Glow around what is bright, where quality allows; 0: none."),
    ("/dance/pass/ink", "number", 0, 1, (0.0,), "", "Lines of ink around dancers and where they bend; 0: none."),
    ("/dance/pass/ink/width", "number", 0.5, 8, (1.5,), "px", "Width of the lines, in a picture of 720 lines."),
    ("/dance/pass/ink/colour", "colour", 0, 1, (0.004, 0.004, 0.008), "", "Colour of the ink."),
    ("/dance/pass/ink/paper", "number", 0, 1, (0.0,), "", "How far paper replaces the picture under the ink."),
    ("/dance/pass/ink/paper/colour", "colour", 0, 1, (0.90, 0.80, 0.64), "", "Colour of the paper."),
    ("/dance/pass/grade", "number", 0, 1, (1.0,), "", "Amount of the colour grade."),
    ("/dance/pass/grade/lift", "colour", -1, 1, (0.0, 0.0, 0.0), "", "Offset of the grade for dark tones."),
    ("/dance/pass/grade/gamma", "colour", 0.2, 5, (1.0, 1.0, 1.0), "", "Brightness of mid tones in the grade."),
    ("/dance/pass/grade/gain", "colour", 0, 4, (1.0, 1.0, 1.0), "", "Factor of the grade for bright tones."),
    ("/dance/pass/grade/contrast", "number", 0, 2, (1.0,), "", "Contrast about mid grey."),
    ("/dance/pass/grade/temperature", "number", -1, 1, (0.0,), "", "Colder below 0, warmer above."),
    ("/dance/pass/vignette", "number", 0, 1.5, (1.0,), "", "How much darker the picture's corners are; 0: not at all."),
)  # fmt: skip


def _build_parameters() -> tuple[Parameter, ...]:
    first, table = 0, []
    for address, kind, low, high, start, unit, words in _LINES:
        table.append(Parameter(address, kind, low, high, start, unit, words, first))
        first += table[-1].size
    return tuple(table)


PARAMETERS: Final = _build_parameters()
"""All parameters except those of groups, in the order of the row."""
BY_ADDRESS: Final = {parameter.address: parameter for parameter in PARAMETERS}
CUSTOM_PASS_SLICE: Final = slice(
    PARAMETERS[-1].first + PARAMETERS[-1].size,
    PARAMETERS[-1].first + PARAMETERS[-1].size + MAX_PASSES * NUMBERS_PER_PASS,
)
"""The numbers of a patch's custom passes (`custom_pass.custom_pass_numbers`)."""
COLOURS_START: Final = CUSTOM_PASS_SLICE.stop
"""Index of the groups' colours, three numbers for each."""
STYLES_START: Final = COLOURS_START + 3 * GROUP_COUNT
"""Index of the groups' styles, `STYLE_SIZE` numbers for each."""
STYLE_ADDRESS_PREFIX: Final = "/dance/draw/"
"""Prefix of the addresses of all styles."""


def group_colour(group: int) -> Parameter:
    """Return the colour parameter of a group, by its index below `GROUP_COUNT`."""
    words = "Colour of the clothes of a group."
    first = COLOURS_START + 3 * group
    return Parameter(GROUP_COLOUR_ADDRESS, "colour", 0, 1, (0.8, 0.8, 0.8), "", words, first, True)


def _build_styles() -> dict[str, Parameter]:
    first, table = STYLES_START, {}
    for name, kind, low, high, start, unit, words in STYLE_LINES:
        address = STYLE_ADDRESS_PREFIX + name
        table[address] = Parameter(address, kind, low, high, start, unit, words, first, True)
        first += table[address].size
    return table


GROUP_PARAMETERS: Final = {GROUP_COLOUR_ADDRESS: group_colour(0)} | _build_styles()
"""The parameters that every group has, by address, with the positions of the first group."""
STYLE_SIZE: Final = sum(known.size for known in GROUP_PARAMETERS.values()) - 3
ROW_SIZE: Final = STYLES_START + STYLE_SIZE * GROUP_COUNT
"""Length of the row."""


def group_parameter(address: str, group: int) -> Parameter:
    """Return the parameter of `GROUP_PARAMETERS` at an address, for a group by its index below `GROUP_COUNT`."""
    known = GROUP_PARAMETERS[address]
    stride = 3 if address == GROUP_COLOUR_ADDRESS else STYLE_SIZE
    return replace(known, first=known.first + stride * group)


def _row_indices(*addresses: str) -> npt.NDArray[np.intp]:
    return np.concatenate([np.arange(ROW_SIZE)[BY_ADDRESS[address].row_slice] for address in addresses])


EYE: Final = BY_ADDRESS["/dance/camera/eye"].row_slice
TARGET: Final = BY_ADDRESS["/dance/camera/target"].row_slice
FIELD_OF_VIEW: Final = BY_ADDRESS["/dance/camera/field_of_view"].first
ROLL: Final = BY_ADDRESS["/dance/camera/roll"].first
"""Index of roll; lens shift to the right and upwards, stretch and skew follow."""
ORBIT: Final = BY_ADDRESS["/dance/camera/orbit"].first
FOLLOWING: Final = BY_ADDRESS["/dance/camera/following"].first
ALONG: Final = BY_ADDRESS["/dance/camera/along"].first
PLAN: Final = BY_ADDRESS["/dance/camera/plan"].first
LEVEL: Final = BY_ADDRESS["/dance/light/level"].first
SHADOW: Final = BY_ADDRESS["/dance/pass/shadow"].first
MIRROR: Final = BY_ADDRESS["/dance/pass/mirror"].first
VIGNETTE: Final = BY_ADDRESS["/dance/pass/vignette"].first
CAMERA: Final = slice(EYE.start, PLAN + 1)
"""The camera's numbers, which are contiguous."""
LENS: Final = slice(EYE.start, ORBIT)
"""The camera's numbers that define the projection: position, direction and lens."""
BACKDROP_INDICES: Final = _row_indices(
    "/dance/light/key", "/dance/light/key/colour", "/dance/light/rim", "/dance/light/rim/colour",
    "/dance/light/haze", "/dance/light/background", "/dance/light/floor",
    *BACKDROP_PARAMETERS,
    *(known.address for known in PARAMETERS if EYE.start <= known.first < ORBIT),
)  # fmt: skip
"""The numbers on which floor, back wall and haze depend: the renderer keeps these until one changes."""


def camera_values(camera: Camera) -> dict[str, float | tuple[float, float, float]]:
    """Return a camera's values by address: positions [m], angles [degrees], the others are ratios."""
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


def picture_row(scene: Scene) -> Float64:
    """Return the row of a scene's camera and look, shape (SIZE,): float64, so that the scene's values are exact."""
    row = np.zeros(ROW_SIZE)
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
        row[parameter.row_slice] = said.get(parameter.address, parameter.start)
    own = custom_pass_numbers(scene.custom_passes)
    for number in own.values():
        row[CUSTOM_PASS_SLICE.start + number.index] = number.start
    for address, numbers in scene.start_values:
        if address in own:
            row[CUSTOM_PASS_SLICE.start + own[address].index] = numbers[0]
        else:
            row[BY_ADDRESS[address].row_slice] = numbers
    colours = look.group_colours or ((0.8, 0.8, 0.8),)
    row[COLOURS_START:STYLES_START] = [value for group in range(GROUP_COUNT) for value in colours[group % len(colours)]]
    row[STYLES_START:] = [value for group in range(GROUP_COUNT) for value in _style_values(look, group)]
    return row


def _style_values(look: Look, group: int) -> Float64:
    """Return the numbers of a group's styles, shape (STYLE_SIZE,): the table's start values, overridden by the look."""
    said = dict(look.group_styles[group]) if group < len(look.group_styles) else {}
    numbers = [
        said.get(address, known.start) for address, known in GROUP_PARAMETERS.items() if address != GROUP_COLOUR_ADDRESS
    ]
    return np.concatenate([np.atleast_1d(np.asarray(value, np.float64)) for value in numbers])


def camera_from_row(row: Float64) -> Camera:
    """Return the camera of a row."""
    eye, target = row[EYE].tolist(), row[TARGET].tolist()
    roll, right, up, stretch, skew = row[ROLL : ROLL + 5].tolist()
    angle = float(row[FIELD_OF_VIEW])
    return Camera((eye[0], eye[1], eye[2]), (target[0], target[1], target[2]), angle, roll, (right, up), stretch, skew)
