"""The renderer's input: a `Scene` (set once per show) and a `StageView` (refilled each frame).

Metres, seconds, radians, beats; right-handed, Y up, +x to the right as the audience sees it, +z towards the
audience, the origin at the centre of the stage floor.
"""

import re
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.body.appearance import DEFAULT_APPEARANCE
from live.base.body.catalogue import CharacterFile
from live.base.body.expression import FACE_SIZE, HAND_SIZE
from live.base.custom_pass import PASSES, CustomShader
from live.base.errors import PersonError
from live.base.parameter import SPOT_COUNT
from live.base.set_geometry import SetItem

Colour = tuple[float, float, float]

GROUP_COLOURS: Final[tuple[Colour, ...]] = ((0.90, 0.42, 0.20), (0.16, 0.55, 0.75), (0.86, 0.74, 0.42))
"""Colours of groups for which the patch gives none."""

ELEMENT_CAPACITY: Final = 256
"""Maximum number of elements drawn; the others still act."""
ELEMENT_CORNERS: Final = 1024
"""Maximum number of drawn corners of all lines and regions together."""
SET_CAPACITY: Final = 64
"""Maximum number of obstacles drawn, and of walls."""
GUIDE_CAPACITY: Final = 8192
"""Maximum number of strokes of the operator's guides."""
LIGHT_CAPACITY: Final = 32
"""Maximum number of phone lights drawn."""
"""Number of follow spots."""
BACKGROUND_CAPACITY: Final = 8
"""Maximum number of backgrounds of a patch."""
FLOOR_MARGIN: Final = 2.5
"""Margin of the floor's shadow and element map around the scene's stage [m]."""


@dataclass(frozen=True, slots=True)
class Camera:
    """The audience's view: eye and target [m], vertical field of view [degrees]."""

    eye: tuple[float, float, float] = (0.0, 3.4, 11.5)
    target: tuple[float, float, float] = (0.0, 0.9, 0.0)
    field_of_view_deg: float = 40.0
    roll_deg: float = 0.0
    """Rotation about its axis, clockwise as seen from behind [degrees]."""
    shift: tuple[float, float] = (0.0, 0.0)
    """Lens shift of the picture's centre: to the right in picture widths, upwards in picture heights."""
    stretch: float = 1.0
    """Drawn width / height of a square that faces the camera."""
    skew: float = 0.0
    """Shift of a square's upper edge to the right, as a share of its height."""


STREAM_SCHEMES: Final = ("udp", "tcp", "srt", "rtsp", "http", "https")
KINDS_HINT: Final = "camera:0, shm:NAME or udp://0.0.0.0:5000"


def parse_input(text: str) -> tuple[str, str]:
    """Return kind (`camera`, `shm` or `stream`) and name of a live input as a patch names it; PersonError if it is
    none."""
    text = text.strip()
    scheme, found, _ = text.partition("://")
    if found and scheme in STREAM_SCHEMES:
        return "stream", text
    kind, found, name = text.partition(":")
    if kind == "shm" and re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", name):
        return kind, name
    if kind == "camera" and name.strip() and name.isprintable():
        return kind, name.strip()
    schemes = ", ".join(f"{scheme}://" for scheme in STREAM_SCHEMES)
    raise PersonError(f"{text[:80]!r} is no live input", f"{KINDS_HINT}; streams begin with {schemes}")


