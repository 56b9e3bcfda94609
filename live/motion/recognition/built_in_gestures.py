"""Gestures that are known without an example: postures that are taken, and jump, turn and clap.

A posture is a set of limits on what a body does at a moment, in its own measures (`gesture_kernels`): arm lengths, and
heights of the standing body. `margin` is how far inside the limits the body is; the gesture begins when it was inside
for the posture's time, and another one needs that the body was clearly outside in between (hysteresis), and
`REFRACTORY_S`.
"""

import math
from collections.abc import Callable, Container
from typing import Final

from live.base.arrays import Float64
from live.motion.recognition import gesture_kernels as body
from live.motion.recognition.body_stream import RATE
from live.motion.recognition.recognition_names import CLAP, GESTURE_NAMES, JUMP, TURN

Margin = Callable[[list[float]], float]
"""Margin of a posture, from `BodyStream.measure` as a list; positive inside."""

UP: Final = 0.25
"""How far a raised wrist is over the head's joint [arm lengths]: about at the crown."""
DOWN: Final = -0.05
"""How far the other wrist is over its shoulder at most, for one raised arm."""
OUT: Final = 0.8
"""How far out a stretched arm reaches to its side."""
LEVEL: Final = 0.4
"""How far over or below the shoulder it may be."""
UPRIGHT: Final = 0.65
"""Cosine of the trunk's slope at least, for arms that are raised and for a crouch: 49 degrees."""
CROUCHED: Final = 0.72
"""Height of the hips in a crouch, at most [heights of standing hips]."""
KNEE_ON_FLOOR: Final = 0.36
"""Height of a knee that kneels, at most [heights of a standing knee]."""
BENT: Final = 0.55
"""Cosine of the trunk's slope in a bow, at most: 57 degrees."""
LYING: Final = 0.42
"""Height of the hips over the lowest joint when lying, at most [heights of standing hips]."""


def _both_up(m: list[float]) -> float:
    return min(m[body.UP_LEFT] - UP, m[body.UP_RIGHT] - UP, m[body.TRUNK_UP] - UPRIGHT)


def _left_up(m: list[float]) -> float:
    return min(m[body.UP_LEFT] - UP, DOWN - m[body.LEVEL_RIGHT], m[body.TRUNK_UP] - UPRIGHT)


def _right_up(m: list[float]) -> float:
    return min(m[body.UP_RIGHT] - UP, DOWN - m[body.LEVEL_LEFT], m[body.TRUNK_UP] - UPRIGHT)


def _wide(m: list[float]) -> float:
    level = max(abs(m[body.LEVEL_LEFT]), abs(m[body.LEVEL_RIGHT]))
    return min(m[body.OUT_LEFT] - OUT, m[body.OUT_RIGHT] - OUT, LEVEL - level, m[body.TRUNK_UP] - UPRIGHT)


def _crouch(m: list[float]) -> float:
    knees = min(m[body.KNEE_LEFT], m[body.KNEE_RIGHT])
    return min(CROUCHED - m[body.HIPS_UP], knees - KNEE_ON_FLOOR - 0.1, m[body.TRUNK_UP] - UPRIGHT)


def _kneel(m: list[float]) -> float:
    knees = min(m[body.KNEE_LEFT], m[body.KNEE_RIGHT])
    return min(KNEE_ON_FLOOR - knees, m[body.TRUNK_UP] - 0.5, m[body.HIPS_OVER_ALL] - LYING)


def _lie(m: list[float]) -> float:
    return min(LYING - m[body.HIPS_OVER_ALL], 0.5 - m[body.TRUNK_UP])


def _bow(m: list[float]) -> float:
    return min(BENT - m[body.TRUNK_UP], m[body.HIPS_UP] - 0.75)


def _point_left(m: list[float]) -> float:
    reach = min(m[body.OUT_LEFT] - OUT, m[body.REACH_LEFT] - 0.88, LEVEL - abs(m[body.LEVEL_LEFT]))
    other = max(0.5 - m[body.OUT_RIGHT], -0.5 - m[body.LEVEL_RIGHT])
    return min(reach, other, m[body.TRUNK_UP] - UPRIGHT)


def _point_right(m: list[float]) -> float:
    reach = min(m[body.OUT_RIGHT] - OUT, m[body.REACH_RIGHT] - 0.88, LEVEL - abs(m[body.LEVEL_RIGHT]))
    other = max(0.5 - m[body.OUT_LEFT], -0.5 - m[body.LEVEL_LEFT])
    return min(reach, other, m[body.TRUNK_UP] - UPRIGHT)


POSTURES: Final[dict[str, tuple[Margin, float]]] = {
    "both arms up": (_both_up, 0.12), "left arm up": (_left_up, 0.25), "right arm up": (_right_up, 0.25),
    "arms wide": (_wide, 0.25), "crouch": (_crouch, 0.25), "kneel": (_kneel, 0.25), "lie": (_lie, 0.5),
    "bow": (_bow, 0.2), "point left": (_point_left, 0.25), "point right": (_point_right, 0.25),
}  # fmt: skip
"""Of each posture its margin, and how long it is held until it counts [s]."""

