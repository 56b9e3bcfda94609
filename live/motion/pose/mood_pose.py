"""How a mood changes poses (T143): posture, size, gaze and weight of any step, recorded or sketched.

The moods are Laban's efforts (weight, time, space, flow) and two of the thesis' shy and graceful dancers (confidence,
energy), each from -1 to 1. Each end of a mood bends joints of the upper body by fixed angles, and they add up. The legs
keep their feet: only the hips sink. Free flow lets movements run along the arms, and moods breathe. Time changes when
poses are danced, not the poses; see `Variation`. Where a library has examples, the ends are learnt from them; see
`mood_examples`.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.motion.skeleton import SKELETON

WEIGHT, TIME, SPACE, FLOW, CONFIDENCE, ENERGY = range(6)
"""Rows of a mood, shape (6, A)."""
FIRST, LAST = SKELETON.index("spine"), SKELETON.index("leftUpperLeg")
"""Joints FIRST..LAST-1 are bent: the upper body."""
UPPER: Final = LAST - FIRST

_TRUNK: Final = ("spine", "chest", "upperChest", "neck", "head")
_SIDES: Final = {"shoulders back": ("Shoulder", 1, 1.0), "shoulders up": ("Shoulder", 2, 1.0),
                 "arms out": ("UpperArm", 2, 1.0), "elbows": ("LowerArm", 1, -1.0)}  # fmt: skip
"""Joint of each side, axis of its parent, and the sense for the left side."""
_ENDS: Final[dict[tuple[int, int], dict[str, float]]] = {
    (WEIGHT, 1): {"spine": 3, "chest": 3, "head": -2, "arms out": -7, "shoulders up": -3},
    (WEIGHT, -1): {"upperChest": -4, "head": -2, "arms out": 11, "shoulders up": 2},
    (SPACE, 1): {"elbows": -8, "chest": -1},
    (FLOW, 1): {"arms out": 9, "upperChest": -2},
    (FLOW, -1): {"elbows": 20, "arms out": -7, "shoulders up": 5},
    (CONFIDENCE, 1): {"spine": -2, "chest": -4, "upperChest": -5, "head": 6, "shoulders back": 7, "shoulders up": -3,
                      "arms out": 8},
    (CONFIDENCE, -1): {"spine": 3, "chest": 6, "upperChest": 8, "neck": 4, "head": 7, "shoulders back": -10,
                       "shoulders up": 6, "arms out": -9, "elbows": 14},
    (ENERGY, 1): {"spine": -1, "chest": -2, "upperChest": -2},
    (ENERGY, -1): {"spine": 4, "chest": 6, "upperChest": 6, "neck": 5, "head": 6, "shoulders up": -5, "arms out": -5},
}  # fmt: skip
"""Angles [degrees] at the ends of the moods: leans forward; shoulders back and up, arms out, elbows bent."""
_SIZE: Final = {FLOW: 0.18, CONFIDENCE: 0.12, ENERGY: 0.3}
"""Logarithm of the factor by which the upper body moves more at the upper end."""
MAX_SIZE: Final = 1.4
"""Largest factor of the upper body's amplitude; the least is MAX_SIZE ** -2."""
_DROP: Final = {(WEIGHT, 1): 0.055, (CONFIDENCE, -1): 0.015, (ENERGY, -1): 0.03}
"""How far the hips sink at an end [m]."""
MAX_DROP: Final = 0.075
"""How far they sink at most if several moods add up [m]."""
DIRECT_GAZE: Final = 0.7
"""Share of the head's turn to the audience in the most direct mood."""
ROAM_S: Final = 3.7
"""Trunk and gaze of an indirect mood roam with this period [s] ..."""
_ROAM: Final = {"chest": 9.0, "neck": 8.0, "head": 14.0}
"""... so far to both sides [degrees], each dancer at another time."""
LATE_BEATS: Final = 0.3
"""How late the hands are in the freest mood [beats]: movements run from the shoulder along the arm."""
_BREATHS: Final = {(ENERGY, 1): (2.6, 1.0), (ENERGY, -1): (5.2, 1.3), (CONFIDENCE, 1): (4.1, 0.6)}
"""Breath that an end adds: its period [s] and its depth. The awake breathe quickly, the tired heavily, and the proud
into the chest; besides, each step has its own breath."""
_BREATH: Final = {"chest": -1.5, "upperChest": -2.5, "neck": 1.5, "head": 1.0}
"""How a breath of depth 1 bends the trunk [degrees]; the shoulders rise with it ..."""
_BREATH_SHOULDERS: Final = 3.0
"""... by so much [degrees]."""


def _table() -> Float32:
    """Return the joints' rotation vectors at the upper and the lower end of each mood, (2, 6, UPPER, 3) [rad]."""
    table = np.zeros((2, 6, UPPER, 3), np.float32)
    for (mood, end), angles in _ENDS.items():
        row = table[0 if end > 0 else 1, mood]
        for words, angle in angles.items():
            if words in _TRUNK:
                row[SKELETON.index(words) - FIRST, 0] += math.radians(angle)
                continue
            joint, axis, sense = _SIDES[words]
            for side, sign in (("left", sense), ("right", -sense)):
                row[SKELETON.index(side + joint) - FIRST, axis] += sign * math.radians(angle)
    return table


