"""Tests of formations, groups, wings and obstacles in a running show, by controls and score."""

import numpy as np
import pytest

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_notation import parse_formation
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from tests.show.made_show import made_show

MEASURE_S = 2.0


def make_event(event, show, **values):
    return event(time=show.time, source="test", **values)


def run(show, seconds, each=None):
    """Run `seconds` of ticks; `each` is called with the show after every tick."""
    begin = round(show.time / TICK)
    for tick in range(begin + 1, begin + round(seconds / TICK) + 1):
        show.tick(tick * TICK)
        if each is not None:
            each(show)


def farthest_from(places, position):
    """The largest distance of a place to its nearest dancer [m]."""
    away = np.hypot(*(places[:, None] - position[None]).transpose(2, 0, 1))
    return float(away.min(axis=1).max())


@pytest.mark.long
def test_immediate_formation_is_reached_at_measure_line():
    show = made_show()
    run(show, 1.0)
    assert show.apply(make_event(events.Evolve, show, formation="star", measures=3.0))
    slots = formation_of(parse_formation("star"), 9, show.seed).slots
    run(show, 3 * MEASURE_S)  # half of the measure is left: it counts, so the third line is at 6 s
    assert show.span.number == 3
    assert farthest_from(slots, show.state.position) > 0.05
    run(show, 8.0 - show.time)
    assert farthest_from(slots, show.state.position) < 0.05
    before = show.state.position.copy()
    run(show, 4.0)
    assert np.abs(show.state.position - before).max() < 0.02  # and there they stay


def test_next_measure_formation_waits_for_measure_line():
    show = made_show()
    run(show, 0.5)
    places = show.state.position.copy()
    show.apply(make_event(events.Evolve, show, formation="line", measures=2.0, group="back", next=True))
    run(show, 1.4)
    assert np.abs(show.state.position - places)[5:].max() < 0.05
    run(show, 6.0 - show.time)
    assert np.abs(show.state.position[:5] - places[:5]).max() < 0.3  # only the group that was asked
    assert np.ptp(show.state.position[5:, 1]) < 0.05


@pytest.mark.long
def test_dancers_follow_their_agents_into_the_formation():
    show = made_show("""
[[segment]]
measure = 2
measures = 4
formation = "line"
""")
    run(show, 2 * MEASURE_S + 8 * MEASURE_S)
    hips = show.dancers.present.end_position()
    assert np.hypot(*(hips - show.state.position).T).max() < 0.35


SCORE = """
[[formation]]
name = "wedge"
shape = "polyline"
points = [[-3, -2], [0, 2], [3, -2]]
[[segment]]
measure = 2
measures = 3
group = "front"
formation = "Wedge"
[[segment]]
measure = 6
measures = 2
path = [[0, 0], [0, 1]]
group = "front"
[[regroup]]
measure = 3
dancers = "9"
group = "front"
"""


@pytest.mark.long
def test_score_segments_and_regroups_start_in_their_measures():
    show = made_show(SCORE)
    start = show.state.position.copy()
    run(show, 1.9)
    assert np.abs(show.state.position - start).max() < 0.1
    run(show, 8.0 - show.time)
    wedge = show.state.position[:5].copy()
    assert abs(wedge[:, 1].max() - 2.0) < 0.06
    assert show.group.tolist() == [0] * 5 + [1] * 3 + [0]
    run(show, 14.0 - show.time)
    assert np.abs(show.state.position[:5] - wedge - (0.0, 1.0)).max() < 0.06


@pytest.mark.long
def test_redefined_formation_moves_its_dancers():
    show = made_show()
    show.apply(make_event(events.DefineFormation, show, name="flower", formation="circle"))
    show.apply(make_event(events.Evolve, show, formation="Flower", measures=3.0))
    run(show, 6.0)
    show.apply(make_event(events.DefineFormation, show, name="flower", formation="line"))
    run(show, 10.0)
    assert np.ptp(show.state.position[:, 1]) < 0.05


