"""Moving camera and follow spots: orbit and damped following of dancers.

The orbit is stored in the parameters and advances per tick, so all windows draw the same camera. Followed positions are
damped, so that a dancer's steps do not shake camera or lamp. Brightness, width and colour of spots are parameters.
"""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base import picture_parameters
from live.base.errors import PersonError, named
from live.base.picture_parameters import BY_ADDRESS, SPOTS
from live.base.stage_snapshot import StageView
from live.show.desk.parameters import Parameters, turned
from live.show.group.group_motion import GroupMotion
from live.show.patch.patch import Patch

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

CALM: Final = 4.0
"""Stiffness of the following [1/s]: critically damped; the lag behind a walk of 1 m/s is half a metre."""


class Chase:
    """A point on the floor that follows selected dancers with damping. Thread: the show's."""

    def __init__(self, motion: GroupMotion, whom: str = "*") -> None:
        self._motion = motion
        self.whom = whom
        """The followed dancers, in words for `Casting.select`."""
        self._who: Bool | None = None
        self._centre: Float64 = np.zeros(2)
        self._speed: Float64 = np.zeros(2)
        self.running = False
        """Whether the point is defined."""

    def follow(self, whom: str, *, cut: bool = False) -> None:
        """Follow these dancers from now on, at once with `cut`; raises PersonError if the words select no dancer."""
        self._who = self._motion.casting.select(whom, self._motion.state.position.astype(np.float64))
        self.whom = whom
        self.running = self.running and not cut

    def turn_to(self, whom: str) -> None:
        """Follow these dancers from now on; the words were checked before."""
        self.whom, self._who = whom, None

    def begin_measure(self) -> None:
        """Resolve the followed dancers again: groups and positions may have changed."""
        self._who = None

    def stop(self) -> None:
        """Stop following; the next `tick` starts at the goal without damping."""
        self.running = False

    def tick(self, seconds: float) -> None:
        """Advance by `seconds`."""
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
        """Return the mean position of the followed dancers; the present point if none of them is on the stage."""
        position, present = self._motion.state.position, self._motion.present
        if self._who is None:
            try:
                self._who = self._motion.casting.select(self.whom, position.astype(np.float64))
            except PersonError:  # no dancer is selected any more, as in `left & front`
                self._who = np.zeros(len(position), np.bool_)
        there = self._who & present
        if not there.any():
            return self._centre.copy()
        middle: Float64 = position[there].mean(axis=0, dtype=np.float64)
        return middle

    def at(self, seconds: float) -> Float64:
        """Return the point (x, z) [m] this long after the last tick."""
        where: Float64 = self._centre + self._speed * seconds
        return where

    def hashed(self) -> tuple[Float64, ...]:
        """Return the arrays that belong to the state hash; none while it is not running."""
        return (self._centre, self._speed) if self.running else ()


NOBODY: Final = ("", "off", "nobody")


def check_whom(patch: Patch, motion: GroupMotion) -> None:
    """Raise PersonError, with the patch key, for a camera that follows unknown dancers."""
    cameras = [(patch.camera, ("camera",)), *((view, ("view", n)) for n, view in enumerate(patch.view))]
    for section, place in cameras:
        if section.follow is not None and not motion.casting.means_places(section.follow):
            with named("follow", (*place, "follow")):
                motion.casting.select(section.follow, motion.state.position.astype(np.float64))


class CameraRig:
    """The moving camera of one show. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(self, parameters: Parameters, motion: GroupMotion, whom: str | None, *, beats: int) -> None:
        """`whom` is followed from the start where the picture says so; `beats` per measure."""
        self._parameters, self._beats = parameters, beats
        self.start = whom or "*"
        """Dancers followed from the start."""
        self.chase = Chase(motion, self.start)

    def take_patch(self, fresh: "CameraRig") -> None:
        """Adopt the followed dancers of an edited patch if they changed."""
        if fresh.start != self.start:
            self.start = fresh.start
            self.chase.turn_to(self.start)

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, seconds: float, beats: float) -> None:
        """Advance by `seconds` and `beats`."""
        row = self._parameters.picture
        rate = float(row[picture_parameters.ORBIT])
        if rate and not self._parameters.held:
            self._parameters.turn_camera(math.tau * rate * beats / self._beats)
        if row[picture_parameters.FOLLOWING] > 0.0:
            self.chase.tick(seconds)
        else:
            self.chase.stop()

    def place(self, row: Float64, seconds: float, beats: float) -> None:
        """Move the camera of a picture's `row` to its position this long after the last tick."""
        eye, target = picture_parameters.EYE, picture_parameters.TARGET
        rate = float(row[picture_parameters.ORBIT])
        if rate and beats and not self._parameters.held:
            row[eye] = turned(row[eye], row[target], math.tau * rate * beats / self._beats)
        share = float(row[picture_parameters.FOLLOWING])
        if share <= 0.0 or not self.chase.running:
            return
        way = share * (self.chase.at(seconds) - row[[target.start, target.start + 2]])
        row[[target.start, target.start + 2]] += way
        row[[eye.start, eye.start + 2]] += float(row[picture_parameters.ALONG]) * way

    def facts(self) -> dict[str, Any]:
        """Return the followed dancers for the status."""
        return {"follows": self.chase.whom if self.chase.running else None}


class Spots:
    """All follow spots. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(self, parameters: Parameters, motion: GroupMotion) -> None:
        self._parameters = parameters
        self._chases = tuple(Chase(motion) for _ in range(SPOTS))
        self._levels = [BY_ADDRESS[f"/dance/spot/{number}"].first for number in range(1, SPOTS + 1)]

    def follow(self, number: float, whom: str, level: float, *, beats: float) -> None:
        """Let spot `number`, from 1, follow these dancers and fade to `level` in `beats`.

        Raises PersonError if the words select no dancer.
        """
        if number != int(number):
            raise PersonError(f"spot {number:g}: 1 to {SPOTS} expected")
        place = int(number) - 1
        self._chases[place].follow(whom, cut=beats <= 0.0)
        self._parameters.fade({self._levels[place]: level}, beats=beats)

    def begin_measure(self) -> None:
        """Resolve the followed dancers again."""
        for chase in self._chases:
            chase.begin_measure()

    def tick(self, seconds: float) -> None:
        """Advance by `seconds`."""
        row = self._parameters.picture
        for chase, level in zip(self._chases, self._levels, strict=True):
            if row[level] > 0.0:
                chase.tick(seconds)
            else:
                chase.stop()

    def place(self, view: StageView, seconds: float) -> None:
        """Write the positions of the spots, this long after the last tick, into a view."""
        for number, chase in enumerate(self._chases):
            if chase.running:
                view.spot[number] = chase.at(seconds)

    def hashed(self) -> tuple[Float64, ...]:
        """Return the arrays that belong to the state hash; none while all spots are dark."""
        return tuple(part for chase in self._chases for part in chase.hashed())

    def facts(self) -> dict[str, Any]:
        """Return the dancers followed by each lit spot, for the status."""
        return {"spots": {str(n): chase.whom for n, chase in enumerate(self._chases, start=1) if chase.running}}
