"""Hand shapes of dance styles, by name: how far each finger is curled, and how the fingers are spread.

A row has the columns of `live.base.body.expression`: curl of thumb, index, middle, ring and little finger, 0 straight
to 1 closed in a fist, and the spread of the fingers, -1 pressed together to 1 wide. The ballet hand is Vaganova's
(*Basic Principles of Classical Ballet*, 1934): the thumb near the middle finger, which is the most curved, index and
little finger a little apart.
"""

from typing import Final

import numpy as np

from live.base.arrays import Float32

AUTO: Final = "auto"
"""No shape of its own: by the arm's reach, the dance's energy, and what the hand does."""
_SHAPES: Final[dict[str, tuple[float, float, float, float, float, float]]] = {
    # thumb, index, middle, ring, little finger, spread
    "relaxed": (0.22, 0.20, 0.27, 0.33, 0.38, -0.10),
    "ballet": (0.45, 0.06, 0.34, 0.24, 0.10, -0.15),
    "soft": (0.18, 0.10, 0.17, 0.21, 0.24, 0.05),
    "flat": (0.12, 0.02, 0.02, 0.02, 0.03, -0.75),
    "jazz": (0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
    "blade": (0.55, 0.0, 0.0, 0.0, 0.0, -1.0),
    "open": (0.08, 0.05, 0.06, 0.07, 0.09, 0.45),
    "samba": (0.15, 0.05, 0.30, 0.36, 0.16, 0.35),
    "flamenco": (0.30, 0.10, 0.35, 0.58, 0.78, 0.55),
    "claw": (0.45, 0.50, 0.50, 0.50, 0.52, 0.70),
    "point": (0.62, 0.0, 0.92, 0.95, 0.95, -0.40),
    "fist": (0.85, 1.0, 1.0, 1.0, 1.0, -0.60),
    "hold": (0.45, 0.55, 0.60, 0.62, 0.60, -0.40),
}
SHAPE_NAMES: Final = tuple(_SHAPES)
"""Names of the shapes, in the order of `SHAPES`."""
SHAPES: Final[Float32] = np.array(list(_SHAPES.values()), np.float32)
"""The shapes, (SHAPE_COUNT, HAND_SIZE)."""
_SOFTNESS: Final = {"relaxed": 1.0, "soft": 0.8, "ballet": 0.5, "samba": 0.3, "flamenco": 0.2}
SOFTNESS: Final[Float32] = np.array([_SOFTNESS.get(name, 0.0) for name in SHAPE_NAMES], np.float32)
"""How far the fingers of each shape straighten as the arm does, and differ from dancer to dancer, (SHAPE_COUNT,)."""
NO_SHAPE: Final = -1
"""Index of `AUTO`."""
RELAXED: Final = SHAPE_NAMES.index("relaxed")
SOFT: Final = SHAPE_NAMES.index("soft")
FLAT: Final = SHAPE_NAMES.index("flat")
OPEN: Final = SHAPE_NAMES.index("open")
FIST: Final = SHAPE_NAMES.index("fist")
HOLD: Final = SHAPE_NAMES.index("hold")


def shape_index(name: str) -> int | None:
    """Return the index of the shape called `name`, NO_SHAPE for `auto`, None if there is none; case does not count."""
    wanted = name.strip().casefold()
    if wanted == AUTO:
        return NO_SHAPE
    return SHAPE_NAMES.index(wanted) if wanted in _SHAPES else None