@pytest.mark.long
def test_attractor_releases_its_group_from_formation():
    show = made_show()
    show.apply(make_event(events.Evolve, show, formation="circle", measures=1.0))
    run(show, 4.0)
    circle = show.state.position.copy()
    show.apply(make_event(events.PlaceElement, show, kind="attract", points=((4.0, -3.0),), measures=4.0, group="back"))
    run(show, 8.0)
    assert np.hypot(*(show.state.position[:5] - circle[:5]).T).max() < 0.3
    near, before = (np.hypot(*(places[5:] - (4.0, -3.0)).T) for places in (show.state.position, circle))
    assert (near < before - 1.0).all()


@pytest.mark.long
def test_crossing_moves_all_dancers_to_other_side():
    show = made_show()
    run(show, 1.0)
    side = np.sign(show.state.position[:, 1])
    show.apply(make_event(events.PlaceElement, show, kind="cross", points=((-1.0, 0.0), (1.0, 0.0)), measures=12.0))
    run(show, 24.0)
    assert (np.sign(show.state.position[:, 1]) == -side).all()


@pytest.mark.long
def test_dancers_enter_and_leave_through_gates_at_measure_lines():
    show = made_show(reserve=3)
    view = show.view()
    assert show.apply(make_event(events.Enter, show, count=2.0, group="back", gate="right"))
    run(show, 1.0)
    show.fill(view, show.time)
    assert view.present.sum() == 9
    run(show, 1.5)
    show.fill(view, show.time)
    assert view.present.tolist() == [True] * 11 + [False]
    assert show.group[9:11].tolist() == [1, 1]
    assert (view.joint_position[9:11, 0, 0] > 5.0).all()
    run(show, 16.0)
    assert (np.abs(show.state.position[:11]) <= (6.0, 4.0)).all()
    show.fill(view, show.time)
    assert (np.abs(view.joint_position[9:11, 0, 0]) < 6.0).all()
    assert show.apply(make_event(events.Leave, show, dancers="1-2", gate="left"))
    run(show, 20.0)
    show.fill(view, show.time)
    assert view.present.tolist() == [False, False, *[True] * 9, False]
    assert not show.apply(make_event(events.Enter, show, count=9.0))
    assert "only 3 waited" in show.refusals.last_reason


@pytest.mark.long
def test_agents_avoid_obstacles_and_lost_performers_are_removed():
    show = made_show()
    show.apply(make_event(events.PlaceObstacle, show, name="box", x=0.0, z=0.0, radius=1.0))
    show.apply(make_event(events.PlaceElement, show, kind="attract", points=((0.0, 0.0),), measures=12.0))
    nearest = []
    run(show, 12.0, lambda s: nearest.append(np.hypot(*s.state.position.T).min()))
    assert min(nearest[64:]) >= 1.25 - 0.01
    assert show.apply(make_event(events.Performer, show, name="Ana", x=4.0, z=3.0))
    assert show.motion.surroundings.obstacle_count == 2
    run(show, 2.5)
    assert show.motion.surroundings.obstacle_names == ("box",)
    assert show.apply(make_event(events.RemoveObstacle, show, name="box"))
    assert not show.apply(make_event(events.RemoveObstacle, show, name="box"))


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (
            lambda s: make_event(events.PlaceElement, s, kind="attract", points=((0.0, 0.0),), group="nobody"),
            "no group and no dancer is called 'nobody'",
        ),
        (
            lambda s: make_event(events.PlaceElement, s, kind="attract", points=((0.0, 0.0),), group="front &"),
            "group 'front &'",
        ),
        (
            lambda s: make_event(events.PlaceElement, s, kind="cross", points=((0.0, 0.0),)),
            "cross: its line has no length",
        ),
        (lambda s: make_event(events.PlaceElement, s, kind="path", points=()), "path: 0 points"),
        (lambda s: make_event(events.Travel, s, points=()), "a path needs points"),
        (lambda s: make_event(events.PlaceElement, s, kind="storm"), "no element is called 'storm'"),
        (lambda s: make_event(events.PlaceElement, s, kind="follow", whom="99"), "no dancer has the number 99"),
        (lambda s: make_event(events.Evolve, s, formation="blob"), "unknown formation"),
        (lambda s: make_event(events.Evolve, s, formation="path:M 0 0 L 1 1"), "while a show runs"),
        (lambda s: make_event(events.Evolve, s, formation="line", match="best"), "match 'best' is unknown"),
        (lambda s: make_event(events.Regroup, s, dancers="1", group="middle"), "no group is called 'middle'"),
        (lambda s: make_event(events.Leave, s, dancers="1", gate="trapdoor"), "no gate is called 'trapdoor'"),
    ],
)
def test_invalid_events_are_refused_with_reason(event, words):
    show = made_show()
    assert not show.apply(event(show))
    assert words in show.refusals.last_reason
    assert show.refusals.count == 1
    run(show, 0.5)


