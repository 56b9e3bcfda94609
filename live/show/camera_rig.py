"""CameraRig: the camera goes around what it looks at, or with somebody, as numbers of the picture say.

What moves is the same for everybody who draws the show: the way around is in the parameters themselves, tick by tick;
who is followed is damped here, so that a dancer's steps are not the camera's.
"""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base import picture
from live.base.errors import PersonError, named
from live.show.group_motion import GroupMotion
from live.show.parameters import Parameters, turned
from live.show.patch import Patch

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

CALM: Final = 4.0
"""How stiffly the camera follows [1/s]: it is critically damped, and behind a walk of 1 m/s by half a metre."""
NOBODY: Final = ("", "off", "nobody")


def check_whom(patch: Patch, motion: GroupMotion) -> None:
    """PersonError, with the place, for a camera of the patch that follows somebody who is not there."""
    cameras = [(patch.camera, ("camera",)), *((view, ("view", n)) for n, view in enumerate(patch.view))]
    for section, place in cameras:
        if section.follow is not None and not motion.casting.means_places(section.follow):
            with named("follow", (*place, "follow")):
                motion.casting.select(section.follow, motion.state.position.astype(np.float64))


class CameraRig:
    """The moving camera of one show. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(self, parameters: Parameters, motion: GroupMotion, whom: str | None, *, beats: int) -> None:
        """`whom` is followed from the start where the picture says so; `beats` of a measure."""
        self._parameters, self._motion, self._beats = parameters, motion, beats
        self.start = self.whom = whom or "*"
        """Who is followed, in words for `Casting.select`."""
        self._who: Bool | None = None
        self._centre: Float64 = np.zeros(2)
        self._speed: Float64 = np.zeros(2)
        self._running = False

    def take_patch(self, fresh: "CameraRig") -> None:
        """An edited patch may follow somebody else from the start."""
        if fresh.start != self.start:
            self.start = fresh.start
            self.follow(self.start)

    def follow(self, whom: str, *, cut: bool = False) -> None:
        """Follow whom these words mean from now on; PersonError if they mean nobody."""
        casting, position = self._motion.casting, self._motion.state.position
        self._who = casting.select(whom, position.astype(np.float64))
        self.whom = whom
        self._running = self._running and not cut

    def begin_measure(self) -> None:
        """Who is meant may have changed: groups do, and places."""
        self._who = None

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, seconds: float, beats: float) -> None:
        """So much time has passed."""
        row = self._parameters.picture
        rate = float(row[picture.ORBIT])
        if rate and not self._parameters.held:
            self._parameters.turn_camera(math.tau * rate * beats / self._beats)
        if row[picture.FOLLOWING] <= 0.0:
            self._running = False
            return
        goal = self._goal()
        if not self._running:
            self._centre, self._speed, self._running = goal, np.zeros(2), True
            return
        # critically damped, exact for a goal that stands (Lowe 2004, Game Programming Gems 4)
        off, damp = self._centre - goal, math.exp(-CALM * seconds)
        pull = (self._speed + CALM * off) * seconds
        self._centre = goal + (off + pull) * damp
        self._speed = (self._speed - CALM * pull) * damp

    def _goal(self) -> Float64:
        """The middle of whom the camera follows; where it is if nobody of them is on the stage."""
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

    def place(self, row: Float64, seconds: float, beats: float) -> None:
        """Bring the camera of a picture's `row` to where it is so long after the last tick."""
        eye, target = picture.EYE, picture.TARGET
        rate = float(row[picture.ORBIT])
        if rate and beats and not self._parameters.held:
            row[eye] = turned(row[eye], row[target], math.tau * rate * beats / self._beats)
        share = float(row[picture.FOLLOWING])
        if share <= 0.0 or not self._running:
            return
        way = share * (self._centre + self._speed * seconds - row[[target.start, target.start + 2]])
        row[[target.start, target.start + 2]] += way
        row[[eye.start, eye.start + 2]] += float(row[picture.ALONG]) * way

    def hashed(self) -> tuple[Float64, ...]:
        """What belongs to the state of the show; nothing while nobody is followed."""
        return (self._centre, self._speed) if self._running else ()

    def facts(self) -> dict[str, Any]:
        """For the status."""
        return {"follows": self.whom if self._running else None}
