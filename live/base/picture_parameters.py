"""The picture's parameters: light, colours, camera, passes and drawing styles as one row of numbers.

Each row gives address, kind, range, start value, unit and the key in the patch. Controls, the patch, scenes, fades, the
reference and the renderer use them: a new parameter is one row here and its use in the renderer. Colours are linear
RGB. Styles are amounts from 0 to 1 that add up, so that one can fade into another; every group has its own.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.body.appearance import COSTUMES, EXTRAS, FABRICS, HAIRS, MOVING, SHOES
from live.base.custom_pass import MAX_PASSES, NUMBERS_PER_PASS, custom_pass_numbers
from live.base.parameter import SPOT_COUNT, WORLD_NAMES, Parameter
from live.base.stage_snapshot import BACKGROUND_CAPACITY, Camera, Scene

STYLE_NAMES: Final = ("solid", "silhouette", "ink", "particles", "ribbons", "trails", "xray")
"""The styles; each group's amount of a style is at `/dance/draw/NAME`."""
WORLD_PREFIX: Final = "/dance/world/"
GOBO_NAMES: Final = ("leaves", "window", "blinds", "breakup")
"""Patterns in the key light; the amount of each is at `/dance/light/gobo/NAME`."""
FLOOR_PATTERN_NAMES: Final = ("rings", "grid", "checker", "stripes")
"""Patterns of light on the floor; the amount of each is at `/dance/floor/pattern/NAME`."""
MAX_GHOSTS: Final = 8
LONGEST_RIBBON: Final = 8.0
"""[beats]"""
MAX_BACKGROUNDS: Final = BACKGROUND_CAPACITY
"""Maximum number of background images, videos and live inputs of a patch."""
MAX_SCENERY: Final = 8
"""Maximum number of set pieces from files of a patch."""
PART_COUNT: Final = 64
"""Number of groups, and of parts of groups, with their own colour and style; the groups come first."""
MAX_GROUPS: Final = 16
"""Maximum number of groups in a patch."""
GROUP_COLOUR_ADDRESS: Final = "/dance/group/colour"
STYLE_ADDRESS_PREFIX: Final = "/dance/draw/"
"""Prefix of the addresses of all styles."""
_CAMERA: Final = Camera()
_Triple = tuple[float, float, float]


def _number(
    address: str, low: float, high: float, start: float, text: str, *, unit: str = "", patch: str = ""
) -> Parameter:
    return Parameter(address, "number", low, high, (start,), unit, text, patch=patch)


def _colour(address: str, start: _Triple, text: str, *, low: float = 0, high: float = 1, patch: str = "") -> Parameter:
    return Parameter(address, "colour", low, high, start, "", text, patch=patch)


def _place(
    address: str, low: float, high: float, start: _Triple, text: str, *, unit: str = "", patch: str = ""
) -> Parameter:
    return Parameter(address, "place", low, high, start, unit, text, patch=patch)


def _names(address: str, names: tuple[str, ...], text: str) -> Parameter:
    """Return a row of names; the first one is the start value."""
    bits = {name: float(1 << place) for place, name in enumerate(names)}
    return Parameter(address, "names", 1, sum(bits.values()), (1.0,), "", text, choices=bits)


def _spot(number: int) -> tuple[Parameter, ...]:
    at = f"/dance/spot/{number}"
    return (
        _number(at, 0, 4, 0.0, f"Strength of follow spot {number}; 1 is usual."),
        _colour(f"{at}/colour", (1.0, 0.95, 0.86), f"Colour of follow spot {number}."),
        _number(f"{at}/radius", 0.2, 8, 0.9, f"Radius of follow spot {number}.", unit="m"),
    )