def test_unknown_names_in_patch_are_refused_at_start():
    for extra, words in (
        ('[[segment]]\nmeasure = 9\nformation = "blob"\n', "segment in measure 9"),
        ('[[segment]]\nmeasure = 9\ngroup = "nobody"\n', "segment in measure 9"),
        ('[[element]]\nkind = "attract"\nmeasure = 7\ngroup = "nobody"\n', "element in measure 7"),
        ('[[regroup]]\nmeasure = 5\ndancers = "77"\ngroup = "front"\n', "regroup in measure 5"),
    ):
        with pytest.raises(PersonError, match=words):
            made_show(extra)


def test_empty_group_does_not_stop_show():
    show = made_show('[[segment]]\nmeasure = 4\ngroup = "back"\nformation = "line"\n')
    run(show, 0.5)
    assert show.apply(make_event(events.Evolve, show, formation="star", measures=1.0, group="back & 6-9", next=True))
    assert show.apply(make_event(events.Regroup, show, dancers="back", group="front"))
    run(show, 10.0)
    assert show.group.tolist() == [0] * 9
    assert not show.apply(make_event(events.Evolve, show, formation="line", group="back"))
    assert "nobody is 'back' now" in show.refusals.last_reason


@pytest.mark.long
def test_returning_dancer_rejoins_own_group():
    show = made_show()
    show.apply(make_event(events.Leave, show, dancers="9"))
    run(show, 12.0)
    assert not show.motion.present[8]
    show.apply(make_event(events.Enter, show))
    run(show, 4.0)
    assert show.motion.present[8]
    assert show.group[8] == 1


@pytest.mark.long
def test_later_formation_for_same_measure_line_replaces_earlier():
    show = made_show()
    for formation in ("star", "circle", "line"):
        show.apply(make_event(events.Evolve, show, formation=formation, measures=3.0, next=True))
    run(show, 9.0)
    assert np.ptp(show.state.position[:, 1]) < 0.05


def run_script(show):
    """Run a script with events of all kinds; hashes at measure lines."""
    script = {
        100: make_event(events.Evolve, show, formation="star", measures=2.0, ripple=2.0),
        260: make_event(events.Enter, show, count=2.0),
        300: make_event(events.PlaceElement, show, kind="cross", points=((0.0, -1.0), (0.0, 1.0)), group="front"),
        420: make_event(events.PlaceObstacle, show, name="box", x=1.0, z=0.0),
        500: make_event(
            events.PlaceElement, show, kind="attract", points=((2.0, 1.0),), measures=2.0, fair=True, drag=True
        ),
        640: make_event(events.Regroup, show, dancers="left", group="back"),
        700: make_event(events.Travel, show, points=((0.0, 0.0), (1.0, 1.0)), measures=2.0, single_file=True),
        800: make_event(events.PlaceElement, show, kind="follow", whom="2", group="back"),
        900: make_event(events.Leave, show, dancers="3-4"),
        1000: make_event(events.Clear, show),
    }
    hashes = []
    for tick in range(1, 64 * 24):
        if tick in script:
            assert show.apply(script[tick])
        if show.tick(tick * TICK):
            hashes.append(show.state_hash())
        assert np.isfinite(show.state.flat).all()
    return hashes


@pytest.mark.long
def test_combined_script_is_deterministic():
    first, second = (run_script(made_show(reserve=2)) for _ in range(2))
    assert len(first) == len(set(first)) == 11
    assert first == second
