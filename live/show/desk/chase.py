"""Chase: a place on the floor that goes after somebody, damped, so that her steps are not the lamp's."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.show.group.group_motion import GroupMotion

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

CALM: Final = 4.0
"""How stiffly it follows [1/s]: critically damped, and behind a walk of 1 m/s by half a metre."""


class Chase:
    """One such place. Thread: the show's."""

    def __init__(self, motion: GroupMotion, whom: str = "*") -> None:
        self._motion = motion
        self.whom = whom
        """Who is followed, in words for `Casting.select`."""
        self._who: Bool | None = None
        self._centre: Float64 = np.zeros(2)
        self._speed: Float64 = np.zeros(2)
        self.running = False
        """Whether it is anywhere."""

    def follow(self, whom: str, *, cut: bool = False) -> None:
        """Follow whom these words mean from now on, at once if it is a `cut`; PersonError if they mean nobody."""
        self._who = self._motion.casting.select(whom, self._motion.state.position.astype(np.float64))
        self.whom = whom
        self.running = self.running and not cut

    def turn_to(self, whom: str) -> None:
        """The same for words that were checked, whoever they mean now."""
        self.whom, self._who = whom, None

    def begin_measure(self) -> None:
        """Who is meant may have changed: groups do, and places."""
        self._who = None

    def stop(self) -> None:
        """Nobody looks: when somebody does again, it is there at once."""
        self.running = False

    def tick(self, seconds: float) -> None:
        """So much time has passed."""
        goal = self._goal()
        if not self.running:
            self._centre, self._speed, self.running = goal, np.zeros(2), True
            return
        # critically damped, exact for a goal that stands (Lowe 2004, Game Programming Gems 4)
        off, damp = self._centre - goal, math.exp(-CALM * seconds)
        pull = (self._speed + CALM * off) * seconds
        self._centre = goal + (off + pull) * damp
        self._speed = (self._speed - CALM * pull) * damp

    def _goal(self) -> Float64:
        """The middle of whom it follows; where it is if nobody of them is on the stage."""
        position, present = self._motion.state.position, self._motion.present
        if self._who is None:
            try:
                self._who = self._motion.casting.select(self.whom, position.astype(np.float64))
            except PersonError:  # nobody stands there any more, as in `left & front`
                self._who = np.zeros(len(position), np.bool_)
        there = self._who & present
        if not there.any():
            return self._centre.copy()
        middle: Float64 = position[there].mean(axis=0, dtype=np.float64)
        return middle

    def at(self, seconds: float) -> Float64:
        """Where it is so long after the last tick: (x, z) [m]."""
        where: Float64 = self._centre + self._speed * seconds
        return where

    def hashed(self) -> tuple[Float64, ...]:
        """What belongs to the state of the show; nothing while it is nowhere."""
        return (self._centre, self._speed) if self.running else ()