_WORLD_ROWS: Final = tuple(
    _number(WORLD_PREFIX + name, 0, 1, 0.0, text)
    for name, text in zip(WORLD_NAMES, (
        "Share of the black box with haze, which fills what the other worlds leave.",
        "Share of the white studio: a cove without corners.",
        "Share of paper, ink and watercolour.",
        "Share of the constellation: points of light and fine lines in the dark.",
        "Share of the dark water that mirrors the dancers.",
        "Share of the open field at dusk.",
    ), strict=True)
)  # fmt: skip
_ROWS: Final = (
    _place(
        "/dance/cloth/wind", -20, 20, (0.0, 0.0, 0.0),
        "Wind in skirts, hair and ribbons: x, y (up), z.", unit="m/s", patch="look.wind",
    ),
    _number("/dance/light/level", 0, 2, 1.0, "Level of all light; 1 is usual, 0 is dark.", patch="look.level"),
    _number(
        "/dance/light/key", 0, 4, 1.0,
        "Strength of the light from the front, which casts the shadows; 1 is usual.", patch="look.key",
    ),
    _colour(
        "/dance/light/key/colour", (1.0, 0.93, 0.82),
        "Colour of the key light from the front, which casts the shadows.", patch="look.key_light",
    ),
    _place(
        "/dance/light/key/direction", -100, 100, (-0.45, -1.0, -0.55),
        "Direction of the key light, from the front: x, y (up), z; its length is ignored.", patch="look.key_direction",
    ),
    _number(
        "/dance/light/rim", 0, 4, 1.0,
        "Strength of the light from behind, and of its beams; 1 is usual.", patch="look.rim",
    ),
    _colour("/dance/light/rim/colour", (0.45, 0.62, 1.0), "Colour of the light from behind.", patch="look.rim_light"),
    _number("/dance/light/ambient", 0, 1, 0.1, "Strength of the ambient light.", patch="look.ambient"),
    _colour("/dance/light/ambient/colour", (1.0, 1.0, 1.0), "Tint of the ambient light.", patch="look.ambient_colour"),
    _number(
        "/dance/light/haze", 0, 1, 0.035,
        "Density of the haze: how fast the depth of the stage fades.", unit="1/m", patch="look.haze",
    ),
    _colour(
        "/dance/light/background", (0.01, 0.011, 0.018),
        "Colour of the dark behind the stage.", patch="look.background",
    ),
    _colour("/dance/light/floor", (0.06, 0.058, 0.07), "Colour of the floor.", patch="look.floor"),
    _number("/dance/light/saturation", 0, 2, 1.0, "Colour saturation; 0 is black and white.", patch="look.saturation"),
    _place(
        "/dance/camera/eye", -1000, 1000, _CAMERA.eye,
        "Position of the camera: x, y (up), z.", unit="m", patch="camera.eye",
    ),
    _place(
        "/dance/camera/target", -1000, 1000, _CAMERA.target,
        "The point that the camera looks at: x, y (up), z.", unit="m", patch="camera.target",
    ),
    _number(
        "/dance/camera/field_of_view", 5, 120, _CAMERA.field_of_view_deg,
        "The camera's vertical field of view.", unit="degrees", patch="camera.field_of_view_deg",
    ),
    _number(
        "/dance/camera/roll", -360, 360, 0.0,
        "Rotation of the camera about its axis, clockwise as seen from behind.", unit="degrees",
        patch="camera.roll_deg",
    ),
    _number(
        "/dance/camera/shift_x", -5, 5, 0.0,
        "Lens shift to the right: how far the middle of the picture lies beside the camera's axis.", unit="widths",
    ),
    _number(
        "/dance/camera/shift_y", -5, 5, 0.0,
        "Lens shift upwards: how far the middle of the picture lies above the camera's axis.", unit="heights",
    ),
    _number("/dance/camera/stretch", 0.1, 10, 1.0, "How much wider than high a square is drawn."),
    _number("/dance/camera/skew", -5, 5, 0.0, "How far a square's upper edge is pushed to the right."),
    _number(
        "/dance/camera/orbit", -4, 4, 0.0,
        "How fast the camera circles its target, to its right; 0.125 is once in eight measures.", unit="turns/measure",
    ),
    _number(
        "/dance/camera/following", 0, 1, 0.0,
        "How far the camera turns towards the dancers it follows; 0: it looks at its target.",
    ),
    _number(
        "/dance/camera/along", 0, 1, 0.0,
        "How far the camera moves along with the dancers it follows; 0: it only turns, 1: it keeps its distance.",
        patch="camera.along",
    ),
    _number(
        "/dance/camera/plan", 0, 1, 0.0,
        "Opacity of the plan over the picture: circles with triangles for dancers, and their trails.",
        patch="camera.plan",
    ),
    Parameter(
        "/dance/camera/director", "switch", 0, 1, (0.0,), "",
        "Whether the director leads the camera: it frames the dancers, moves and cuts with the phrases.",
        patch="camera.director",
    ),
    Parameter(
        "/dance/camera/mood", "choice", 0, 3, (0.0,), "", "How the director works.",
        words="0: calm, 1: still, 2: lively, 3: cinematic", patch="camera.mood",
        choices={"calm": 0.0, "still": 1.0, "lively": 2.0, "cinematic": 3.0},
    ),
    _number(
        "/dance/light/side", 0, 4, 0.0,
        "Strength of the light from both sides, low, as for dance; by default none.", patch="look.side",
    ),
    _colour("/dance/light/side/left", (1.0, 0.42, 0.16), "Colour of the light from the left.", patch="look.side_left"),
    _colour(
        "/dance/light/side/right", (0.16, 0.36, 1.0),
        "Colour of the light from the right.", patch="look.side_right",
    ),
    _number("/dance/light/back", 0, 4, 0.0, "Strength of the light from straight behind and above.", patch="look.back"),
    _colour(
        "/dance/light/back/colour", (1.0, 0.86, 0.7),
        "Colour of the light from straight behind.", patch="look.back_light",
    ),
    _number("/dance/light/beams", 0, 4, 0.0, "Strength of the visible beams in the haze.", patch="look.beams"),
    _colour(
        "/dance/light/beams/colour", (0.5, 0.7, 1.0),
        "Colour of every other beam; those between are warmer.", patch="look.beams_colour",
    ),
    _number(
        "/dance/light/beams/width", 0.01, 0.5, 0.07,
        "How fast a beam widens along its length.", patch="look.beams_width",
    ),
    _number(
        "/dance/light/beams/fan", -2, 2, 0.5,
        "Where the beams meet the floor: 1 below their lamps, 0 all in the middle, -1 crossed.", patch="look.beams_fan",
    ),
    _number(
        "/dance/light/beams/sway", 0, 1, 0.35,
        "How far the beams swing, there and back in eight beats.", patch="look.beams_sway",
    ),
    _number("/dance/light/pulse", 0, 1, 0.06, "How much all light pulses with the beat.", patch="look.pulse"),
    _number(
        "/dance/light/energy", 0, 1, 0.0,
        "How much all light follows the energy of the music.", patch="look.energy",
    ),
    _number(
        "/dance/light/score", 0, 1, 1.0,
        "How much the light follows the score: soloists, groups, beginning, end, build-ups and drops; 0: not at all.",
        patch="look.follow_score",
    ),
    _number(
        "/dance/light/stage", 0, 1, 1.0,
        "How much of floor and wall is visible; 0: only the dancers on true black, as for a gauze.", patch="look.stage",
    ),
    _number(
        "/dance/background/gradient", 0, 1, 0.0,
        "How much the back wall is a gradient of two colours.", patch="look.gradient",
    ),
    _colour("/dance/background/top", (0.02, 0.03, 0.12), "Colour of that gradient above.", patch="look.gradient_top"),
    _colour(
        "/dance/background/bottom", (0.3, 0.07, 0.05),
        "Colour of that gradient below, at the floor.", patch="look.gradient_bottom",
    ),
    *(
        _number(f"/dance/background/{number}", 0, 1, 0.0, f"How much of [[background]] {number} is seen.")
        for number in range(1, MAX_BACKGROUNDS + 1)
    ),
    *(row for number in range(1, SPOT_COUNT + 1) for row in _spot(number)),
    *_WORLD_ROWS,
    _number(
        "/dance/light/fill", 0, 4, 0.0,
        "Strength of the soft light from all around, as of a sky and its ground; by default none.", patch="look.fill",
    ),
    _colour("/dance/light/fill/above", (0.9, 0.95, 1.0), "Colour of that light from above.", patch="look.fill_above"),
    _colour("/dance/light/fill/below", (0.5, 0.46, 0.42), "Colour of that light from below.", patch="look.fill_below"),
    *(
        _number(f"/dance/light/gobo/{name}", 0, 1, 0.0, f"{text} in the key light, on floor and dancers.",
                patch=f"look.gobo_{name}")
        for name, text in zip(GOBO_NAMES, (
            "Leaves", "The panes of a window", "The slats of a blind", "Soft irregular patches",
        ), strict=True)
    ),
    _number(
        "/dance/light/gobo/size", 0.2, 20, 2.4, "How large the pattern in the key light is.", unit="m",
        patch="look.gobo_size",
    ),
    _number(
        "/dance/light/gobo/turn", -4, 4, 0.0, "How fast the pattern in the key light turns.", unit="turns/measure",
        patch="look.gobo_turn",
    ),
    *(
        _number(f"/dance/floor/pattern/{name}", 0, 1, 0.0, f"{text}.", patch=f"look.floor_{name}")
        for name, text in zip(FLOOR_PATTERN_NAMES, (
            "Rings of light on the floor that spread from the dancers' steps",
            "A grid of light on the floor that breathes with the beat",
            "Squares of light on the floor that change places from beat to beat",
            "Stripes of light on the floor that move by one with every beat",
        ), strict=True)
    ),
    _number(
        "/dance/floor/pattern/size", 0.1, 10, 1.0, "How wide one square or stripe of the floor's patterns is.",
        unit="m", patch="look.floor_size",
    ),
    _colour(
        "/dance/floor/pattern/colour", (0.55, 0.75, 1.0), "Colour of the floor's patterns.", patch="look.floor_colour",
    ),
    *(
        _number(f"/dance/scenery/{number}", 0, 1, 0.0, f"How much of [[scenery]] {number} is seen.")
        for number in range(1, MAX_SCENERY + 1)
    ),
    _number("/dance/pass/shadow", 0, 1, 1.0, "How dark the dancers' shadows are; 0: none."),
    _number("/dance/pass/mirror", 0, 1, 1.0, "Brightness of the dancers' reflections in the floor; 0: none."),
    _number("/dance/pass/trails", 0, 1, 0.0, "Trails behind bright moving parts; less is shorter, 0: none."),
    _number("/dance/pass/trails/beats", 0.05, 64, 1.0, "After how many beats a trail is half as bright.", unit="beats"),
    _number("/dance/pass/trails/zoom", -2, 2, 0.0, "How fast trails grow out of the middle.", unit="1/beat"),
    _colour("/dance/pass/trails/colour", (1.0, 1.0, 1.0), "Colour that white trails take as they fade."),
    _number("/dance/pass/bloom", 0, 4, 1.0, "Glow around what is bright, where quality allows; 0: none."),
    _number("/dance/pass/ink", 0, 1, 0.0, "Lines of ink around dancers and where they bend; 0: none."),
    _number("/dance/pass/ink/width", 0.5, 8, 1.5, "Width of the lines, in a picture of 720 lines.", unit="px"),
    _colour("/dance/pass/ink/colour", (0.004, 0.004, 0.008), "Colour of the ink."),
    _number("/dance/pass/ink/paper", 0, 1, 0.0, "How far paper replaces the picture under the ink."),
    _colour("/dance/pass/ink/paper/colour", (0.9, 0.8, 0.64), "Colour of the paper."),
    _number("/dance/pass/grade", 0, 1, 1.0, "Amount of the colour grade."),
    _colour("/dance/pass/grade/lift", (0.0, 0.0, 0.0), "Offset of the grade for dark tones.", low=-1, high=1),
    _colour("/dance/pass/grade/gamma", (1.0, 1.0, 1.0), "Brightness of mid tones in the grade.", low=0.2, high=5),
    _colour("/dance/pass/grade/gain", (1.0, 1.0, 1.0), "Factor of the grade for bright tones.", low=0, high=4),
    _number("/dance/pass/grade/contrast", 0, 2, 1.0, "Contrast about mid grey."),
    _number("/dance/pass/grade/temperature", -1, 1, 0.0, "Colder below 0, warmer above."),
    _number("/dance/pass/blur", 0, 1, 0.0, "Motion blur: share of the time between pictures with an open shutter."),
    _number("/dance/pass/focus", 0, 1, 0.0, "Depth of field: how unsharp it is off the focus; 0: all is sharp."),
    _number(
        "/dance/pass/focus/distance", 0, 120, 0.0,
        "Distance of the focus; 0: on the follow spot, else on what the camera looks at.", unit="m",
    ),
    _number("/dance/pass/focus/aperture", 0.01, 2, 0.3, "Diameter of the lens: wider is less deep.", unit="m"),
    _number("/dance/pass/vignette", 0, 1.5, 1.0, "How much darker the picture's corners are; 0: not at all."),
)  # fmt: skip
_STYLE_ROWS: Final = (
    _number("solid", 0, 1, 1.0, "Amount of the group's dancers drawn as lit bodies."),
    _number("silhouette", 0, 1, 0.0, "Amount of flat silhouettes, for projection on gauze."),
    _colour("silhouette/colour", (1.0, 1.0, 1.0), "Colour of the silhouettes."),
    _number("ink", 0, 1, 0.0, "Amount of ink lines along the contours."),
    _colour("ink/colour", (1.0, 1.0, 1.0), "Colour of the ink."),
    _number("ink/width", 0.5, 8, 2.4, "Width of the ink in a picture 1080 pixels high.", unit="pixels"),
    _number("particles", 0, 1, 0.0, "Amount of points of light on the skin."),
    _number("particles/share", 0, 1, 0.7, "Share of the points that is drawn."),
    _number("particles/drift", 0, 1, 0.35, "How far points drift from the skin and rise while they fade."),
    _number("ribbons", 0, 1, 0.0, "Amount of ribbons behind hands and feet."),
    _number("ribbons/beats", 0.25, LONGEST_RIBBON, 2.0, "How long the ribbons stay.", unit="beats"),
    _number("trails", 0, 1, 0.0, "Amount of ghosts that dancers leave behind on the beat."),
    _number("trails/ghosts", 1, MAX_GHOSTS, 4.0, "How many ghosts each dancer leaves."),
    _number("trails/spacing", 0.25, 16, 1.0, "How many beats lie between two ghosts.", unit="beats"),
    _number("xray", 0, 1, 0.0, "Amount of a glowing skeleton in a body of glass."),
    _number("variety", 0, 1, 0.2, "How much the colours of a group's dancers differ."),
    _number("pulse", 0, 1, 0.0, "How much the dancers' colours pulse with the beat."),
    _number("sheen", 0, 3, 1.0, "How much the clothes shine in the light."),
    _number("emission", 0, 2, 0.0, "How much light the clothes emit."),
)
"""Their addresses are names under `/dance/draw/`."""
_CLOTHES_ROWS: Final = (
    _names("costume", COSTUMES, f"What the dancers wear: {', '.join(COSTUMES)}."),
    _names("shoes", SHOES, f"What they have on their feet: {', '.join(SHOES)}."),
    _names("hair", HAIRS, f"How their hair is: {', '.join(HAIRS)}."),
    _number("hair/tone", 0, 1, 0.1, "Colour of the hair, from black over brown and blond to white."),
    _number("hair/variety", 0, 1, 0.2, "How much the hair's colours differ."),
    _number("skin", 0, 1, 0.5, "Tone of the skin, from dark to pale."),
    _number("skin/variety", 0, 1, 1.0, "How much the tones of skin differ."),
    _colour("accent", (0.8, 0.8, 0.8), "Second colour of the costume: trousers, tights, lapels and trims."),
    _number("accent/amount", 0, 1, 0.0, "How far these take that colour; 0: a dark shade of the first one."),
    _number("skirt", 0, 1, 0.5, "Length of skirts and dresses, from the hips to the floor."),
    _names("fabric", FABRICS, f"What skirts and sleeves are made of: {', '.join(FABRICS)}."),
    _names("extras", EXTRAS, f"What the dancers wear or carry besides: {', '.join(EXTRAS)}."),
    _names("cloth", MOVING, "How skirts, sleeves, ribbons and long hair move: auto (simulated), or skinned (rigid)."),
)
"""What dancers wear and look like, under the same prefix: drawn in any style."""
CLOTHES_NAMES: Final = tuple(row.address for row in _CLOTHES_ROWS)
"""Their addresses without the prefix."""


