"""Dancer headings: the smoothing of T127 with its golden values, each kind of facing, and invalid facings."""

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
NO_DANCERS = np.zeros(9, np.bool_)


def advance_headings(show, count, *, start=None, wish=None, planned=None, known=NO_DANCERS):
    """Headings [deg] of all dancers over `count` measures."""
    headings = show.scheduler.targets.headings
    place = np.zeros((9, 2)) if start is None else start
    wish = place if wish is None else wish
    planned = np.zeros(9) if planned is None else planned
    return np.degrees([headings.advance(place, wish, planned, known) for _ in range(count)])


def set_facing(show, words, group="*"):
    assert show.apply(events.SetFacing(facing=words, group=group, **STAMP)), show.refusals.words


def test_turn_of_80_degrees_takes_three_measures():
    """Golden values of T127 (Fig 5.5 of the thesis): rotations of 20, 40, 20 degrees."""
    show = made_show()
    assert advance_headings(show, 5) == pytest.approx(0.0)
    set_facing(show, "80")
    found = advance_headings(show, 5)[:, 0]
    assert np.diff([0.0, *found]) == pytest.approx([20.0, 40.0, 20.0, 0.0, 0.0])


def test_turns_take_the_shorter_direction():
    show = made_show()
    set_facing(show, "170")
    advance_headings(show, 4)
    set_facing(show, "-170")
    found = advance_headings(show, 3)[:, 0]
    assert np.diff([170.0, *found]) == pytest.approx([5.0, 10.0, 5.0])


def test_planned_headings_are_used_and_continued_smoothly():
    show = made_show()
    known = NO_DANCERS.copy()
    known[2] = True
    found = advance_headings(show, 3, planned=np.full(9, 1.2), known=known)
    assert found[:, 2] == pytest.approx(math.degrees(1.2))
    assert found[:, 3] == pytest.approx(0.0)
    assert np.diff([math.degrees(1.2), *advance_headings(show, 3)[:, 2]]) == pytest.approx(
        [-math.degrees(0.3), -math.degrees(0.6), -math.degrees(0.3)]
    )


def test_standing_dancer_keeps_her_last_path_heading():
    """T126: along the path, or the last heading without a path."""
    show = made_show()
    set_facing(show, "path")
    start = np.zeros((9, 2))
    assert advance_headings(show, 3, start=start, wish=start + np.array([0.8, 0.0]))[-1] == pytest.approx(90.0)
    assert advance_headings(show, 3, start=start, wish=start + np.array([0.0, -0.1]))[-1] == pytest.approx(90.0)


@pytest.mark.parametrize("words", ["centre", "attractor", "dancer 7", "group back", " BACK "])
def test_dancer_faces_the_named_target(words):
    show = made_show()
    show.apply(events.PlaceElement(kind="attract", points=((-2.0, -3.0),), measures=8.0, **STAMP))
    show.tick(TICK)
    set_facing(show, words, group="front")
    wish = show.state.position.astype(np.float64)
    found = np.radians(advance_headings(show, 3, start=wish, wish=wish)[-1])
    position = show.state.position.astype(np.float64)
    place = {
        "centre": np.array([0.0, 1.5]), "attractor": np.array([-2.0, -3.0]), "dancer 7": position[6],
    }.get(words, position[5:].mean(axis=0))  # fmt: skip
    for dancer in range(5):
        way = place - wish[dancer]
        if np.hypot(*way) > 0.3:
            assert math.remainder(found[dancer] - math.atan2(way[0], way[1]), 2 * math.pi) == pytest.approx(0, abs=1e-9)
    assert found[5:] == pytest.approx(0.0)


def test_show_turns_dancers_to_their_facing():
    show = made_show()
    set_facing(show, "40", group="front")
    for tick in range(1, 64 * 13):
        show.tick(tick * TICK)
    assert show.scheduler.last_heading[:5] == pytest.approx(math.radians(40))
    assert show.dancers.present.end_heading()[:5] == pytest.approx(math.radians(40), abs=0.25)
    assert np.abs(show.dancers.present.end_heading()[5:]).max() < 0.25


@pytest.mark.parametrize("words", ["", "nowhere", "dancer 0", "dancer 10", "400", "1e3", "group", "dancer one", "½"])
def test_invalid_facing_is_refused_without_effect(words):
    show = made_show()
    set_facing(show, "30")
    with pytest.raises(PersonError):
        parse_facing(words, dancers=9, groups=("front", "back"))
    assert not show.apply(events.SetFacing(facing=words, **STAMP))
    assert not show.apply(events.SetFacing(facing="path", group="choir", **STAMP))
    assert advance_headings(show, 4)[-1] == pytest.approx(30.0)


def test_patch_with_invalid_facing_is_refused():
    with pytest.raises(PersonError, match="sideways"):
        parse_patch(PATCH.replace('travel_step = "glide"', 'facing = "sideways"', 1), "test.toml")
