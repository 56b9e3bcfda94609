"""Anchor: how far the place that a suit says of its wearer lies from the one that a tracker says, slowly followed.

A suit knows the body well and the place badly: it adds up steps, and drifts by metres in an hour. A tracker knows the
place, but trembles. What changes slowly between the two is the suit's error: that alone is corrected, so that feet
slide no more than the drift makes them.
"""

import math
from typing import Final

from live.clock.ticks import TICK

LAG: Final = 1.0
"""So much later [s] the correction follows what a suit drifts: two low-passes of half of it each, one after the other.
One alone would pass the tracker's noise on into the speed of her feet; two make 9 mm/s of noise of 5 cm at 60 Hz, not
50, with the same lag behind a steady drift (its speed times this)."""
WALK: Final = 1.2
"""The correction is no faster than somebody who walks [m/s]: a tracker that comes back, or is mistaken for a moment,
makes nobody jump ..."""
FAR: Final = 3.0
"""... but from farther off than this [m], which would take her more than 2.5 s in a place where she is not: there the
bound grows with the square of the distance, and what remains is how fast the low-passes are, 0.74 of it in a second."""
_SHARE: Final = 1.0 - math.exp(-2.0 * TICK / LAG)

Place = tuple[float, float]


class Anchor:
    """The correction of one performer, in her own floor's metres. Thread: the show's."""

    def __init__(self) -> None:
        self.offset: Place = (0.0, 0.0)
        """What is added to the suit's place now [m]."""
        self.apart: Place = (0.0, 0.0)
        """How far the tracker was from the suit when both were heard of last [m]."""
        self._mean: Place = (0.0, 0.0)

    def compare(self, tracker: Place, suit: Place) -> None:
        """The tracker is there while the suit says that she is here [m]."""
        self.apart = tracker[0] - suit[0], tracker[1] - suit[1]

    def follow(self) -> None:
        """A tick: the correction goes after what is apart."""
        self._mean = _towards(self._mean, self.apart)
        x, z = self.offset
        to_x, to_z = _towards(self.offset, self._mean)
        left = math.hypot(self.apart[0] - x, self.apart[1] - z)
        most = WALK * TICK * max(1.0, (left / FAR) ** 2)
        slower = min(1.0, most / max(math.hypot(to_x - x, to_z - z), 1e-12))
        self.offset = x + slower * (to_x - x), z + slower * (to_z - z)

    def leap(self) -> Place:
        """Be wholly where the tracker is: for somebody of whom nothing is seen. Returns the way there [m]."""
        (x, z), self.offset, self._mean = self.offset, self.apart, self.apart
        return self.offset[0] - x, self.offset[1] - z

    def let_go(self) -> None:
        """No tracker counts any more: the correction goes away again."""
        self.apart = 0.0, 0.0

    @property
    def numbers(self) -> tuple[float, ...]:
        """Its whole state."""
        return *self.offset, *self.apart, *self._mean


def _towards(here: Place, there: Place) -> Place:
    return here[0] + _SHARE * (there[0] - here[0]), here[1] + _SHARE * (there[1] - here[1])