def _in_row(rows: Iterable[Parameter], first: int) -> tuple[Parameter, ...]:
    """Return the parameters with their positions, one after the other from `first` on."""
    table = []
    for row in rows:
        table.append(replace(row, first=first))
        first += row.size
    return tuple(table)


PARAMETERS: Final = _in_row(_ROWS, 0)
"""All parameters except those of groups, in the order of the row."""
BY_ADDRESS: Final = {parameter.address: parameter for parameter in PARAMETERS}
CUSTOM_PASS_SLICE: Final = slice(
    PARAMETERS[-1].first + PARAMETERS[-1].size,
    PARAMETERS[-1].first + PARAMETERS[-1].size + MAX_PASSES * NUMBERS_PER_PASS,
)
"""The numbers of a patch's custom passes (`custom_pass.custom_pass_numbers`)."""
COLOURS_START: Final = CUSTOM_PASS_SLICE.stop
"""Index of the groups' colours, three numbers for each."""
STYLES_START: Final = COLOURS_START + 3 * PART_COUNT
"""Index of the groups' styles, `STYLE_SIZE` numbers for each."""
GROUP_PARAMETERS: Final = {
    row.address: replace(row, per_group=True)
    for row in (
        *_in_row((_colour(GROUP_COLOUR_ADDRESS, (0.8, 0.8, 0.8), "Colour of the clothes of a group."),), COLOURS_START),
        *_in_row(
            (replace(row, address=STYLE_ADDRESS_PREFIX + row.address) for row in (*_STYLE_ROWS, *_CLOTHES_ROWS)),
            STYLES_START,
        ),
    )
}
"""The parameters that every group has, by address, with the positions of the first group."""
STYLE_SIZE: Final = sum(known.size for known in GROUP_PARAMETERS.values()) - 3
ROW_SIZE: Final = STYLES_START + STYLE_SIZE * PART_COUNT
"""Length of the row."""


