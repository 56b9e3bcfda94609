"""Who is who after a crossing, by the costumes."""

import numpy as np
import pytest

from live.base.arrays import Float64
from live.control.camera.costume import PARTS
from live.control.camera.crossings import note_crossings
from live.control.camera.pose_models import ModelPose, Region
from live.control.camera.seen_person import Person
from live.motion.capture.landmarks import LANDMARK_COUNT

RED = np.tile((0.5, 0.4, 0.1), (PARTS, 1))
BLUE = np.tile((-0.1, -0.6, 0.1), (PARTS, 1))
DARK_BLUE = BLUE - np.array((0.0, 0.0, 0.02))


def at(x: float) -> ModelPose:
    region = Region(x, 200.0, 200.0, 0.0)
    empty = np.full((256, 256), -9.0, np.float32)
    points = np.tile((x, 200.0), (LANDMARK_COUNT, 1))
    return ModelPose(points, np.zeros((LANDMARK_COUNT, 3)), np.ones(LANDMARK_COUNT), 1.0, region, region, empty)


def crossed(first: Float64, second: Float64, seen_first: Float64, seen_second: Float64) -> tuple[float, float]:
    """Where the two are said to be who stand at 100 and 400 after a crossing, by the costumes seen there."""
    one, other = Person(1, at(200.0), 0.0, 0.0), Person(2, at(215.0), 0.0, 0.0)
    one.colours, other.colours = first, second
    people = [one, other]
    note_crossings(people, people, {1: seen_first, 2: seen_second})
    for frame in range(12):
        where = {1: (100.0, seen_first), 2: (400.0, seen_second)}
        if frame == 0:
            one.pose, other.pose = at(100.0), at(400.0)
        worn = {each.number: RED for each in people}
        for each in people:
            worn[each.number] = where[1][1] if each.pose.next_region.x == where[1][0] else where[2][1]
        note_crossings(people, people, worn)
    return one.pose.next_region.x, other.pose.next_region.x


def test_who_took_each_others_place_gets_it_back() -> None:
    assert crossed(RED, BLUE, BLUE, RED) == (400.0, 100.0)


def test_who_kept_their_place_has_it_still() -> None:
    assert crossed(RED, BLUE, RED, BLUE) == (100.0, 400.0)


def test_alike_costumes_decide_nothing() -> None:
    assert crossed(BLUE, DARK_BLUE, DARK_BLUE, BLUE) == (100.0, 400.0)


@pytest.mark.filterwarnings("error")
def test_costumes_of_which_nothing_was_seen_decide_nothing() -> None:
    nothing = np.full((PARTS, 3), np.nan)
    assert crossed(nothing, BLUE, nothing, nothing) == (100.0, 400.0)


def test_nothing_is_decided_while_somebody_is_hidden() -> None:
    front, hidden = Person(1, at(200.0), 1.0, 0.0), Person(2, at(215.0), 0.5, 0.0)
    front.colours, hidden.colours = RED, BLUE
    front.crossed, hidden.crossed, hidden.behind = {2}, {1}, front
    for _ in range(12):
        note_crossings([front, hidden], [front], {1: BLUE})
    assert front.pose.next_region.x == 200.0
    assert not front.fresh