@dataclass(frozen=True, slots=True, eq=False)
class MoodEnds:
    """What the upper (0) and the lower (1) end of each of the six moods does to a dancer."""

    bend: Float32
    """Rotation vectors of the joints of the upper body about their parents' axes, (2, 6, UPPER, 3)."""
    size: Float64
    """Logarithm of the factor by which the upper body moves more, (2, 6)."""
    drop: Float64
    """How far the hips sink [m], (2, 6)."""

    @classmethod
    def parametric(cls) -> "MoodEnds":
        """The ends of the tables above."""
        size, drop = np.zeros((2, 6)), np.zeros((2, 6))
        for row, share in _SIZE.items():
            size[:, row] = share, -share
        for (row, end), far in _DROP.items():
            drop[0 if end > 0 else 1, row] = far
        return cls(_table(), size, drop)


PARAMETRIC: Final = MoodEnds.parametric()


class MoodPose:
    """What the moods of A dancers change in their poses. `set` fills its arrays."""

    def __init__(self, count: int) -> None:
        self.bend: Float32 = np.zeros((count, UPPER, 3), np.float32)
        """Rotation vectors by which joints are bent more, about their parents' axes, shape (A, UPPER, 3)."""
        self.size: Float32 = np.ones(count, np.float32)
        """Factor of the upper body's amplitude, shape (A,)."""
        self.drop: Float32 = np.zeros(count, np.float32)
        """How far the hips sink [m], shape (A,)."""
        self.gaze: Float32 = np.zeros(count, np.float32)
        """Share of the head's turn to the audience, shape (A,)."""
        self.late: Float64 = np.zeros(count)
        """How late the hands are [beats], shape (A,)."""
        self._own = np.arange(count) * 0.381966  # each dancer roams and breathes at another time
        self._still = np.zeros_like(self.bend)  # without what roams and breathes
        self._set_for: tuple[Float64, MoodEnds] | None = None  # what the arrays hold, but for what roams and breathes

    def set(self, mood: Float64, time: float, ends: MoodEnds = PARAMETRIC) -> None:
        """Set all arrays for `mood` (6, A) at `time` [s]."""
        before = self._set_for
        if before is None or before[1] is not ends or not np.array_equal(before[0], mood):
            self._set_for = mood.copy(), ends
            self._set_still(mood, ends)
        upper, lower = np.maximum(mood, 0.0).T, np.maximum(-mood, 0.0).T
        roam = lower[:, SPACE]
        if roam.any():
            turn = roam * np.sin(2.0 * np.pi * (time / ROAM_S + self._own))
            for name, angle in _ROAM.items():
                self._swing(name, 1, math.radians(angle) * turn)
        self._breathe(upper, lower, time)

    def _set_still(self, mood: Float64, ends: MoodEnds) -> None:
        """Set what does not change while the moods stay."""
        upper, lower = np.maximum(mood, 0.0).T, np.maximum(-mood, 0.0).T
        flat = ends.bend.reshape(2, 6, -1)
        self._still.reshape(len(self.bend), -1)[:] = (
            upper.astype(np.float32) @ flat[0] + lower.astype(np.float32) @ flat[1]
        )
        self.bend[:] = self._still
        size = upper @ ends.size[0] + lower @ ends.size[1]
        self.size[:] = np.clip(np.exp(size), MAX_SIZE**-2, MAX_SIZE)
        self.drop[:] = np.clip(upper @ ends.drop[0] + lower @ ends.drop[1], 0.0, MAX_DROP)
        self.gaze[:] = DIRECT_GAZE * upper[:, SPACE]
        self.late[:] = LATE_BEATS * upper[:, FLOW]

    def _breathe(self, upper: Float64, lower: Float64, time: float) -> None:
        """Add the breath; those whose flow is bound hold theirs."""
        breath = None
        for (row, end), (period, depth) in _BREATHS.items():
            share = (upper if end > 0 else lower)[:, row]
            if share.any():
                one = depth * share * np.sin(2.0 * np.pi * (time / period + self._own))
                breath = one if breath is None else breath + one
        if breath is None:
            return
        breath *= 1.0 - lower[:, FLOW]
        for name, angle in _BREATH.items():
            self._swing(name, 0, math.radians(angle) * breath)
        for side, sign in (("left", 1.0), ("right", -1.0)):
            self._swing(f"{side}Shoulder", 2, sign * math.radians(_BREATH_SHOULDERS) * breath)

    def _swing(self, name: str, axis: int, angle: Float64) -> None:
        """Bend a joint about one axis by `angle` (A,) [rad] more than it is bent without roaming and breathing."""
        joint = SKELETON.index(name) - FIRST
        self.bend[:, joint, axis] = self._still[:, joint, axis] + angle
