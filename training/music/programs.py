"""General MIDI programs by family, and kits."""

from random import Random

FAMILIES: dict[str, tuple[int, ...]] = {
    "piano": (0, 0, 0, 1, 2, 3), "epiano": (4, 5, 4, 5, 7), "harpsichord": (6,), "music box": (8, 9, 10, 14, 98),
    "mallets": (11, 12, 13, 12, 108, 114), "organ": (16, 17, 18, 19, 20), "accordion": (21, 22, 23),
    "nylon": (24,), "steel": (25, 25, 24, 105), "electric": (26, 27, 28), "distorted": (29, 30, 30),
    "bass": (33, 34, 33, 34, 35, 36), "upright": (32,), "synth bass": (38, 39, 87), "violin": (40, 110),
    "strings": (48, 49, 50, 51), "solo strings": (40, 41, 42), "pizzicato": (45,), "harp": (46,),
    "choir": (52, 53, 54, 85, 91),
    "brass": (61, 62, 63), "solo brass": (56, 57, 58, 60), "reeds": (64, 65, 66, 67, 68, 71),
    "flutes": (72, 73, 74, 75, 79),
    "pipes": (73, 74, 75, 78, 109, 21, 110), "lead": (80, 81, 82, 84, 86, 87), "pad": (88, 89, 90, 91, 92, 93, 94, 95),
    "bells": (9, 14, 11, 112), "ethnic": (104, 105, 106, 107, 15), "tuned drums": (47, 114, 115, 116, 117, 118),
    "chip": (80, 81, 80, 38, 39), "tuba": (58, 32, 57),
}  # fmt: skip

KITS = {"standard": 0, "room": 8, "power": 16, "electronic": 24, "808": 25, "jazz": 32, "brush": 40, "orchestra": 48}


def program(rng: Random, *families: str, wild: float = 0.04) -> int:
    """A program of one of these families; seldom any at all."""
    if rng.random() < wild:
        return rng.randrange(0, 112)
    return rng.choice(FAMILIES[rng.choice(families)])


def kit(rng: Random, *names: str) -> int:
    """A kit as a part's program (negative)."""
    return -1 - KITS[rng.choice(names or ("standard", "room", "power"))]
