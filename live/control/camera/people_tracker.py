"""People in a camera's pictures: found, followed from picture to picture, and told apart when they cross.

A person is followed by the region in which the landmarks of the last picture lay (Bazarevsky et al. 2020); the detector
looks for further people only now and then, in one square of the picture after another, because it misses people who
are small in its input. Where regions overlap, those in front are looked at first and taken out of the picture for those
behind. Who is who is decided for all together, by where each was going, by size and by the costume (an assignment
problem), and once more by the costumes alone when those who crossed are apart again.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np
from scipy.optimize import linear_sum_assignment

from live.base.arrays import Float64, UInt8
from live.control.camera.costume import colour_difference, costume_colours
from live.control.camera.crossings import note_crossings
from live.control.camera.overlaps import is_covered, silhouettes, without
from live.control.camera.pose_models import Detection, ModelPose, Region
from live.control.camera.seen_person import MOVED, NEAR, Person, lowest, region_distance, see, way_moved

LEAST_PRESENCE: Final = 0.5
"""Least presence that the landmark model must report."""
REMEMBERED_S: Final = 20.0
"""For this long [s] a lost person is recognised again by the costume."""
SEARCH_INTERVAL_S: Final = 0.1
"""Time [s] between searches while people may be missing."""
EAGER_S: Final = 2.0
"""For this long [s] after the start, and after somebody new was found, the others are looked for with more effort:"""
EAGER_INTERVAL_S: Final = 0.03
"""time [s] between searches then."""
CHECK_INTERVAL_S: Final = 0.4
"""Time [s] between searches while everybody known is seen."""
STILL_S: Final = 3.0
"""A figure that has not moved for this long [s] since it was found is a poster, or a person who waits."""
STILL_CHECK_S: Final = 0.5
"""Time [s] between looks at such a figure."""
_SAME_PERSON: Final = 0.12
"""Mean distance of landmarks over the region's size below which two poses show the same person."""
_COLOUR_SCALE: Final = 0.08
"""Difference of costumes that counts as much as a distance of half the person's size."""
_MOST_COST: Final = 1.6
"""Cost beyond which a pose is not a known person's."""
_SWIFT: Final = 1.0
"""Speed [sizes of a region/s] at which a person comes to an unexpected place; more is unlikely."""
_START: Final = 0.1
"""Time [s] by which even a person who has just been seen may be farther on their way."""
_MIXED: Final = 0.3
"""People whose regions' middles are closer than this share of a region are not learned from."""
_GUESS_SIZE: Final = 0.2
"""A hidden person's guessed region has the size of before but for this logarithm."""


class Finder(Protocol):
    """Finds people in a picture."""

    def detect(self, picture: UInt8, most: int) -> list[Detection]:
        """Return people in a picture (H, W, 3)."""