@dataclass(frozen=True, slots=True)
class Background:
    """A plane with an image, a video, an image sequence or a live input: behind, below or in front of the dancers."""

    file: str
    """Absolute path; empty if the file was lost during the show, or for a live input: nothing is drawn without it."""
    fit: str = "wall"
    """On the `wall` behind the stage (or where its place is), or over the whole `picture`."""
    beats: float | None = None
    """Loop length of a video in beats; None: its own speed."""
    width: float | None = None
    """Width [m]; None: 1.5 times the stage width, on the floor the stage width."""
    bottom: float = 0.0
    """Height of its lower edge above the floor [m]."""
    brightness: float = 1.0
    place: str = "behind"
    """`behind`, `floor` or `front`."""
    at: tuple[float, float] | None = None
    """Its centre (x, z) [m]; None: at the back wall, in the middle of the floor, or at the stage's front edge."""
    turn_deg: float = 0.0
    """Rotation on the floor, as a dancer's heading [degrees]."""
    blend: str = "over"
    """`over` what is behind it, or `add` its light, as a projection on a gauze does."""
    end: str = "loop"
    """What a video does at its end: `loop` or `hold` its last picture."""
    fps: float = 25.0
    """Pictures per second of an image sequence."""
    input: str = ""
    """Live input instead of a file: `camera:0`, `shm:NAME` or the address of a stream."""


@dataclass(frozen=True, slots=True)
class SceneryFile:
    """A set piece from a glTF file that stands on the stage."""

    file: str
    """Absolute path; empty if the file was lost during the show: nothing is drawn."""
    at: tuple[float, float] = (0.0, 0.0)
    """Where the middle of its underside stands (x, z) [m]."""
    turn_deg: float = 0.0
    """Rotation, as a dancer's heading [degrees]."""
    lift: float = 0.0
    """Height of its underside above the floor [m]."""
    scale: float = 1.0
    """Factor of the file's metres."""
    height: float | None = None
    """Its height [m] instead of `scale`."""


@dataclass(frozen=True, slots=True)
class Title:
    """Letters of a moment: a title, or a word of the audience."""

    text: str
    """`|` begins a new line."""
    place: str = "picture"
    """Over the `picture`, or standing in the `stage`, where dancers hide it and are hidden by it."""
    at: tuple[float, float, float] = (0.5, 0.5, 0.0)
    """Its middle: shares of the picture's width and height from the upper left corner, or x, y, z [m]."""
    size: float = 0.1
    """Height of a capital letter: share of the picture's height, or [m]."""
    tracking: float = 0.0
    """Space added between letters, in ems."""
    colour: Colour = (1.0, 1.0, 1.0)
    """Linear RGB; above 1 it glows."""
    entrance: str = "fade"
    """`cut`, `fade`, `rise`, `wipe` or `type`."""
    font: str = ""
    """Name of a font among those of the scene; empty: the usual font."""
    progress: float = 1.0
    """How far its entrance is, 0 to 1."""
    level: float = 1.0
    """Opacity, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Initial scene of a patch: stage size (width, depth) [m], camera, number of dancers.

    Camera and light may change while a show runs: `StageView.picture`.
    """

    stage_size: tuple[float, float]
    camera: Camera
    dancer_count: int
    joint_count: int
    group_colours: tuple[Colour, ...] = GROUP_COLOURS
    """Colour of each group's clothes; further groups have them again from the first on."""
    group_styles: tuple[tuple[tuple[str, tuple[float, ...]], ...], ...] = ()
    """Style of each group: addresses of `picture_parameters.GROUP_PARAMETERS` with their numbers; the rest has its
    defaults."""
    backgrounds: tuple[Background, ...] = ()
    """Images and videos behind the dancers; `/dance/background/1` is the amount of the first one."""
    scenery: tuple[SceneryFile, ...] = ()
    """Set pieces from files; `/dance/scenery/1` is the amount of the first one."""
    items: tuple[SetItem, ...] = ()
    """Boxes, cylinders and steps that stand on the stage."""
    fonts: tuple[tuple[str, str], ...] = ()
    """Fonts of titles and words: names, and absolute paths of their files."""
    passes: tuple[str, ...] = PASSES
    """The passes in drawing order; passes left out are never drawn."""
    custom_passes: tuple[CustomShader, ...] = ()
    """The patch's custom passes; their names are listed in `passes`."""
    start_values: tuple[tuple[str, float | tuple[float, ...]], ...] = ()
    """Picture parameters with a non-default start value: addresses and values."""
    bodies: tuple[str, ...] = ()
    """Name of each dancer's body (in `live.base.body.catalogue`, or a character's), from the first dancer on; the rest
    have the default body.
    """
    characters: tuple[CharacterFile, ...] = ()
    """Bodies that are loaded from files."""


