"""Somebody whom a camera has seen: where they are expected, what they wear, who hides them."""

import math
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.control.camera.costume import PARTS, blend_colours
from live.control.camera.pose_models import ModelPose, Region

NEAR: Final = 0.5
"""People whose regions' middles are closer than this share of a region may be mistaken for each other."""
LOST_S: Final = 0.5
"""A person who is not seen for this long [s] is no longer looked for where they were going."""
HIDDEN_S: Final = 5.0
"""For this long [s] a person who was lost behind another one is looked for beside that one."""
_BESIDE: Final = 0.3
"""So far from the middle of whoever hides them a hidden person is looked for, over the region's size."""
_VELOCITY_SHARE: Final = 0.3
_COLOUR_SHARE: Final = 0.05
"""Share of a new picture in the remembered costume."""
MOVED: Final = 0.03
"""A figure whose landmarks moved by this share of its size in the picture is a person and no poster."""


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
    low: float = 0.0
    """How low in the picture the feet are, over some time [pixels]: who stands nearer is lower."""
    behind: "Person | None" = None
    """The nearest other person when they were last seen, if that one was near enough to hide them."""
    fresh: list[Float64] = field(default_factory=list)
    """Colours seen since they were apart from whom they had crossed, each (PARTS, 3)."""
    crossed: set[int] = field(default_factory=set)
    """Numbers of those whom they crossed, while it is open who is who."""
    guess: Region | None = None
    """Where the model guesses them to be behind somebody, since they were last seen."""

    def region_at(self, time: float) -> Region:
        """Return the region in which they are expected at `time` [s]; beside whoever hides them, if somebody does."""
        last = self.pose.next_region
        x, y = self.velocity * min(time - self.time, LOST_S)
        expected = self.guess or replace(last, x=last.x + x, y=last.y + y)
        if not self.is_hidden(time):
            return expected
        assert self.behind is not None
        front = self.behind.pose.next_region
        reach = _BESIDE * max(front.size, last.size)
        return replace(
            last, angle=0.0, x=min(max(expected.x, front.x - reach), front.x + reach),
            y=min(max(expected.y, front.y - reach), front.y + reach),
        )  # fmt: skip

    def is_hidden(self, time: float) -> bool:
        """Whether they are lost at `time` [s] behind somebody who has been seen since."""
        front = self.behind
        return front is not None and self.time < front.time and 1e-6 < time - self.time <= HIDDEN_S

    def is_followed(self, time: float) -> bool:
        """Whether they are looked for at `time` [s] where they are expected."""
        return time - self.time <= LOST_S or self.is_hidden(time)


def see(person: Person, pose: ModelPose, colours: Float64, time: float, *, crossing: bool) -> None:
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
    if not (crossing or person.crossed) or np.isnan(person.colours).all():
        person.colours = blend_colours(person.colours, colours, _COLOUR_SHARE)
    person.first_pose = person.first_pose or pose
    person.has_moved = person.has_moved or way_moved(pose, person.first_pose) > MOVED
    person.low += _VELOCITY_SHARE * (lowest(pose) - person.low)
    person.pose, person.time, person.is_crossing, person.guess = pose, time, crossing, None


def way_moved(pose: ModelPose, first: ModelPose) -> float:
    """Return how far the landmarks have moved, over the size of the region; hands and feet count half."""
    seen = np.minimum(pose.visibility, first.visibility) > 0.6
    if not seen.any():
        return 0.0
    way = np.linalg.norm(pose.picture - first.picture, axis=1)[seen] / max(first.next_region.size, 1.0)
    return max(float(np.median(way)), 0.5 * float(np.quantile(way, 0.85)))


def lowest(pose: ModelPose) -> float:
    """Return how low in the picture the lowest landmark is [pixels]."""
    return float(pose.picture[:, 1].max())


def people_distance(one: Person, other: Person) -> float:
    """Return the distance of two people where they were last seen, as `region_distance` does."""
    return region_distance(one.pose.next_region, other.pose.next_region)


def region_distance(one: Region, other: Region) -> float:
    """Return the distance of two regions' middles over the smaller one's size."""
    return math.hypot(one.x - other.x, one.y - other.y) / max(min(one.size, other.size), 1.0)
