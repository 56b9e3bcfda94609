"""Placing: where what she dances lies on the floor, brought to where she is expected without a jump.

A recording is laid on the floor by a rigid motion M. It follows where the hips are expected, as far as feet allow: the
floor under a foot that stands does not move fast.
"""

from typing import Final

import numpy as np

FREE: Final = 0.08
"""Time constant [s] with which she takes her place while no foot stands."""
STANDS: Final = 0.2
"""The same while one does."""
EASES: Final = 0.05
"""Time constant [s] of the speed with which she does so."""
FASTEST: Final = 1.5
"""She is moved no faster than this [m/s] besides what she dances ..."""
QUICKEST: Final = 4.5
"""... and turned no faster than this [rad/s]; twice as fast off a leader whom she is too near to, ..."""
STILL: Final = 0.4
"""... and by this share of it while a foot stands."""


class Placing:
    """M and how fast it changes: plain values."""

    def __init__(self) -> None:
        self.turn, self.shift = complex(1.0), complex(0.0)
        """M: a point z + i x of the recording lies at turn * point + shift."""
        self._last_turn, self._last_shift = self.turn, self.shift
        self._speed, self._turning = complex(0.0), 0.0

    def lay(self, root: complex, facing: complex, place: complex, front: complex) -> None:
        """The M that brings the recording's hips at `root` to `place`, and where they face, `facing`, to `front`; it
        goes on moving as it did."""
        self.turn = front / facing
        self.turn /= abs(self.turn)
        self.shift = place - self.turn * root
        self.rest()

    def rest(self) -> None:
        """M stays as it is until it follows again."""
        self._last_turn, self._last_shift = self.turn, self.shift

    def follow(
        self, root: complex, facing: complex, wanted: tuple[complex, complex], dt: float, *, stands: bool, near: bool
    ) -> None:
        """M `dt` [s] later, on its way to where hips at `root` that face `facing` lie at the `wanted` place and face
        as wanted. She turns about her hips, so that she is never swung round. While a foot `stands` that is slow;
        where she is too `near` to the leader, never."""
        slow = stands and not near
        seconds, eased = STANDS if slow else FREE, 1.0 - float(np.exp(-dt / EASES))
        share = STILL if slow else 2.0 if near else 1.0
        here = self.turn * root + self.shift
        away = float(np.angle(wanted[1] / (self.turn * facing)))
        speed, turning = (wanted[0] - here) / seconds, away / seconds
        speed *= min(1.0, share * FASTEST / max(abs(speed), 1e-9))
        turning = min(max(turning, -share * QUICKEST), share * QUICKEST)
        self._speed += eased * (speed - self._speed)
        self._turning += eased * (turning - self._turning)
        self.drift(root, dt)

    def drift(self, root: complex, dt: float) -> None:
        """M `dt` [s] later as it moves now, hips at `root`."""
        self.rest()
        here = self.turn * root + self.shift
        turned = self.turn * np.exp(1j * self._turning * dt)
        self.turn = complex(turned / abs(turned))
        self.shift = complex(here + self._speed * dt - self.turn * root)

    def at(self, part: float) -> tuple[complex, complex]:
        """M at `part` of the way from the last frame to this one: as a turn and a shift."""
        turn = self._last_turn * np.exp(1j * part * float(np.angle(self.turn / self._last_turn)))
        return complex(turn), self._last_shift + part * (self.shift - self._last_shift)
