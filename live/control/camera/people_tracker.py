"""People in a camera's pictures: found, followed from picture to picture, and told apart when they cross.

A person is followed by the region in which the landmarks of the last picture lay (Bazarevsky et al. 2020); the detector
looks for further people only now and then, in one square of the picture after another, because it misses people who
are small in its input. Who is who after a crossing is decided for all together, by where each was going, by size and
by the costume (an assignment problem).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final, Protocol

import numpy as np
from scipy.optimize import linear_sum_assignment

from live.base.arrays import Float64, UInt8
from live.control.camera.costume import PARTS, blend_colours, colour_difference, costume_colours
from live.control.camera.pose_models import Detection, ModelPose, Region

LEAST_PRESENCE: Final = 0.5
"""Least presence that the landmark model must report."""
LOST_S: Final = 0.5
"""A person who is not seen for this long [s] is no longer looked for where they were going."""
REMEMBERED_S: Final = 20.0
"""For this long [s] a lost person is recognised again by the costume."""
SEARCH_INTERVAL_S: Final = 0.1
"""Time [s] between searches while people may be missing."""
CHECK_INTERVAL_S: Final = 0.4
"""Time [s] between searches while everybody known is seen."""
STILL_S: Final = 3.0
"""A figure that has not moved for this long [s] since it was found is a poster, or a person who waits."""
STILL_CHECK_S: Final = 0.5
"""Time [s] between looks at such a figure."""
MOVED: Final = 0.03
"""A figure whose landmarks moved by this share of its size in the picture is a person and no poster."""
_SAME_PERSON: Final = 0.12
"""Mean distance of landmarks over the region's size below which two poses show the same person."""
_COLOUR_SCALE: Final = 0.08
"""Difference of costumes that counts as much as a distance of half the person's size."""
_COLOUR_SHARE: Final = 0.05
"""Share of a new picture in the remembered costume."""
_VELOCITY_SHARE: Final = 0.3
_MOST_COST: Final = 1.6
"""Cost beyond which a pose is not a known person's."""
_NEAR: Final = 0.5
"""People whose regions' middles are closer than this share of a region may be mistaken for each other."""


class Finder(Protocol):
    """Finds people in a picture."""

    def detect(self, picture: UInt8, most: int) -> list[Detection]:
        """Return people in a picture (H, W, 3)."""


class Poser(Protocol):
    """Finds the landmarks of a person in a region."""

    def run(self, picture: UInt8, region: Region) -> ModelPose:
        """Return the pose in a region of a picture (H, W, 3)."""


@dataclass(slots=True, eq=False)
class Person:
    """Somebody whom the camera has seen."""

    number: int
    """Never given to anybody else."""
    pose: ModelPose
    """The last pose in which they were seen."""
    time: float
    """When that was [s]."""
    first_time: float
    """When they were first seen [s]."""
    velocity: Float64 = field(default_factory=lambda: np.zeros(2))
    """Of the region [pixels/s]."""
    colours: Float64 = field(default_factory=lambda: np.full((PARTS, 3), np.nan))
    """Of the costume, (PARTS, 3)."""
    has_moved: bool = False
    """Whether they have ever moved: a poster does not."""
    is_crossing: bool = False
    """Whether somebody else is so near that the costume is not learned now."""
    first_pose: ModelPose | None = None
    """That in which they were first seen."""

    def region_at(self, time: float) -> Region:
        """Return the region in which they are expected at `time` [s]."""
        last = self.pose.next_region
        x, y = self.velocity * min(time - self.time, LOST_S)
        return replace(last, x=last.x + x, y=last.y + y)


@dataclass(slots=True, eq=False)
class StillFigure:
    """A figure that has not moved: it is looked at now and then, and takes nobody's place."""

    pose: ModelPose
    time: float
    """When it was last looked at [s]."""


def _anybody(pose: ModelPose) -> bool:
    return True


