"""What could come next in a running show: after which elements, for whom, until when; it changes nothing."""

import json

import pytest

from live.clock.ticks import TICK
from live.control.events.events import Launch, StopLaunches
from live.show.view.next_formations import MOST_TOLD, TOLD_MEASURES, NextFormations, known_formations
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import made_show

CROSS = '[[element]]\nkind = "cross"\nmeasure = 2\nmeasures = 3\nat = [0.0, -3.5]\nto = [0.0, 3.5]\n'
ARROW = '[[formation]]\nname = "arrow"\nshape = "arc"\nsize = [7, 5]\n'


class Night:
    """A show with suggestions, tick by tick."""

    def __init__(self, extra):
        self.show = made_show(extra)
        self.next = NextFormations(self.show)
        self.ticks = 0

    def dance(self, measure, each=lambda: None, events=()):
        """Dance until a measure (from 1) begins."""
        while self.show.span.number + 1 < measure:
            self.ticks += 1
            for event in events:
                assert self.show.apply(event)
            events = ()
            self.show.tick(self.ticks * TICK)
            self.next.frame()
            each()
        return self.next.facts()


def test_formations_are_suggested_after_a_crossing():
    night = Night(ARROW + CROSS)
    assert night.dance(5) is None
    told = night.dance(6)
    assert (told["after"], told["who"]) == ("cross", "*")
    assert 1 <= len(told["pads"]) <= MOST_TOLD
    assert json.loads(night.next.text()) == told == night.next.status()
    for pad in told["pads"]:
        assert night.show.launcher.pads.find(pad["pad"]).name == pad["name"]
        assert 1 <= pad["measures"] <= 8


@pytest.mark.long
def test_suggestion_can_be_launched_and_ends_then():
    night = Night(ARROW + CROSS)
    told = night.dance(6)
    first = told["pads"][0]
    launch = Launch(
        time=night.ticks * TICK, source="test", pad=first["pad"], group=told["who"], measures=first["measures"]
    )
    assert night.dance(8, events=[launch]) is None
    evolved = [motion.segment.intention.formation for motion in night.show.motion.evolutions._plan.motions]
    assert first["name"] in evolved


@pytest.mark.long
def test_suggestion_is_told_for_a_while_only():
    night = Night(CROSS)
    assert night.dance(5 + TOLD_MEASURES - 1) is not None
    assert night.dance(5 + TOLD_MEASURES + 1) is None


@mostly_long(
    "follows",
    [
        '[[segment]]\nmeasure = 5\nmeasures = 3\nformation = "circle"\n',
        '[[segment]]\nmeasure = 5\nmeasures = 3\nformation = "circle"\ngroup = "back"\n',
        '[[element]]\nkind = "spread"\nmeasure = 4\nmeasures = 30\n',
    ],
    quick=[],
)
def test_nothing_is_suggested_for_dancers_whom_something_else_moves(follows):
    told = []
    night = Night(CROSS + follows)
    night.dance(12, lambda: told.append(night.next.facts()))
    assert told.count(None) == len(told)


@mostly_long(("group", "who"), [("back", "back"), ("back + 1", "1 + 6-9"), ("8 + 9", "8-9")], quick=[1])
def test_dancers_are_those_of_the_element(group, who):
    assert Night(f'{CROSS}group = "{group}"\n').dance(6)["who"] == who


@pytest.mark.long
def test_single_dancer_makes_no_formation():
    assert Night(f'{CROSS}group = "9"\n').dance(6) is None


@pytest.mark.long
def test_element_that_is_stopped_by_hand_has_ended_too():
    night = Night("")
    begin = Launch(time=0.0, source="test", pad="element attract", group="front", when="now", measures=100)
    assert night.dance(4, events=[begin]) is None
    stop = StopLaunches(time=night.ticks * TICK, source="test", group="front")
    told = night.dance(6, events=[stop])
    assert (told["after"], told["who"]) == ("attract", "front")


@pytest.mark.long
def test_it_changes_nothing_of_the_show():
    hashes = {True: [], False: []}
    for watched, seen in hashes.items():
        show = made_show(ARROW + CROSS)
        suggestions = NextFormations(show)
        for tick in range(1, 64 * 14):
            show.tick(tick * TICK)
            if watched:
                suggestions.frame()
            if tick % 64 == 0:
                seen.append(show.state_hash())
    assert hashes[True] == hashes[False]


def test_known_formations_are_those_of_the_show_first():
    show = made_show(ARROW + '[[formation]]\nname = "circle"\nshape = "ellipse"\n')
    found = [formation.name for formation in known_formations(show, 9)]
    assert found[:2] == ["arrow", "circle"]
    assert len(found) == len(set(found))
    assert "grid" in found
