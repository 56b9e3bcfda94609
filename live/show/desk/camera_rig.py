"""Moving camera and follow spots: orbit and damped following of dancers.

The orbit is stored in the parameters and advances per tick, so all windows draw the same camera. Followed positions are
damped, so that a dancer's steps do not shake camera or lamp. Brightness, width and colour of spots are parameters.
"""

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base import picture_parameters
from live.base.arrays import Bool, Float64
from live.base.errors import PersonError, error_context
from live.base.parameter import SPOT_COUNT
from live.base.picture_parameters import BY_ADDRESS
from live.base.stage_snapshot import StageView
from live.show.desk.parameters import Parameters, turn_eye
from live.show.patch.patch import Patch

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion


FOLLOW_STIFFNESS: Final = 4.0
"""Stiffness of the following [1/s]: critically damped; the lag behind a walk of 1 m/s is half a metre."""


class DampedFollower:
    """A point on the floor that follows selected dancers with damping. Thread: the show's."""

    def __init__(self, motion: "GroupMotion", selection: str = "*") -> None:
        self._motion = motion
        self.selection = selection
        """The followed dancers, in words for `Casting.select`."""
        self._selected: Bool | None = None
        self._centre: Float64 = np.zeros(2)
        self._speed: Float64 = np.zeros(2)
        self.running = False
        """Whether the point is defined."""

    def follow(self, selection: str, *, cut: bool = False) -> None:
        """Follow these dancers from now on, at once with `cut`; raises PersonError if the words select no dancer."""
        self._selected = self._motion.casting.select(selection, self._motion.state.position.astype(np.float64))
        self.selection = selection
        self.running = self.running and not cut

    def set_selection(self, selection: str) -> None:
        """Follow these dancers from now on; the words were checked before."""
        self.selection, self._selected = selection, None

    def begin_measure(self) -> None:
        """Resolve the followed dancers again: groups and positions may have changed."""
        self._selected = None

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
        off, damp = self._centre - goal, math.exp(-FOLLOW_STIFFNESS * seconds)
        pull = (self._speed + FOLLOW_STIFFNESS * off) * seconds
        self._centre = goal + (off + pull) * damp
        self._speed = (self._speed - FOLLOW_STIFFNESS * pull) * damp

    def _goal(self) -> Float64:
        """Return the mean position of the followed dancers; the present point if none of them is on the stage."""
        position, present = self._motion.state.position, self._motion.present
        if self._selected is None:
            try:
                self._selected = self._motion.casting.select(self.selection, position.astype(np.float64))
            except PersonError:  # no dancer is selected any more, as in `left & front`
                self._selected = np.zeros(len(position), np.bool_)
        there = self._selected & present
        if not there.any():
            return self._centre.copy()
        middle: Float64 = position[there].mean(axis=0, dtype=np.float64)
        return middle

    @property
    def count(self) -> int:
        """Number of dancers A."""
        return len(self._motion.state.position)

    def followed(self) -> Bool:
        """Return the followed dancers, (A,)."""
        return np.zeros(self.count, np.bool_) if self._selected is None else self._selected

    def position_at(self, seconds: float) -> Float64:
        """Return the point (x, z) [m] this long after the last tick."""
        where: Float64 = self._centre + self._speed * seconds
        return where

    def hashed(self) -> tuple[Float64, ...]:
        """Return the arrays that belong to the state hash; none while it is not running."""
        return (self._centre, self._speed) if self.running else ()


NO_FOLLOW_WORDS: Final = ("", "off", "nobody")


def check_follow(patch: Patch, motion: "GroupMotion") -> None:
    """Raise PersonError, with the patch key, for a camera that follows unknown dancers."""
    cameras = [(patch.camera, ("camera",)), *((view, ("view", n)) for n, view in enumerate(patch.view))]
    for section, place in cameras:
        if section.follow is not None and not motion.casting.depends_on_places(section.follow):
            with error_context("follow", (*place, "follow")):
                motion.casting.select(section.follow, motion.state.position.astype(np.float64))