class PeopleTracker:
    """Follows the people in one camera's pictures. Thread: one."""

    def __init__(
        self, finder: Finder, poser: Poser, most: int, accepts: Callable[[ModelPose], bool] = _anybody
    ) -> None:  # fmt: skip
        """`most`: how many people are followed at a time. `accepts`: whether a pose may be a performer's."""
        self._finder, self._poser, self.most, self._accepts = finder, poser, most, accepts
        self.people: list[Person] = []
        """Everybody who is remembered."""
        self.still: list[StillFigure] = []
        """Figures that do not move."""
        self.has_found = False
        """Whether anybody has ever been found."""
        self._next_number = 1
        self._search_time = -math.inf
        self._square = 0

    def update(self, picture: UInt8, time: float) -> list[Person]:
        """Return the people who are seen in a picture (H, W, 3) taken at `time` [s], in the order of their numbers.

        People who have not moved yet are not among them: a poster never does.
        """
        height, width = picture.shape[:2]
        self.people = [each for each in self.people if time - each.time <= REMEMBERED_S]
        self._set_aside(time)
        followed = [each for each in self.people if time - each.time <= LOST_S]
        poses = [
            pose
            for each in followed
            if _is_inside(region := each.region_at(time), width, height)
            for pose in [self._poser.run(picture, region)]
            if self._is_person(pose)
        ]
        poses = _distinct(poses)
        self._look_at_still(picture, time)
        missing = len(poses) < self.most
        alone = len(poses) == len(followed) and bool(poses)
        wait = CHECK_INTERVAL_S if alone else SEARCH_INTERVAL_S
        if missing and time - self._search_time >= wait:
            self._search_time = time
            poses = _distinct(poses + self._search(picture, poses))
        seen = self._assign(picture, poses, time)
        self.has_found = self.has_found or bool(seen)
        return sorted((each for each in seen if each.has_moved), key=lambda each: each.number)

    def _set_aside(self, time: float) -> None:
        """Set figures aside that have not moved since they were found."""
        for each in [each for each in self.people if not each.has_moved and time - each.first_time > STILL_S]:
            self.people.remove(each)
            self.still.append(StillFigure(each.pose, time))

    def _look_at_still(self, picture: UInt8, time: float) -> None:
        """Look at one of the figures set aside; forget it if it has gone or moved, so that it is found as a person."""
        due = next((each for each in self.still if time - each.time > STILL_CHECK_S), None)
        if due is None:
            return
        pose = self._poser.run(picture, due.pose.next_region)
        due.time = time
        if not self._is_person(pose):
            self.still.remove(due)
        elif _way(pose, due.pose) > MOVED:
            self.still.remove(due)
            moved = Person(self._next_number, pose, time, time, has_moved=True)
            self._next_number += 1
            self.people.append(moved)

    def _is_person(self, pose: ModelPose) -> bool:
        return _is_sure(pose) and self._accepts(pose)

    def _search(self, picture: UInt8, known: list[ModelPose]) -> list[ModelPose]:
        """Return poses of people in the next square of the picture who are not among `known`."""
        squares = search_squares(picture.shape[1], picture.shape[0])
        left, top, edge = squares[self._square % len(squares)]
        self._square += 1
        part = np.ascontiguousarray(picture[top : top + edge, left : left + edge])
        found: list[ModelPose] = []
        for each in self._finder.detect(part, self.most + 1):
            region = replace(each.region, x=each.region.x + left, y=each.region.y + top)
            there = [*known, *(figure.pose for figure in self.still)]
            near = any(_region_distance(region, pose.next_region) < _NEAR / 2 for pose in there)
            if near or len(known) + len(found) >= self.most:
                continue
            pose = self._poser.run(picture, region)
            if self._is_person(pose):
                found.append(pose)
        return found

    def _assign(self, picture: UInt8, poses: list[ModelPose], time: float) -> list[Person]:
        """Give each pose to a remembered person, or to a new one."""
        colours = [costume_colours(picture, pose.picture, pose.visibility) for pose in poses]
        cost = np.array([[self._cost(each, *seen, time) for seen in zip(poses, colours, strict=True)]
                         for each in self.people]).reshape(len(self.people), len(poses))  # fmt: skip
        rows, columns = linear_sum_assignment(np.minimum(cost, 10.0 * _MOST_COST))
        owner = {
            int(column): self.people[row] for row, column in zip(rows, columns, strict=True)
            if cost[row, column] <= _MOST_COST
        }  # fmt: skip
        near = [
            any(_region_distance(one.next_region, other.next_region) < _NEAR for other in poses if other is not one)
            for one in poses
        ]
        seen: list[Person] = []
        for index, pose in enumerate(poses):
            person = owner.get(index)
            if person is None:
                person = Person(self._next_number, pose, time, time)
                self._next_number += 1
                self.people.append(person)
            _see(person, pose, colours[index], time, crossing=near[index])
            seen.append(person)
        return seen

    def _cost(self, person: Person, pose: ModelPose, colours: Float64, time: float) -> float:
        """Return how badly a pose fits a remembered person, from 0."""
        apart = colour_difference(person.colours, colours)
        costume = 0.5 * apart / _COLOUR_SCALE if math.isfinite(apart) else 0.5
        gone = time - person.time
        if gone > LOST_S:  # whoever has been away may return anywhere: the costume alone decides
            return 0.4 + 1.5 * costume
        expected = person.region_at(time)
        there = pose.next_region
        way = math.hypot(there.x - expected.x, there.y - expected.y) / max(expected.size, 1.0)
        size = abs(math.log(max(there.size, 1.0) / max(expected.size, 1.0)))
        return 2.0 * way + size + min(costume, 1.2)


