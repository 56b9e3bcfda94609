"""People followed, crossing, leaving and returning; posters and crowds."""

import numpy as np
import pytest

import live.control.camera.people_tracker as module
from live.control.camera.people_tracker import REMEMBERED_S, STILL_S, PeopleTracker, search_squares
from live.control.camera.pose_models import ModelPose
from tests.control.camera.painted_people import HEIGHT, WIDTH, Painted, PaintedPeople
from tests.fixtures.mostly_long import mostly_long

RATE = 30.0


@pytest.fixture(autouse=True)
def _whole_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """The painted finder takes every square for the whole picture."""
    monkeypatch.setattr(module, "search_squares", lambda width, height: [(0, 0, max(width, height))])


def run(people: PaintedPeople, tracker: PeopleTracker, frames: range, at: dict[int, list[int]] | None = None) -> None:
    """Show pictures; `at` gets for each frame the colours' red of whom each number stood on."""
    for frame in frames:
        for number, each in enumerate(people.people):
            each.swing = 0.4 * frame + number
        seen = tracker.update(people.paint(), frame / RATE)
        if at is not None:
            at[frame] = [each.number for each in seen]


def owners(people: PaintedPeople, tracker: PeopleTracker) -> dict[int, int]:
    """For each number the index of the nearest painted person."""
    now = max((each.time for each in tracker.people), default=0.0)
    return {
        each.number: int(np.argmin([abs(one.x - each.pose.next_region.x) for one in people.people]))
        for each in tracker.people
        if each.time == now
    }


def test_somebody_who_moves_is_found_and_keeps_her_number() -> None:
    people = PaintedPeople()
    people.people = [Painted(100.0)]
    tracker = PeopleTracker(people, people, 1)
    seen: dict[int, list[int]] = {}
    for frame in range(120):
        people.people[0].x = 100.0 + 3.5 * frame
        run(people, tracker, range(frame, frame + 1), seen)
    assert all(numbers == [1] for frame, numbers in seen.items() if frame > 20)
    assert people.searches < 10, "nobody is missing, so nobody is looked for"


@pytest.mark.parametrize("colours", [((200, 40, 40), (40, 60, 200)), ((30, 30, 30), (200, 200, 60))])
@mostly_long("speed", [2.0, 5.0, 9.0], quick=[1])
@pytest.mark.parametrize("turning_back", [False, True])
def test_two_who_cross_keep_their_numbers(
    colours: tuple[tuple[int, int, int], tuple[int, int, int]], speed: float, turning_back: bool
) -> None:
    people = PaintedPeople()
    people.people = [Painted(140.0, colour=colours[0], distance=3.0), Painted(500.0, colour=colours[1], distance=5.0)]
    tracker = PeopleTracker(people, people, 2)
    run(people, tracker, range(30))
    before = owners(people, tracker)
    assert sorted(before) == [1, 2]
    meet = int(180 / speed)
    for frame in range(30, 30 + 2 * meet):
        done = frame - 30
        way = speed * (2 * meet - done if turning_back and done > meet else done)
        people.people[0].x, people.people[1].x = 140.0 + way, 500.0 - way
        run(people, tracker, range(frame, frame + 1))
    run(people, tracker, range(30 + 2 * meet, 60 + 2 * meet))
    assert owners(people, tracker) == before


@pytest.mark.long
def test_equal_costumes_are_told_apart_by_where_they_were_going() -> None:
    people = PaintedPeople()
    people.people = [Painted(140.0, distance=3.0), Painted(500.0, distance=5.0)]
    tracker = PeopleTracker(people, people, 2)
    run(people, tracker, range(30))
    before = owners(people, tracker)
    for frame in range(30, 90):
        people.people[0].x, people.people[1].x = 140.0 + 6.0 * (frame - 30), 500.0 - 6.0 * (frame - 30)
        run(people, tracker, range(frame, frame + 1))
    run(people, tracker, range(90, 110))
    assert owners(people, tracker) == before


