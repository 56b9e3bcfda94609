"""Where dancers look: the smoothing of T127 with its golden, what each of the words means, and bad words."""

import math

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.show.patch.patch_reader import parse_patch
from live.show.patch.section_motion import parse_facing
from tests.show.made_show import PATCH, made_show

STAMP = {"time": 0.0, "source": "test"}
NOBODY = np.zeros(9, np.bool_)


def measures(show, count, *, start=None, wish=None, planned=None, known=NOBODY):
    """Headings [deg] of all dancers over so many measures."""
    headings = show.scheduler.targets.headings
    place = np.zeros((9, 2)) if start is None else start
    wish = place if wish is None else wish
    planned = np.zeros(9) if planned is None else planned
    return np.degrees([headings.advance(place, wish, planned, known) for _ in range(count)])


def face(show, words, group="*"):
    assert show.apply(events.SetFacing(facing=words, group=group, **STAMP)), show.refusals.words


def test_a_turn_of_80_degrees_is_danced_in_three_measures():
    """Golden of T127 (Fig 5.5 of the thesis): rotations of 20, 40, 20 degrees."""
    show = made_show()
    assert measures(show, 5) == pytest.approx(0.0)
    face(show, "80")
    found = measures(show, 5)[:, 0]
    assert np.diff([0.0, *found]) == pytest.approx([20.0, 40.0, 20.0, 0.0, 0.0])


def test_turns_go_the_shorter_way_round():
    show = made_show()
    face(show, "170")
    measures(show, 4)
    face(show, "-170")
    found = measures(show, 3)[:, 0]
    assert np.diff([170.0, *found]) == pytest.approx([5.0, 10.0, 5.0])


def test_planned_headings_are_taken_as_they_are_and_the_next_ones_follow_from_them():
    show = made_show()
    known = NOBODY.copy()
    known[2] = True
    found = measures(show, 3, planned=np.full(9, 1.2), known=known)
    assert found[:, 2] == pytest.approx(math.degrees(1.2))
    assert found[:, 3] == pytest.approx(0.0)
    assert np.diff([math.degrees(1.2), *measures(show, 3)[:, 2]]) == pytest.approx(
        [-math.degrees(0.3), -math.degrees(0.6), -math.degrees(0.3)]
    )


def test_who_stands_faces_where_she_came_to():
    """T126: along the way, the last heading where there is none."""
    show = made_show()
    face(show, "path")
    start = np.zeros((9, 2))
    assert measures(show, 3, start=start, wish=start + np.array([0.8, 0.0]))[-1] == pytest.approx(90.0)
    assert measures(show, 3, start=start, wish=start + np.array([0.0, -0.1]))[-1] == pytest.approx(90.0)


@pytest.mark.parametrize("words", ["centre", "attractor", "dancer 7", "group back", " BACK "])
def test_what_is_looked_at_is_ahead_of_her(words):
    show = made_show()
    show.apply(events.Attract(x=-2.0, z=-3.0, measures=8.0, **STAMP))
    show.tick(TICK)
    face(show, words, group="front")
    wish = show.state.position.astype(np.float64)
    found = np.radians(measures(show, 3, start=wish, wish=wish)[-1])
    position = show.state.position.astype(np.float64)
    place = {
        "centre": np.array([0.0, 1.5]), "attractor": np.array([-2.0, -3.0]), "dancer 7": position[6],
    }.get(words, position[5:].mean(axis=0))  # fmt: skip
    for dancer in range(5):
        way = place - wish[dancer]
        if np.hypot(*way) > 0.3:
            assert math.remainder(found[dancer] - math.atan2(way[0], way[1]), 2 * math.pi) == pytest.approx(0, abs=1e-9)
    assert found[5:] == pytest.approx(0.0)


def test_a_show_turns_its_dancers_there():
    show = made_show()
    face(show, "40", group="front")
    for tick in range(1, 64 * 13):
        show.tick(tick * TICK)
    assert show.scheduler.last_heading[:5] == pytest.approx(math.radians(40))
    assert show.dancers.present.end_heading()[:5] == pytest.approx(math.radians(40), abs=0.25)
    assert np.abs(show.dancers.present.end_heading()[5:]).max() < 0.25


@pytest.mark.parametrize("words", ["", "nowhere", "dancer 0", "dancer 10", "400", "1e3", "group", "dancer one", "½"])
def test_words_that_mean_nothing_are_refused_and_change_nothing(words):
    show = made_show()
    face(show, "30")
    with pytest.raises(PersonError):
        parse_facing(words, dancers=9, groups=("front", "back"))
    assert not show.apply(events.SetFacing(facing=words, **STAMP))
    assert not show.apply(events.SetFacing(facing="path", group="choir", **STAMP))
    assert measures(show, 4)[-1] == pytest.approx(30.0)


def test_a_patch_says_what_is_wrong_with_a_facing():
    with pytest.raises(PersonError, match="sideways"):
        parse_patch(PATCH.replace('travel_step = "glide"', 'facing = "sideways"', 1), "test.toml")
