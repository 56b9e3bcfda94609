"""How the dancers of a group are drawn: the parameters that every group has for itself, each one line here.

Styles are amounts from 0 to 1 that add up as they come, so that one fades into another; they are part of the picture's
row (`live.base.picture`), after the groups' colours. Colours are linear RGB.
"""

from typing import Final, Literal

Kind = Literal["number", "colour", "place"]

AMOUNTS: Final = ("solid", "silhouette", "ink", "particles", "ribbons", "trails", "xray")
"""The styles; what each group has of them is at `/dance/draw/NAME`."""
MOST_GHOSTS: Final = 8
LONGEST_RIBBON: Final = 8.0
"""[beats]"""

LINES: Final[tuple[tuple[str, Kind, float, float, tuple[float, ...], str, str], ...]] = (
    ("solid", "number", 0, 1, (1.0,), "", "How much of a group's dancers is drawn as lit bodies."),
    ("silhouette", "number", 0, 1, (0.0,), "", "How much of them is one flat colour, for projection on gauze."),
    ("silhouette/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Colour of the silhouettes."),
    ("ink", "number", 0, 1, (0.0,), "", "How much of them is drawn as ink lines along their contours."),
    ("ink/colour", "colour", 0, 1, (1.0, 1.0, 1.0), "", "Colour of the ink."),
    ("ink/width", "number", 0.5, 8, (2.4,), "pixels", "How broad the ink is in a picture 1080 pixels high."),
    ("particles", "number", 0, 1, (0.0,), "", "How much of them are points of light on their skin."),
    ("particles/share", "number", 0, 1, (0.7,), "", "How many of the points there are."),
    ("particles/drift", "number", 0, 1, (0.35,), "", "How far points leave the skin and rise while they fade."),
    ("ribbons", "number", 0, 1, (0.0,), "", "How strong the ribbons are that hands and feet draw."),
    ("ribbons/beats", "number", 0.25, LONGEST_RIBBON, (2.0,), "beats", "How long the ribbons stay."),
    ("trails", "number", 0, 1, (0.0,), "", "How strong the ghosts are that they leave behind on the beat."),
    ("trails/ghosts", "number", 1, MOST_GHOSTS, (4.0,), "", "How many ghosts each dancer leaves."),
    ("trails/spacing", "number", 0.25, 16, (1.0,), "beats", "How many beats lie between two ghosts."),
    ("xray", "number", 0, 1, (0.0,), "", "How much of them is a skeleton that glows in a body of glass."),
    ("variety", "number", 0, 1, (0.2,), "", "How much the colours of a group's dancers differ."),
    ("pulse", "number", 0, 1, (0.0,), "", "How much their colours answer the beat."),
    ("sheen", "number", 0, 3, (1.0,), "", "How much their clothes shine in the light."),
    ("emission", "number", 0, 2, (0.0,), "", "How much their clothes give light of their own."),
)
"""Name under `/dance/draw/`, kind, least, most, start, unit, words."""