@dataclass(slots=True, eq=False)
class StageView:
    """One moment of the stage, interpolated for the frame that will be drawn (A dancers, J joints)."""

    joint_position: Float32
    """World positions of the joints [m], shape (A, J, 3)."""
    joint_rotation: Float32
    """World rotations of the joints from the rest pose, unit quaternions (w, x, y, z), shape (A, J, 4)."""
    group: Int32
    """Group, or part of a group, of each dancer, shape (A,): the index of its colour and style."""
    present: Bool
    """Whether each dancer is on the stage, entering or leaving, shape (A,); the others are not drawn."""
    face: Float32
    """What each dancer's face does, shape (A, FACE_SIZE): the columns of `live.base.body.expression`."""
    hand: Float32
    """What the fingers of the left and the right hand do, shape (A, 2, HAND_SIZE): columns as above."""
    spring: Float32
    """Rotations of the bones of characters that swing, from the rest pose and relative to the joint from which they
    hang, unit quaternions (w, x, y, z), shape (slots, bones, 4)."""
    spring_slot: Int32
    """Row of `spring` that each dancer has, -1: none, shape (A,)."""
    appearance: Int32
    """What each dancer looks like, shape (A, APPEARANCE_SIZE): the columns of `live.base.body.appearance`."""
    cloth_position: Float32 = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    """Particles of all garments [m], shape (N, 3): of each one row by row, as in its pattern
    (`live.motion.cloth.garment_catalogue`)."""
    cloth_garment: Int32 = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    """Garments that move by themselves, shape (G, 3): dancer, pattern by its place in `PATTERN_NAMES`, first
    particle."""
    element_kind: Int32 = field(default_factory=lambda: np.zeros(ELEMENT_CAPACITY, np.int32))
    element_position: Float32 = field(default_factory=lambda: np.zeros((ELEMENT_CAPACITY, 2), np.float32))
    """Stage positions (x, z) [m] of the active elements, shape (256, 2); the first `element_count` are valid."""
    element_level: Float32 = field(default_factory=lambda: np.zeros(ELEMENT_CAPACITY, np.float32))
    """Current strength of each element, 0 to 1 (it fades in and out), shape (256,)."""
    element_radius: Float32 = field(default_factory=lambda: np.zeros(ELEMENT_CAPACITY, np.float32))
    """Radius of a point's disc, or of the band around a line [m], shape (256,)."""
    element_strength: Float32 = field(default_factory=lambda: np.ones(ELEMENT_CAPACITY, np.float32))
    """Strength; 1 is the default; a negative flow is reversed, shape (256,)."""
    element_flow: Int32 = field(default_factory=lambda: np.zeros(ELEMENT_CAPACITY, np.int32))
    """Flow type of elements of kind FLOW, UNIFORM to GRID, shape (256,)."""
    element_first: Int32 = field(default_factory=lambda: np.zeros(ELEMENT_CAPACITY, np.int32))
    """Index of each line's or region's first corner in `element_corner`, shape (256,)."""
    element_corners: Int32 = field(default_factory=lambda: np.zeros(ELEMENT_CAPACITY, np.int32))
    """Number of corners of each element, shape (256,); below 2: a point at `element_position`."""
    element_corner: Float32 = field(default_factory=lambda: np.zeros((ELEMENT_CORNERS, 2), np.float32))
    """Corners (x, z) [m] of all elements, shape (1024, 2); a closed line repeats its first corner at the end."""
    element_count: int = 0
    light: Float32 = field(default_factory=lambda: np.zeros((LIGHT_CAPACITY, 5), np.float32))
    """Phone lights: x, z [m], hue 0 to 1, level 0 to 1, and 1 for one that repels; shape (32, 5)."""
    light_count: int = 0
    obstacle: Float32 = field(default_factory=lambda: np.zeros((SET_CAPACITY, 4), np.float32))
    """Round obstacles: x, z, radius [m], and 1 for an item of the set, 0 for a real dancer; shape (64, 4)."""
    obstacle_count: int = 0
    wall: Float32 = field(default_factory=lambda: np.zeros((SET_CAPACITY, 4), np.float32))
    """Walls: x1, z1, x2, z2 [m], shape (64, 4)."""
    wall_count: int = 0
    time: float = 0.0
    beat: float = 0.0
    measure: int = 0
    """Number of the measure, from 0."""
    phase: float = 0.0
    """Beats into the measure."""
    beats_per_measure: int = 4
    tempo: float = 120.0
    stage_size: tuple[float, float] = (0.0, 0.0)
    """Current width and depth of the stage [m]; 0: as in the scene."""
    brightness: float = 1.0
    """1 = full light, 0 = blackout."""
    flash_limit_lifted: bool = False
    """Whether the limit on flashes is lifted."""
    filled: bool = False
    """Whether it has been filled; a frozen picture keeps showing it."""
    detailed: bool = False
    """Whether others than the show's camera look at the dancers: nobody's details are left out."""
    picture: Float64 | None = None
    """Current light, colours and camera: the row of `live.base.picture_parameters`; None: as in the scene."""
    energy: float = 0.5
    """Energy of the music, 0 to 1."""
    spot: Float64 = field(default_factory=lambda: np.zeros((SPOT_COUNT, 2)))
    """Positions of the follow spots (x, z) [m], shape (4, 2)."""
    gobo_turns: float = 0.0
    """How far the pattern in the key light has turned [turns], 0 to 1."""
    count_in: float = 0.0
    """Beats until the cue that is counting in; 0: none."""
    caption: tuple[tuple[str, float], ...] = ()
    """Lines for the audience: a text, and a share from 0 to 1 that a bar shows; -1: no bar. Empty = hidden."""
    caption_level: float = 1.0
    """Opacity of the caption, 0 to 1."""
    background_age: Float64 = field(default_factory=lambda: np.zeros((BACKGROUND_CAPACITY, 2)))
    """Seconds and beats since each background was last dark, shape (8, 2): a video that holds its end runs so long."""
    titles: tuple[Title, ...] = ()
    """Titles and words that are seen, in drawing order."""
    overlay: tuple[str, ...] = ()
    """Lines of the operator's overlay; empty = hidden."""
    guide: Float32 = field(default_factory=lambda: np.zeros((GUIDE_CAPACITY, 10), np.float32))
    """Strokes of the operator's guides: from x, y, z to x, y, z [m], displayed colour r, g, b, a; shape (8192, 10)."""
    guide_count: int = 0
    """Number of strokes drawn; 0 = hidden."""

    @staticmethod
    def allocate(dancer_count: int, joint_count: int) -> "StageView":
        """Return a view for `dancer_count` dancers of `joint_count` joints, all at the origin."""
        rotation = np.zeros((dancer_count, joint_count, 4), np.float32)
        rotation[..., 0] = 1.0
        return StageView(
            joint_position=np.zeros((dancer_count, joint_count, 3), np.float32),
            joint_rotation=rotation,
            group=np.zeros(dancer_count, np.int32),
            present=np.ones(dancer_count, np.bool_),
            face=np.zeros((dancer_count, FACE_SIZE), np.float32),
            hand=np.zeros((dancer_count, 2, HAND_SIZE), np.float32),
            spring=np.zeros((0, 0, 4), np.float32),
            spring_slot=np.full(dancer_count, -1, np.int32),
            appearance=np.tile(np.array(DEFAULT_APPEARANCE, np.int32), (dancer_count, 1)),
        )
