"""People of all cameras as performers of the show: who has whose name, and one body from several views."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.capture.camera_view import CameraView
from live.motion.capture.landmark_body import LandmarkBody
from live.motion.capture.landmarks import Landmarks
from live.motion.capture.packed_pose import pack_pose
from live.motion.capture.stage_points import REACH, StagePoints, fuse_views

FREE_AFTER_S: Final = 20.0
"""A performer's name is free for somebody else when its owner has not been seen for this long [s]."""
HARDLY_SEEN_S: Final = 1.0
"""A name whose owner was seen for less than this [s] is free again after as long: it may have been nobody."""
SAME_MOMENT_S: Final = 0.07
"""Pictures of several cameras that lie within this time [s] are fused."""
PREDICTION_S: Final = 0.12
"""Longest prediction [s]: beyond it a guess would be worse than a delay."""
_DELAY_SHARE: Final = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A person in one camera's picture."""

    number: int
    """The person's number in that camera."""
    landmarks: Landmarks


@dataclass(frozen=True, slots=True, eq=False)
class PerformerPose:
    """A performer's pose for the show."""

    name: str
    time: float
    """The moment for which it holds [s]."""
    captured: float
    """When the picture was taken [s]."""
    packed: str


@dataclass(slots=True, eq=False)
class _Seat:
    """A performer's name, and who has it."""

    name: str
    body: LandmarkBody = field(default_factory=LandmarkBody)
    first: float = -np.inf
    """When its owner was first seen [s]."""
    last: float = -np.inf
    """When its owner was last seen [s]."""
    owners: dict[int, int] = field(default_factory=dict)
    """For each camera the number of the person there."""
    views: dict[int, StagePoints] = field(default_factory=dict)
    """The last view of each camera."""

    def is_free(self, time: float) -> bool:
        """Whether somebody else may have the name at `time` [s]."""
        known = self.last - self.first >= HARDLY_SEEN_S
        return time - self.last > (FREE_AFTER_S if known else HARDLY_SEEN_S)


class Performers:
    """Gives names to seen people and makes their bodies. Thread: one at a time."""

    def __init__(self, names: Sequence[str], half_size: tuple[float, float] | None = None) -> None:
        """`names`: the show's performers in order; the first who is seen is the first. `half_size`: half the width and
        depth of the floor [m] on which performers move, for calibrated cameras; others there are left out."""
        self._seats = [_Seat(name) for name in names]
        self._half = None if half_size is None else np.array(half_size)
        self._delays: dict[int, float] = {}
        self.outside = 0
        """Sightings off the performers' floor."""
        self.without_name = 0
        """Sightings of people for whom there is no name."""

    def rename(self, names: Sequence[str]) -> None:
        """Use the performers of another patch; who has a name that stays keeps it."""
        known = {seat.name: seat for seat in self._seats}
        self._seats = [known.get(name) or _Seat(name) for name in names]

    def exchange(self, first: str, second: str) -> bool:
        """Exchange the persons of two names; False if there is none of that name."""
        found = {seat.name: seat for seat in self._seats}
        if first not in found or second not in found:
            return False
        found[first].name, found[second].name = second, first
        return True

    @property
    def seen(self) -> dict[str, float]:
        """When each performer was last seen [s]; only those who were."""
        return {seat.name: seat.last for seat in self._seats if np.isfinite(seat.last)}

    def name_of(self, camera: int, number: int, time: float) -> str | None:
        """Return as which performer a camera saw a person at `time` [s]; None if as nobody: they have no name, or were
        off the performers' floor."""
        for seat in self._seats:
            view = seat.views.get(camera)
            if seat.owners.get(camera) == number and view is not None and view.time == time:
                return seat.name
        return None

    def update(
        self, camera: int, view: CameraView | None, sightings: Sequence[Sighting], now: float
    ) -> list[PerformerPose]:
        """Return the poses of the performers whom a camera has just seen. `now` [s]: the present.

        The pose is that of the moment at which it is shown: the camera's usual delay after the picture.
        """
        poses: list[PerformerPose] = []
        for each in sightings:
            found = self._find(camera, view, each)
            if found is None:
                continue
            seat, points = found
            seat.last, seat.owners[camera], seat.views[camera] = points.time, each.number, points
            delay = self._delay(camera, now - points.time)
            near = [other for other in seat.views.values() if abs(points.time - other.time) <= SAME_MOMENT_S]
            both = fuse_views(near) if view is not None and len(near) > 1 else points
            lead = min(delay, PREDICTION_S)
            pose = seat.body.update_points(both, lead)
            if pose is not None:
                hips, rotation = pose
                shown = min(both.time + delay, now)
                poses.append(PerformerPose(seat.name, shown, points.time, pack_pose(hips, rotation)))
        return poses

    def update_named(self, camera: int, name: str, landmarks: Landmarks, now: float) -> list[PerformerPose]:
        """As `update`, for the only person of a camera that says who they are, a phone; none for an unknown name."""
        seat = next((each for each in self._seats if each.name == name), None)
        if seat is None:
            self.without_name += 1
            return []
        self._free(camera, -1)
        seat.owners[camera] = -1
        return self.update(camera, None, [Sighting(-1, landmarks)], now)

    def _delay(self, camera: int, measured: float) -> float:
        """Return the camera's usual delay [s], from the picture to the pose, after one more measured."""
        old = self._delays.get(camera, measured)
        new = old + _DELAY_SHARE * (min(max(measured, 0.0), 1.0) - old)
        self._delays[camera] = new
        return new

    def delay(self, camera: int) -> float | None:
        """Return the camera's usual delay [s]; None before its first pose."""
        return self._delays.get(camera)

    def _find(self, camera: int, view: CameraView | None, sighting: Sighting) -> tuple[_Seat, StagePoints] | None:
        """Return a person's seat and their landmarks on the stage; None if they have no seat."""
        time = sighting.landmarks.time
        seat = next((each for each in self._seats if each.owners.get(camera) == sighting.number), None)
        is_new = seat is None
        tried = seat or _Seat("")
        points = tried.body.points(sighting.landmarks, view, camera)
        if points is None:
            return None
        if not self._is_inside(points):
            self.outside += 1
            return None
        if seat is None and view is not None:
            seat = self._same_place(camera, points)
        if seat is None:
            seat = next((each for each in self._seats if each.is_free(time)), None)
            if seat is None:
                self.without_name += 1
                return None
            seat.first = time
            seat.owners.clear()
            seat.views.clear()
            seat.body = LandmarkBody()
        if is_new:
            self._free(camera, sighting.number)
            points = seat.body.points(sighting.landmarks, view, camera) or points
        return seat, points

    def _free(self, camera: int, number: int) -> None:
        for each in self._seats:
            if each.owners.get(camera) == number:
                del each.owners[camera]

    def _is_inside(self, points: StagePoints) -> bool:
        return self._half is None or not points.on_floor or bool((np.abs(points.place) <= self._half).all())

    def _same_place(self, camera: int, points: StagePoints) -> _Seat | None:
        """Return the seat of whom another camera sees at the same place and this one does not see."""
        best, seat = REACH, None
        for each in self._seats:
            if camera in each.owners and points.time - each.views[camera].time < FREE_AFTER_S / 10:
                continue
            for other, seen in each.views.items():
                if other != camera and seen.on_floor and abs(points.time - seen.time) <= 3.0 * SAME_MOMENT_S:
                    way: Float64 = seen.place - points.place
                    if float(np.hypot(*way)) < best:
                        best, seat = float(np.hypot(*way)), each
        return seat