HYSTERESIS: Final = 0.12
"""How far outside its limits a body is that has left a posture."""
REFRACTORY_S: Final = 0.5
"""Shortest time from one gesture to the next one of the same kind [s]."""
FLIGHT_HEIGHT: Final = 0.07
"""Height of the lower sole over the floor in a jump [m]."""
LIFT_SHARE: Final = 0.5
"""Smoothing of that height: share of a new one per moment."""
FLOOR_STEP: Final = 0.002
"""How far the floor follows the feet per moment [m]."""
FLIGHT_MOMENTS: Final = 2
"""Moments for which it is that high."""
LONGEST_FLIGHT_S: Final = 1.2
"""After this time in the air [s] the floor is where the feet are."""
FULL_TURN: Final = 5.2
"""Angle that counts as a turn [rad]: 300 degrees, because a turn is ended on another foot."""
TURNING: Final = 1.0
"""Least speed of a turn [rad/s]; a turn that is slower for `TURN_PAUSE_S` is over."""
TURN_PAUSE_S: Final = 0.3
CLAP_APART: Final = 0.55
"""Distance of the wrists of a clap at most [arm lengths]: palms touch, wrists are behind them."""
CLAP_OPEN: Final = 0.75
"""Distance beyond which the hands have opened for the next clap."""
CLAP_SPEED: Final = 0.9
"""Least speed of the hands towards each other before a clap [m/s]."""


class BuiltInGestures:
    """State of all gestures that are known without an example, of one body. Thread: one at a time."""

    def __init__(self) -> None:
        count = len(GESTURE_NAMES)
        self._inside = [0.0] * count
        """For how long [s] the body has been inside each posture; negative after it was told, until it has left."""
        self._moment = 0
        """Number of moments so far."""
        self._told = [-1_000_000] * count
        """The moment when each was told last."""
        self._floor, self._hips, self._flight = math.inf, 0.0, 0
        self._lift, self._rise = 0.0, 0.0
        self._turned, self._pause = 0.0, 0.0
        self._apart, self._closing, self._open = 0.0, 0.0, False

    def reset(self) -> None:
        """Begin anew after a gap: the floor and what was told last stay."""
        self._inside = [0.0] * len(GESTURE_NAMES)
        self._flight, self._turned, self._pause = 0, 0.0, 0.0
        self._apart, self._closing, self._open = 0.0, 0.0, False

    def follow(self, measure: Float64, wanted: Container[str] = GESTURE_NAMES) -> list[str]:
        """Return the names of the `wanted` gestures that are made at this moment, see `BodyStream.measure`."""
        m = measure.tolist()
        self._moment += 1
        made = []
        for index, (name, (margin, held)) in enumerate(POSTURES.items()):
            if name not in wanted:
                continue
            inside = margin(m)
            before = self._inside[index]
            if inside < (-HYSTERESIS if before < 0.0 else 0.0):
                self._inside[index] = 0.0
            elif before >= 0.0 and inside >= 0.0:
                self._inside[index] = before + 1.0 / RATE
                if before + 1.0 / RATE >= held:
                    self._inside[index] = -1.0
                    made += self._tell(name)
        if JUMP in wanted and self._jumps(m):
            made += self._tell(JUMP)
        if TURN in wanted and self._turns(m[body.TURNED]):
            made += self._tell(TURN)
        if CLAP in wanted and self._claps(m[body.HANDS_APART]):
            made += self._tell(CLAP)
        return made

    def _tell(self, name: str) -> list[str]:
        index = GESTURE_NAMES.index(name)
        wait = 0.25 if name == CLAP else REFRACTORY_S
        if self._moment - self._told[index] < wait * RATE:
            return []
        self._told[index] = self._moment
        return [name]

    def _jumps(self, m: list[float]) -> bool:
        """Whether a flight has lasted long enough now: the feet have left the floor, and the hips have risen with them.

        The floor and the height of the standing hips are slow medians, so that jitter does not lower them.
        """
        lowest, hips = m[body.LOWEST], m[body.LOWEST] + body.HIPS_HEIGHT * m[body.HIPS_UP]
        if self._floor == math.inf:
            self._floor, self._hips = lowest, hips
        self._lift += LIFT_SHARE * (lowest - self._floor - self._lift)
        self._rise += LIFT_SHARE * (hips - self._hips - self._rise)
        up = min(self._lift, self._rise)
        if up < FLIGHT_HEIGHT or m[body.TRUNK_UP] < UPRIGHT:
            self._flight = 0
            self._floor += math.copysign(FLOOR_STEP, lowest - self._floor)
            self._hips += 2.0 * FLOOR_STEP if hips > self._hips else -0.5 * FLOOR_STEP
            return False
        self._flight += 1
        if self._flight > LONGEST_FLIGHT_S * RATE:
            self._floor, self._hips, self._flight = lowest, hips, 0
        return self._flight == FLIGHT_MOMENTS

    def _turns(self, turned: float) -> bool:
        """Whether a turn is complete now."""
        if turned * self._turned < 0.0 or abs(turned) * RATE < TURNING:
            self._pause += 1.0 / RATE
        else:
            self._pause = 0.0
        self._turned += turned
        if self._pause > TURN_PAUSE_S:
            self._turned = self._pause = 0.0
        if abs(self._turned) < FULL_TURN:
            return False
        self._turned -= math.copysign(2.0 * math.pi, self._turned)
        return True

    def _claps(self, apart: float) -> bool:
        """Whether the hands meet now."""
        speed = (self._apart - apart) * body.ARM_LENGTH * RATE
        self._closing = max(0.93 * self._closing, speed)
        self._apart = apart
        self._open = self._open or apart > CLAP_OPEN
        if not (self._open and apart < CLAP_APART and speed < 0.5 * self._closing and self._closing > CLAP_SPEED):
            return False
        self._open = False
        return True
