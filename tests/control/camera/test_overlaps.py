"""Who is in front is taken out of the picture, so that the one behind is seen."""

import math
from dataclasses import replace

import numpy as np
import pytest

import live.control.camera.people_tracker as tracker_module
from live.control.camera.overlaps import is_covered, silhouettes, without
from live.control.camera.people_tracker import PeopleTracker
from live.control.camera.pose_models import Region
from tests.control.camera.painted_people import HEIGHT, WIDTH, Painted, PaintedPeople, PixelPoser

RATE = 30.0
RED, BLUE = (200, 40, 40), (40, 60, 200)


@pytest.fixture(autouse=True)
def _whole_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """The painted finder takes every square for the whole picture."""
    monkeypatch.setattr(tracker_module, "search_squares", lambda width, height: [(0, 0, max(width, height))])


def test_a_silhouette_covers_the_person_and_not_the_rest() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0)]
    pose = people.run(people.paint(), people.people[0].region)
    covered = silhouettes((WIDTH, HEIGHT), [pose])
    painted = (people.paint() == RED).all(axis=2)
    assert covered[painted].all()
    assert covered[~painted].mean() < 0.03, "but for its edge"


@pytest.mark.parametrize("angle", [0.5 * math.pi, math.pi, -0.5 * math.pi])
def test_a_silhouette_turns_with_its_region(angle: float) -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0, 180.0)]
    upright = people.run(people.paint(), people.people[0].region)
    region = Region(300.0, 180.0, 250.0, angle)
    c, s = math.cos(angle), math.sin(angle)
    turned = (upright.picture - (300.0, 180.0)) @ np.array([[c, s], [-s, c]]) + (300.0, 180.0)
    covered = silhouettes((WIDTH, HEIGHT), [replace(upright, region=region, picture=turned)])
    left, right, top, low = people.people[0].box
    quarters = round(angle / (0.5 * math.pi))
    around = covered[180 - 125 : 180 + 125, 300 - 125 : 300 + 125]
    back = np.rot90(around, quarters)  # clockwise in the picture is undone anticlockwise
    assert back[125 + top - 180 + 4 : 125 + low - 180 - 4, 125 + left - 300 + 4 : 125 + right - 300 - 4].all()
    assert covered.sum() == pytest.approx((right - left + 8) * (low - top + 8), rel=0.1)


def test_a_silhouette_beyond_the_picture_is_cut() -> None:
    people = PaintedPeople()
    people.people = [Painted(5.0)]
    pose = people.run(people.paint(), people.people[0].region)
    assert silhouettes((WIDTH, HEIGHT), [pose])[180, 0]
    away = replace(pose, region=replace(pose.region, x=-900.0))
    assert not silhouettes((WIDTH, HEIGHT), [away]).any()


def test_what_is_taken_out_leaves_the_rest_as_it_was() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0), Painted(340.0, colour=BLUE, distance=5.0)]
    picture = people.paint()
    covered = (picture == RED).all(axis=2)
    left = without(picture, covered)
    assert not (left == RED).all(axis=2).any()
    assert np.array_equal(left[~covered], picture[~covered])


def test_a_pose_in_the_hole_of_another_is_none_of_its_own() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0)]
    pose = people.run(people.paint(), people.people[0].region)
    covered = silhouettes((WIDTH, HEIGHT), [pose])
    assert is_covered(pose, covered)
    beside = replace(pose, picture=pose.picture + np.array((70.0, 0.0)))
    assert not is_covered(beside, covered)


@pytest.mark.parametrize("gap", [40.0, 60.0])
def test_the_one_behind_is_seen_although_the_model_takes_the_one_in_front(gap: float) -> None:
    people = PaintedPeople()
    front, behind = Painted(150.0, distance=3.0), Painted(450.0, tall=160.0, colour=BLUE, distance=5.0)
    people.people = [front, behind]
    tracker = PeopleTracker(people, PixelPoser(people), 2)
    for frame in range(100):
        front.swing = behind.swing = 0.4 * frame
        behind.y = 180.0 + 12.0 * math.sin(0.3 * frame)
        front.x = min(150.0 + 4.0 * frame, 450.0 - gap)
        tracker.update(people.paint(), frame / RATE)
    assert {each.behind.number for each in tracker.people if each.behind} == {1, 2}
    seen = {each.number: each.pose.next_region.x for each in tracker.people if each.time == 99 / RATE}
    assert sorted(seen.values()) == [450.0 - gap, 450.0]


def test_who_stays_hidden_for_seconds_is_back_as_soon_as_she_shows() -> None:
    people = PaintedPeople()
    front, behind = Painted(150.0, distance=3.0), Painted(450.0, tall=160.0, colour=BLUE, distance=5.0)
    people.people = [front, behind]
    tracker = PeopleTracker(people, PixelPoser(people), 2)
    numbers: dict[int, set[int]] = {}
    for frame in range(190):
        front.swing = behind.swing = 0.4 * frame
        behind.y = 180.0 + 12.0 * math.sin(0.3 * frame)
        front.x = min(150.0 + 5.0 * frame, 450.0) + (4.0 * (frame - 150) if frame > 150 else 0.0)
        numbers[frame] = {each.number for each in tracker.update(people.paint(), frame / RATE)}
    assert numbers[45] == {1, 2}
    assert len(numbers[120]) == 1, "she is hidden for three seconds"
    first = min(frame for frame in range(151, 190) if len(numbers[frame]) == 2)
    assert first - 150 < 12, "no search is waited for"
    assert numbers[first] == {1, 2}