def test_a_poster_is_no_performer_and_takes_nobodys_place() -> None:
    people = PaintedPeople()
    poster, dancer = Painted(500.0), Painted(140.0, colour=(40, 60, 200))
    people.people = [poster]
    tracker = PeopleTracker(people, people, 1)
    for frame in range(round((STILL_S + 1) * RATE)):
        assert tracker.update(people.paint(), frame / RATE) == []
    assert len(tracker.still) == 1
    people.people = [poster, dancer]
    begin = round((STILL_S + 1) * RATE)
    for frame in range(begin, begin + 60):
        dancer.x += 3.0
        seen = tracker.update(people.paint(), frame / RATE)
    assert [round(each.pose.next_region.x) for each in seen] == [pytest.approx(dancer.x, abs=20)]


@pytest.mark.long
def test_who_has_stood_still_is_found_when_she_moves() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0)]
    tracker = PeopleTracker(people, people, 1)
    for frame in range(round((STILL_S + 1) * RATE)):
        tracker.update(people.paint(), frame / RATE)
    begin = round((STILL_S + 1) * RATE)
    seen: dict[int, list[int]] = {}
    for frame in range(begin, begin + 90):
        people.people[0].x += 2.0
        run(people, tracker, range(frame, frame + 1), seen)
    first = min(frame for frame, numbers in seen.items() if numbers)
    assert first - begin < module.STILL_CHECK_S * RATE + 5
    assert seen[begin + 89]


def test_who_leaves_and_returns_is_known_by_the_costume() -> None:
    people = PaintedPeople()
    red, blue = Painted(200.0), Painted(450.0, colour=(40, 60, 200), distance=5.0)
    people.people = [red, blue]
    tracker = PeopleTracker(people, people, 2)
    for frame in range(30):
        red.x, blue.x = red.x + 2.0, blue.x - 2.0
        run(people, tracker, range(frame, frame + 1))
    before = owners(people, tracker)
    assert sorted(before) == [1, 2]
    people.people = []
    run(people, tracker, range(30, 120))
    red.x, blue.x = 450.0, 200.0  # they come back at each other's place
    people.people = [red, blue]
    run(people, tracker, range(120, 160))
    assert owners(people, tracker) == before


def test_who_has_been_away_for_long_is_forgotten() -> None:
    people = PaintedPeople()
    people.people = [Painted(200.0)]
    tracker = PeopleTracker(people, people, 1)
    run(people, tracker, range(30))
    people.people = []
    last = round((REMEMBERED_S + 2) * RATE)
    tracker.update(people.paint(), last / RATE)
    assert tracker.people == []


@pytest.mark.long
def test_a_crowd_costs_no_more_than_the_people_who_are_followed() -> None:
    people = PaintedPeople()
    people.people = [Painted(40.0 + 60.0 * number, tall=150.0) for number in range(10)]
    tracker = PeopleTracker(people, people, 2)
    run(people, tracker, range(60))
    people.runs = 0
    run(people, tracker, range(60, 90))
    assert people.runs <= 2 * 30
    assert len([each for each in tracker.people if each.time == 89 / RATE]) == 2


def test_who_is_not_accepted_is_not_seen() -> None:
    people = PaintedPeople()
    people.people = [Painted(200.0), Painted(500.0)]

    def on_the_left(pose: ModelPose) -> bool:
        return pose.next_region.x < 320.0

    tracker = PeopleTracker(people, people, 2, on_the_left)
    run(people, tracker, range(30))
    assert list(owners(people, tracker).values()) == [0]


@pytest.mark.parametrize(("width", "height"), [(WIDTH, HEIGHT), (480, 640), (400, 400), (960, 540), (960, 270)])
def test_the_squares_cover_the_picture_and_lie_in_it(width: int, height: int) -> None:
    seen = np.zeros((height, width), bool)
    for left, top, edge in search_squares(width, height):
        assert left >= 0
        assert top >= 0
        assert left + edge <= width
        assert top + edge <= height
        seen[top : top + edge, left : left + edge] = True
    assert seen.all()
    assert len(search_squares(width, height)) <= 27
