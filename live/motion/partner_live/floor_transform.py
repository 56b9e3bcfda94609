"""Where a recording lies on the floor: a rigid motion that follows the follower's expected place and facing."""

from typing import Final

import numpy as np

FREE_TIME_CONSTANT: Final = 0.3
"""Time constant [s] of moving to the expected position while no foot stands."""
STANDING_TIME_CONSTANT: Final = 0.5
"""The same while a foot stands."""
SPEED_TIME_CONSTANT: Final = 0.05
"""Time constant [s] of the speed of that correction."""
MAX_SPEED: Final = 1.5
"""Maximum speed of the correction [m/s], added to the recorded motion: twice as fast away from a leader who is too near
..."""
STANDING_SCALE: Final = 0.4
"""... and scaled by this while a foot stands."""
TURN_TIME_CONSTANT: Final = 0.06
"""Time constant [s] of turning to the expected facing, about the ball of a foot, too; ..."""
MAX_TURN_RATE: Final = 9.0
"""... and its maximum speed [rad/s], twice as fast if the leader is too near."""


class FloorTransform:
    """The rigid motion M of a recording and its rate of change. Plain values."""

    def __init__(self) -> None:
        self.turn, self.shift = complex(1.0), complex(0.0)
        """M: a point z + i x of the recording lies at turn * point + shift."""
        self._last_turn, self._last_shift = self.turn, self.shift
        self._speed, self._turning = complex(0.0), 0.0

    def align(self, root: complex, facing: complex, place: complex, front: complex) -> None:
        """Set M so that the recording's hips at `root` lie at `place` and their `facing` points to `front`.

        Its rate of change is kept.
        """
        self.turn = front / facing
        self.turn /= abs(self.turn)
        self.shift = place - self.turn * root
        self.freeze()

    def rewind(self) -> None:
        """Set M to what it was at the latest frame, before the motion to the next one."""
        self.turn, self.shift = self._last_turn, self._last_shift

    def freeze(self) -> None:
        """Keep M constant until the next `follow`."""
        self._last_turn, self._last_shift = self.turn, self.shift

    def follow(
        self,
        root: complex,
        facing: complex,
        wanted: tuple[complex, complex],
        dt: float,
        *,
        standing: bool,
        too_near: bool,
    ) -> None:
        """Advance M by `dt` [s] towards hips at `root` with `facing` at the `wanted` position and facing.

        The rotation is about the hips, so that the follower does not swing around. It is slow while a foot is
        `standing`, but never if the follower is `too_near` to the leader.
        """
        slow = standing and not too_near
        seconds, eased = (
            STANDING_TIME_CONSTANT if slow else FREE_TIME_CONSTANT,
            1.0 - float(np.exp(-dt / SPEED_TIME_CONSTANT)),
        )
        share = STANDING_SCALE if slow else 2.0 if too_near else 1.0
        here = self.turn * root + self.shift
        away = float(np.angle(wanted[1] / (self.turn * facing)))
        speed, turning = (wanted[0] - here) / seconds, away / TURN_TIME_CONSTANT
        speed *= min(1.0, share * MAX_SPEED / max(abs(speed), 1e-9))
        limit = MAX_TURN_RATE * (2.0 if too_near else 1.0)
        turning = min(max(turning, -limit), limit)
        self._speed += eased * (speed - self._speed)
        self._turning += eased * (turning - self._turning)
        self.drift(root, dt)

    def drift(self, root: complex, dt: float) -> None:
        """Advance M by `dt` [s] at its current rate, hips at `root`."""
        self.freeze()
        here = self.turn * root + self.shift
        turned = self.turn * np.exp(1j * self._turning * dt)
        self.turn = complex(turned / abs(turned))
        self.shift = complex(here + self._speed * dt - self.turn * root)

    def interpolate(self, part: float) -> tuple[complex, complex]:
        """Return M at `part` of the interval from the last frame to this one, as turn and shift."""
        turn = self._last_turn * np.exp(1j * part * float(np.angle(self.turn / self._last_turn)))
        return complex(turn), self._last_shift + part * (self.shift - self._last_shift)
