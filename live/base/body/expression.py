"""Columns of what a dancer's face and hands do now: `StageView.face` and `StageView.hand`."""

from typing import Final

GAZE_YAW: Final = 0
"""Direction of the eyes relative to the head [rad]: to the dancer's left, …"""
GAZE_PITCH: Final = 1
"""… and up."""
BLINK_LEFT: Final = 2
"""How far an eye is closed: 0 open, 1 closed."""
BLINK_RIGHT: Final = 3
BROW: Final = 4
"""Brows: -1 frown, 1 raised."""
MOUTH_OPEN: Final = 5
"""0 closed, 1 wide open."""
SMILE: Final = 6
"""Corners of the mouth: -1 down, 1 up."""
BREATH: Final = 7
"""Chest: -1 breathed out, 1 breathed in."""
EFFORT: Final = 8
"""0 at rest, 1 the hardest effort."""
FACE_SIZE: Final = 9
"""Number of columns of a face."""

CURL: Final = slice(0, 5)
"""Curl of each of `FINGERS`: 0 straight, 1 closed in a fist."""
SPREAD: Final = 5
"""Spread of the fingers: -1 pressed together, 1 wide."""
HAND_SIZE: Final = 6
"""Number of columns of a hand."""
FINGERS: Final = ("Thumb", "Index", "Middle", "Ring", "Little")
"""The fingers in the order of `CURL`."""
LEFT: Final = 0
"""Row of the left hand, …"""
RIGHT: Final = 1
"""… and of the right one."""