def group_parameter(address: str, part: int) -> Parameter:
    """Return the parameter of `GROUP_PARAMETERS` at an address, for a group or part by its index below
    `PART_COUNT`."""
    known = GROUP_PARAMETERS[address]
    stride = 3 if address == GROUP_COLOUR_ADDRESS else STYLE_SIZE
    return replace(known, first=known.first + stride * part)


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
DIRECTOR: Final = BY_ADDRESS["/dance/camera/director"].first
DIRECTOR_MOOD: Final = BY_ADDRESS["/dance/camera/mood"].first
LEVEL: Final = BY_ADDRESS["/dance/light/level"].first
GOBO_TURN: Final = BY_ADDRESS["/dance/light/gobo/turn"].first
SHADOW: Final = BY_ADDRESS["/dance/pass/shadow"].first
MIRROR: Final = BY_ADDRESS["/dance/pass/mirror"].first
VIGNETTE: Final = BY_ADDRESS["/dance/pass/vignette"].first
CAMERA: Final = slice(EYE.start, DIRECTOR_MOOD + 1)
"""The camera's numbers, which are contiguous."""
DIRECTED: Final = range(EYE.start, PLAN)
"""The camera's numbers that the director sets while it leads: position, direction, lens and motion."""
LENS: Final = slice(EYE.start, ORBIT)
"""The camera's numbers that define the projection: position, direction and lens."""
BACKDROP_INDICES: Final = _row_indices(
    "/dance/light/key", "/dance/light/key/colour", "/dance/light/rim", "/dance/light/rim/colour",
    "/dance/light/haze", "/dance/light/background", "/dance/light/floor",
    "/dance/background/gradient", "/dance/background/top", "/dance/background/bottom",
    "/dance/light/key/direction", "/dance/light/fill", "/dance/light/fill/above", "/dance/light/fill/below",
    *(row.address for row in _WORLD_ROWS),
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
    """Return the row of a scene's initial values, shape (SIZE,): float64, so that the scene's values are exact."""
    row = np.zeros(ROW_SIZE)
    for parameter in PARAMETERS:
        row[parameter.row_slice] = parameter.start
    for address, value in camera_values(scene.camera).items():
        row[BY_ADDRESS[address].row_slice] = value
    own = custom_pass_numbers(scene.custom_passes)
    for number in own.values():
        row[CUSTOM_PASS_SLICE.start + number.index] = number.start
    for address, start in scene.start_values:
        if address in own:
            row[CUSTOM_PASS_SLICE.start + own[address].index] = start
        else:
            row[BY_ADDRESS[address].row_slice] = start
    colours = scene.group_colours or ((0.8, 0.8, 0.8),)
    row[COLOURS_START:STYLES_START] = [value for group in range(PART_COUNT) for value in colours[group % len(colours)]]
    row[STYLES_START:] = [value for group in range(PART_COUNT) for value in _style_values(scene, group)]
    return row


def _style_values(scene: Scene, group: int) -> Float64:
    """Return the numbers of a group's styles, shape (STYLE_SIZE,): start values unless the scene sets others."""
    said = dict(scene.group_styles[group]) if group < len(scene.group_styles) else {}
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