class Poser(Protocol):
    """Finds the landmarks of a person in a region."""

    def run(self, picture: UInt8, region: Region) -> ModelPose:
        """Return the pose in a region of a picture (H, W, 3)."""


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
        self._eager_until: float | None = None
        self._square = 0

    def update(self, picture: UInt8, time: float) -> list[Person]:
        """Return the people who are seen in a picture (H, W, 3) taken at `time` [s], in the order of their numbers.

        People who have not moved yet are not among them: a poster never does.
        """
        self.people = [each for each in self.people if time - each.time <= REMEMBERED_S]
        self._set_aside(time)
        poses = self._follow(picture, time)
        followed = sum(each.is_followed(time) for each in self.people)
        self._look_at_still(picture, time)
        missing = len(poses) < self.most
        self._eager_until = self._eager_until or time + EAGER_S
        wait = CHECK_INTERVAL_S if poses and len(poses) == followed else SEARCH_INTERVAL_S
        wait = EAGER_INTERVAL_S if time < self._eager_until else wait
        if missing and time - self._search_time >= wait:
            self._search_time = time
            poses = _distinct(poses + self._search(picture, poses))
        seen = self._assign(picture, poses, time)
        self.has_found = self.has_found or bool(seen)
        return sorted((each for each in seen if each.has_moved), key=lambda each: each.number)

    def _follow(self, picture: UInt8, time: float) -> list[ModelPose]:
        """Return poses of known people where they are expected: of those in front, then of those behind them."""
        height, width = picture.shape[:2]
        followed = [each for each in self.people if each.is_followed(time)]
        poses: list[ModelPose] = []
        for each in sorted(followed, key=lambda one: (one.is_hidden(time), -one.low)):
            region = each.region_at(time)
            if len(poses) >= self.most or not _is_inside(region, width, height):
                continue
            pose, is_hole = self._look(picture, region, poses)
            if is_hole:
                alike = abs(math.log(max(pose.next_region.size, 1.0) / each.pose.next_region.size)) < _GUESS_SIZE
                each.guess = pose.next_region if alike and self._is_person(pose) else each.guess
            elif self._is_person(pose) and _is_other(pose, poses):
                poses.append(pose)
        return poses

    def _look(self, picture: UInt8, region: Region, known: list[ModelPose]) -> tuple[ModelPose, bool]:
        """Return the pose in a region of somebody else than `known`, and whether it lies where one of those was."""
        front = [pose for pose in known if region_distance(region, pose.next_region) < NEAR]
        if not front:
            return self._poser.run(picture, region), False
        covered = silhouettes((picture.shape[1], picture.shape[0]), front)
        pose = self._poser.run(without(picture, covered), region)
        return pose, is_covered(pose, covered)

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
        elif way_moved(pose, due.pose) > MOVED:
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
            near = any(region_distance(region, pose.next_region) < NEAR / 2 for pose in there)
            if near or len(known) + len(found) >= self.most:
                continue
            pose, is_hole = self._look(picture, region, [*known, *found])
            if self._is_person(pose) and not is_hole:
                found.append(pose)
        return found

    def _assign(self, picture: UInt8, poses: list[ModelPose], time: float) -> list[Person]:
        """Give each pose to a remembered person, or to a new one."""
        colours = [costume_colours(picture, pose.picture, pose.visibility) for pose in poses]
        cost = np.array([[self._cost(each, *seen, time) for seen in zip(poses, colours, strict=True)]
                         for each in self.people]).reshape(len(self.people), len(poses))  # fmt: skip
        jump = np.array([[self._jump(each, pose, time) for pose in poses]
                         for each in self.people]).reshape(cost.shape)  # fmt: skip
        rows, columns = linear_sum_assignment(np.minimum(cost, 10.0 * _MOST_COST) + jump)
        owner = {
            int(column): self.people[row] for row, column in zip(rows, columns, strict=True)
            if cost[row, column] <= _MOST_COST
        }  # fmt: skip
        seen: list[Person] = []
        worn: dict[int, Float64] = {}
        for index, pose in enumerate(poses):
            person = owner.get(index)
            if person is None:
                person = Person(self._next_number, pose, time, time, low=lowest(pose))
                self._next_number += 1
                self.people.append(person)
                self._eager_until = time + EAGER_S
            near = any(
                region_distance(pose.next_region, other.next_region) < _MIXED for other in poses if other is not pose
            )
            see(person, pose, colours[index], time, crossing=near)
            seen.append(person)
            worn[person.number] = colours[index]
        note_crossings(self.people, seen, worn)
        return seen

    def _cost(self, person: Person, pose: ModelPose, colours: Float64, time: float) -> float:
        """Return how badly a pose fits a remembered person, from 0."""
        apart = colour_difference(person.colours, colours)
        costume = 0.5 * apart / _COLOUR_SCALE if math.isfinite(apart) else 0.5
        if not person.is_followed(time):  # whoever has been away may return anywhere: the costume alone decides
            return 0.4 + 1.5 * costume
        expected = person.region_at(time)
        there = pose.next_region
        way = math.hypot(there.x - expected.x, there.y - expected.y) / max(expected.size, 1.0)
        size = abs(math.log(max(there.size, 1.0) / max(expected.size, 1.0)))
        return 2.0 * way + 2.0 * size + min(costume, 1.2)

    def _jump(self, person: Person, pose: ModelPose, time: float) -> float:
        """Return how unlikely it is, from 0, that a person came to a pose in the time since they were seen."""
        if not person.is_followed(time):
            return 0.0
        expected, there = person.region_at(time), pose.next_region
        way = math.hypot(there.x - expected.x, there.y - expected.y) / max(expected.size, 1.0)
        return min(way / (_SWIFT * (_START + time - person.time)), 2.0)


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


def _is_sure(pose: ModelPose) -> bool:
    """Whether the model is sure enough of a pose."""
    return (
        pose.presence >= LEAST_PRESENCE
        and bool(np.isfinite(pose.picture).all() and np.isfinite(pose.body).all())
        and pose.next_region.size >= 16.0
    )


def _is_inside(region: Region, width: int, height: int) -> bool:
    return -0.25 * width <= region.x <= 1.25 * width and -0.25 * height <= region.y <= 1.25 * height


def _distinct(poses: list[ModelPose]) -> list[ModelPose]:
    """Return the poses without those that show a person a second time; the surer one is kept."""
    kept: list[ModelPose] = []
    for pose in sorted(poses, key=lambda each: -each.presence * float(each.visibility.mean())):
        if _is_other(pose, kept):
            kept.append(pose)
    return kept


def _is_other(pose: ModelPose, known: list[ModelPose]) -> bool:
    """Whether a pose shows none of the people of `known`."""
    size = max(pose.next_region.size, 1.0)
    return all(np.linalg.norm(pose.picture - each.picture, axis=1).mean() / size > _SAME_PERSON for each in known)
