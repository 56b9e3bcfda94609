"""Carrying: corrections within what legs give, agents bound to dancers, nobody touches; and what that costs is told."""

from functools import cache

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.show.group.group_motion import LEASH
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES
from live.show.show import Show

PATCH = """
name = "carrying"
seed = 5
reserve = 0
[clock]
bpm = 120
[locomotion]
obedience = {obedience}
[stage]
width = 8
depth = 6
[[group]]
name = "all"
dancers = 10
steps = ["side step", "walk x2", "samba"]
travel_step = "walk"
formation = "grid"
size = [6.0, 4.0]
"""
SIZE = 128
"""Ticks of a measure at 120 bpm."""


@cache
def loaded():
    return load_from_patch(parse_patch(PATCH.format(obedience=0.5), "carrying"), PATCHES / "carrying.toml")


def made(obedience=0.5, extra=""):
    return Show(parse_patch(PATCH.format(obedience=obedience) + extra, "carrying"), loaded().graph)


def run(show, measures, act=None, each=None):
    """Tick on for so many measures; `act` maps ticks to events, `each` sees the show after every tick."""
    start = round(show.time / TICK)
    for tick in range(start + 1, start + measures * SIZE + 1):
        event = (act or {}).get(tick)
        if event is not None:
            show.apply(event)
        show.tick(tick * TICK)
        if each is not None:
            each(show)


def attract(tick, x, z):
    return {tick: events.Attract(time=tick * TICK, source="test", x=x, z=z, measures=8.0)}


def test_those_who_gather_and_cross_do_not_touch():
    show, nearest = made(), []

    def look(show):
        hips = show.dancers.drawn_hips.astype(float)
        apart = np.hypot(*(hips[:, None] - hips[None]).transpose(2, 0, 1))
        np.fill_diagonal(apart, np.inf)
        nearest.append(apart.min())

    cross = events.PlaceElement(time=8.0, source="test", kind="cross", points="0 -3, 0 3", measures=4.0)
    run(show, 9, {**attract(64, -2.0, 1.0), 8 * 64: cross}, look)
    assert min(nearest) > 2 * 0.25
    stood = show.scheduler.root_correction.statistics()["groups"]["all"]
    assert stood["slide_m_s"] < 0.03
    assert stood["lag_m"] < 0.5
    assert stood["obedience"] == 0.5


def test_where_dancers_begin_is_no_slide_and_no_lag():
    """Before: 589 m/s in the first ticks, and 9.2 m behind at the first line; nobody had been anywhere else."""
    show, worst = made(), []

    def look(show):
        told = show.scheduler.root_correction.statistics()["groups"]["all"]
        worst.append((told["slide_m_s"], told["lag_m"]))

    run(show, 3, {}, look)
    slid, lag = (max(values) for values in zip(*worst, strict=True))
    assert slid < 0.03
    assert lag < 0.5


def test_corrections_stay_within_what_legs_give():
    show, found = made(obedience=0.0), []

    def look(show):
        if show.span.fraction(show.timeline.beat_at(show.time)) < 1.5 / SIZE:
            present, graph = show.dancers.present, show.graph
            size = np.hypot(*present.correction[:, :2].T)
            free = (
                show.scheduler.root_correction.path_separation.shortfall < -0.2
            )  # whom no other dancer made go farther
            found.extend((size / graph.node_reach_margins[present.node].max(axis=1))[free])

    run(show, 8, attract(32, 2.0, -1.0), look)
    assert len(found) > 20
    assert np.quantile(found, 0.9) < 0.5  # faithful: less than half of it
    assert max(found) <= 1.5


def changed_within(obedience, extra=""):
    """How much corrections change between the line and the next decision, with an attractor thrown meanwhile, and how
    late everybody is."""
    show = made(obedience, extra)
    run(show, 4)
    before = show.dancers.present.correction[:, :2].copy()
    run(show, 0)
    start = round(show.time / TICK)
    for tick in range(start + 1, start + SIZE // 2 + 8):
        if tick == start + 2:
            show.apply(events.Attract(time=show.time, source="test", x=3.5, z=2.5, measures=4.0))
        show.tick(tick * TICK)
    assert not show.dancers.decided
    return np.hypot(*(show.dancers.present.correction[:, :2] - before).T), show.variation.delays


def test_only_the_obedient_are_carried_elsewhere_within_the_measure():
    (obedient, late), (faithful, _) = changed_within(1.0), changed_within(0.0)
    assert not late.any()
    assert np.median(obedient) > 2.0 * np.median(faithful) + 0.005
    assert (faithful < 0.02).sum() >= 5  # the others may have to avoid somebody


def test_so_are_those_who_are_late_even_before_they_begin_it():
    ripple = 'ripple = "left"\nripple_beats = 3.0\n'
    (obedient, late), (faithful, _) = changed_within(1.0, ripple), changed_within(0.0, ripple)
    assert np.count_nonzero(late > 0.5 + 8.0 / SIZE) >= 2  # who has not begun the measure when it is looked at
    for those in (late > 0.0, late > 0.5 + 8.0 / SIZE):
        assert np.median(obedient[those]) > 2.0 * np.median(faithful[those]) + 0.005


def test_agents_go_no_farther_than_their_leash():
    show, far = made(), []

    def look(show):
        away = show.state.position - show.scheduler.root_correction.reference
        far.append(np.hypot(*away.T).max())

    run(show, 5, attract(16, 3.5, 2.5), look)
    assert max(far) < LEASH + 0.1  # a tick of the way more
    assert max(far) > 0.5 * LEASH


def test_the_same_show_twice_is_carried_alike():
    hashes = []
    for _ in range(2):
        show = made(1.0)
        run(show, 5, attract(100, 2.0, 2.0))
        hashes.append(show.state_hash())
    assert hashes[0] == hashes[1]


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_obedience_is_set_live(value):
    show = made()
    show.apply(events.SetMotion(time=0.0, source="test", parameter="obedience", value=value, group="all"))
    assert (show.variation.obedience == value).all()