class CameraRig:
    """The moving camera of one show. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(self, parameters: Parameters, motion: "GroupMotion", selection: str | None, *, beats: int) -> None:
        """`selection` is followed from the start where the picture says so; `beats` per measure."""
        self._parameters, self._beats = parameters, beats
        self.start_selection = selection or "*"
        """Dancers followed from the start."""
        self.follower = DampedFollower(motion, self.start_selection)

    def apply_patch(self, fresh: "CameraRig") -> None:
        """Adopt the followed dancers of an edited patch if they changed."""
        if fresh.start_selection != self.start_selection:
            self.start_selection = fresh.start_selection
            self.follower.set_selection(self.start_selection)

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, seconds: float, beats: float) -> None:
        """Advance by `seconds` and `beats`."""
        row = self._parameters.picture
        if row[picture_parameters.FOLLOWING] > 0.0:
            self.follower.tick(seconds)
        else:
            self.follower.stop()

    def place(self, row: Float64, seconds: float, beats: float) -> None:
        """Move the camera of a picture's `row` to its position this long after the last tick."""
        eye, target = picture_parameters.EYE, picture_parameters.TARGET
        rate = float(row[picture_parameters.ORBIT])
        if rate and beats and not self._parameters.held:
            row[eye] = turn_eye(row[eye], row[target], math.tau * rate * beats / self._beats)
        share = float(row[picture_parameters.FOLLOWING])
        if share <= 0.0 or not self.follower.running:
            return
        way = share * (self.follower.position_at(seconds) - row[[target.start, target.start + 2]])
        row[[target.start, target.start + 2]] += way
        row[[eye.start, eye.start + 2]] += float(row[picture_parameters.ALONG]) * way

    def facts(self) -> dict[str, Any]:
        """Return the followed dancers for the status."""
        return {"follows": self.follower.selection if self.follower.running else None}


class Spots:
    """All follow spots. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(self, parameters: Parameters, motion: "GroupMotion") -> None:
        self._parameters = parameters
        self._followers = tuple(DampedFollower(motion) for _ in range(SPOT_COUNT))
        self._levels = [BY_ADDRESS[f"/dance/spot/{number}"].first for number in range(1, SPOT_COUNT + 1)]

    def follow(self, number: float, selection: str, level: float, *, beats: float) -> None:
        """Let spot `number`, from 1, follow these dancers and fade to `level` in `beats`.

        Raises PersonError if the words select no dancer.
        """
        if number != int(number):
            raise PersonError(f"spot {number:g}: 1 to {SPOT_COUNT} expected")
        place = int(number) - 1
        self._followers[place].follow(selection, cut=beats <= 0.0)
        self._parameters.fade({self._levels[place]: level}, beats=beats)

    def begin_measure(self) -> None:
        """Resolve the followed dancers again."""
        for chase in self._followers:
            chase.begin_measure()

    def tick(self, seconds: float) -> None:
        """Advance by `seconds`."""
        row = self._parameters.picture
        for chase, level in zip(self._followers, self._levels, strict=True):
            if row[level] > 0.0:
                chase.tick(seconds)
            else:
                chase.stop()

    def place(self, view: StageView, seconds: float) -> None:
        """Write the positions of the spots, this long after the last tick, into a view."""
        for number, chase in enumerate(self._followers):
            if chase.running:
                view.spot[number] = chase.position_at(seconds)

    def followed(self) -> Bool:
        """Return whom a lit spot follows, (A,)."""
        found = np.zeros(self._followers[0].count, np.bool_)
        for chase in self._followers:
            if chase.running:
                found |= chase.followed()
        return found

    def hashed(self) -> tuple[Float64, ...]:
        """Return the arrays that belong to the state hash; none while all spots are dark."""
        return tuple(part for chase in self._followers for part in chase.hashed())

    def facts(self) -> dict[str, Any]:
        """Return the dancers followed by each lit spot, for the status."""
        return {"spots": {str(n): chase.selection for n, chase in enumerate(self._followers, start=1) if chase.running}}
