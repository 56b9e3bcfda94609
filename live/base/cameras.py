"""How a camera sees beyond its place and angle, and how it moves: parameters of the picture's row, one line each.

They lie behind the camera's eye, target and angle of view in `live.base.picture`.
"""

from typing import Final, Literal

Kind = Literal["number", "colour", "place"]

LINES: Final[tuple[tuple[str, Kind, float, float, tuple[float, ...], str, str], ...]] = (
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
        "How fast the camera goes around what it looks at, to its right; 0.125 is once in eight measures.",
    ),
    (
        "/dance/camera/following", "number", 0, 1, (0.0,), "",
        "How far the camera turns to whom it follows; 0: it looks where it is told.",
    ),
    (
        "/dance/camera/along", "number", 0, 1, (0.0,), "",
        "How far the camera itself goes along with whom it follows; 0: it turns where it stands.",
    ),
    (
        "/dance/camera/plan", "number", 0, 1, (0.0,), "",
        "How much of the plan is drawn over the picture: circles with triangles, where they came from.",
    ),
)  # fmt: skip
"""Address, kind, least, most, start, unit, words."""
