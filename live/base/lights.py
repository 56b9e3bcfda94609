"""Lamps beside key and rim light: sides, back, beams in the haze, follow spots; what the light answers. One line each.

Parameters of the picture's row (`live.base.picture`); colours are linear RGB.
"""

from typing import Final, Literal

from live.base.stage_snapshot import SPOT_CAPACITY

Kind = Literal["number", "colour", "place"]
_Line = tuple[str, Kind, float, float, tuple[float, ...], str, str]

SPOTS: Final = SPOT_CAPACITY
"""Follow spots there are."""


BACKGROUNDS: Final = 8
"""Images and videos behind the dancers that a patch can have."""


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
            f"How far follow spot {number} reaches around her.",
        ),
    )


LINES: Final[tuple[_Line, ...]] = (
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
    ("/dance/light/pulse", "number", 0, 1, (0.06,), "", "How much all light answers the beat."),
    ("/dance/light/energy", "number", 0, 1, (0.0,), "", "How much all light follows the energy of the music."),
    (
        "/dance/light/stage", "number", 0, 1, (1.0,), "",
        "How much of floor and wall is seen; 0: dancers alone before true black, as for a gauze.",
    ),
    ("/dance/background/gradient", "number", 0, 1, (0.0,), "", "How much the wall is a gradient of two colours."),
    ("/dance/background/top", "colour", 0, 1, (0.02, 0.03, 0.12), "", "Colour of that gradient above."),
    ("/dance/background/bottom", "colour", 0, 1, (0.30, 0.07, 0.05), "", "Colour of that gradient below."),
    *(
        (f"/dance/background/{number}", "number", 0, 1, (0.0,), "", f"How much of [[background]] {number} is seen.")
        for number in range(1, BACKGROUNDS + 1)
    ),
    *(line for number in range(1, SPOTS + 1) for line in _spot(number)),
)  # fmt: skip
"""Address, kind, least, most, start, unit, words."""
STANDING: Final = ("/dance/background/gradient", "/dance/background/top", "/dance/background/bottom")
"""Those of them that the kept backdrop shows."""
