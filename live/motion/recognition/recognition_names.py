"""Names of gestures and of numbers of a movement, in the words of a patch, and lengths of examples; cheap to import."""

from typing import Final

POSTURE_NAMES: Final = (
    "both arms up", "left arm up", "right arm up", "arms wide", "crouch", "kneel", "lie", "bow", "point left",
    "point right",
)  # fmt: skip
JUMP, TURN, CLAP = "jump", "turn", "clap"
GESTURE_NAMES: Final = (*POSTURE_NAMES, JUMP, TURN, CLAP)
"""All gestures that are known without an example."""
LEVELS: Final = ("energy", "size", "speed", "hands")
"""Numbers that are given in their own units: energy and speed [m/s], size and height of the hands [body heights]."""
MOVEMENT_NAMES: Final = (*LEVELS, "tempo")
"""All numbers of a dancer's movement."""
MIN_MOMENTS: Final = 6
"""Shortest example [moments]."""
MAX_MOMENTS: Final = 256
"""Longest example: 16 s."""