def search_squares(width: int, height: int) -> list[tuple[int, int, int]]:
    """Return the squares of a picture in which people are looked for in turn: left, top, edge [pixels].

    The first ones as high as the picture, then smaller ones of two thirds; an upright picture has them below each
    other. A whole picture that is wider than high would show people too small for the detector.
    """
    squares = []
    for edge in (min(width, height), round(min(width, height) * 2 / 3)):
        steps_x = max(math.ceil((width - edge) / (0.5 * edge)), 0) + 1
        steps_y = max(math.ceil((height - edge) / (0.5 * edge)), 0) + 1
        for row in range(steps_y):
            for column in range(steps_x):
                left = round((width - edge) * column / max(steps_x - 1, 1))
                top = round((height - edge) * row / max(steps_y - 1, 1))
                squares.append((left, top, edge))
    return squares


def _see(person: Person, pose: ModelPose, colours: Float64, time: float, *, crossing: bool) -> None:
    """Note that a person was seen."""
    passed = time - person.time
    old, new = person.pose.next_region, pose.next_region
    if 1e-3 < passed <= LOST_S:
        moved = np.array([new.x - old.x, new.y - old.y]) / passed
        # near another person the regions pull at each other: the course of before counts longer
        share = _VELOCITY_SHARE / 3.0 if crossing else _VELOCITY_SHARE
        person.velocity = person.velocity + share * (moved - person.velocity)
    elif passed > LOST_S:
        person.velocity = np.zeros(2)
    if not crossing:
        person.colours = blend_colours(person.colours, colours, _COLOUR_SHARE)
    person.first_pose = person.first_pose or pose
    person.has_moved = person.has_moved or _way(pose, person.first_pose) > MOVED
    person.pose, person.time, person.is_crossing = pose, time, crossing


def _way(pose: ModelPose, first: ModelPose) -> float:
    """Return how far the landmarks have moved, over the size of the region; hands and feet count half."""
    seen = np.minimum(pose.visibility, first.visibility) > 0.6
    if not seen.any():
        return 0.0
    way = np.linalg.norm(pose.picture - first.picture, axis=1)[seen] / max(first.next_region.size, 1.0)
    return max(float(np.median(way)), 0.5 * float(np.quantile(way, 0.85)))


def _is_sure(pose: ModelPose) -> bool:
    """Whether the model is sure enough of a pose."""
    return (
        pose.presence >= LEAST_PRESENCE
        and bool(np.isfinite(pose.picture).all() and np.isfinite(pose.body).all())
        and pose.next_region.size >= 16.0
    )


def _is_inside(region: Region, width: int, height: int) -> bool:
    return -0.25 * width <= region.x <= 1.25 * width and -0.25 * height <= region.y <= 1.25 * height


def _region_distance(one: Region, other: Region) -> float:
    """Return the distance of two regions' middles over the smaller one's size."""
    return math.hypot(one.x - other.x, one.y - other.y) / max(min(one.size, other.size), 1.0)


def _distinct(poses: list[ModelPose]) -> list[ModelPose]:
    """Return the poses without those that show a person a second time; the surer one is kept."""
    kept: list[ModelPose] = []
    for pose in sorted(poses, key=lambda each: -each.presence * float(each.visibility.mean())):
        size = max(pose.next_region.size, 1.0)
        if all(np.linalg.norm(pose.picture - other.picture, axis=1).mean() / size > _SAME_PERSON for other in kept):
            kept.append(pose)
    return kept
