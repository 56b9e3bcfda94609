"""CameraRig: the camera goes around what it looks at, or with somebody, as numbers of the picture say.

What moves is the same for everybody who draws the show: the way around is in the parameters themselves, tick by tick;
who is followed is damped here, so that a dancer's steps are not the camera's.
"""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base import picture
from live.base.errors import named
from live.show.desk.chase import Chase
from live.show.desk.parameters import Parameters, turned
from live.show.group.group_motion import GroupMotion
from live.show.patch.patch import Patch

Float64 = npt.NDArray[np.float64]

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
        self._parameters, self._beats = parameters, beats
        self.start = whom or "*"
        """Who is followed from the start."""
        self.chase = Chase(motion, self.start)

    def take_patch(self, fresh: "CameraRig") -> None:
        """An edited patch may follow somebody else from the start."""
        if fresh.start != self.start:
            self.start = fresh.start
            self.chase.turn_to(self.start)

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, seconds: float, beats: float) -> None:
        """So much time has passed."""
        row = self._parameters.picture
        rate = float(row[picture.ORBIT])
        if rate and not self._parameters.held:
            self._parameters.turn_camera(math.tau * rate * beats / self._beats)
        if row[picture.FOLLOWING] > 0.0:
            self.chase.tick(seconds)
        else:
            self.chase.stop()

    def place(self, row: Float64, seconds: float, beats: float) -> None:
        """Bring the camera of a picture's `row` to where it is so long after the last tick."""
        eye, target = picture.EYE, picture.TARGET
        rate = float(row[picture.ORBIT])
        if rate and beats and not self._parameters.held:
            row[eye] = turned(row[eye], row[target], math.tau * rate * beats / self._beats)
        share = float(row[picture.FOLLOWING])
        if share <= 0.0 or not self.chase.running:
            return
        way = share * (self.chase.at(seconds) - row[[target.start, target.start + 2]])
        row[[target.start, target.start + 2]] += way
        row[[eye.start, eye.start + 2]] += float(row[picture.ALONG]) * way

    def facts(self) -> dict[str, Any]:
        """For the status."""
        return {"follows": self.chase.whom if self.chase.running else None}
