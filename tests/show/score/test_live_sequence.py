"""/dance/sequence: a group's steps are changed live, or the event is refused with its reason."""

from dataclasses import replace

import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.made_steps import made_clip
from tests.show.made_show import made_show

STAMP = {"time": 0.0, "source": "test"}


def dance(show, measures, first_tick=1):
    """The steps of each group, measure by measure, and the tick reached."""
    library, danced, tick = show.graph.library, [], first_tick
    while len(danced) < measures:
        if show.tick(tick * TICK):
            steps = [library.steps[s] for s in library.node_step[show.dancers.node]]
            danced.append([{s for s, g in zip(steps, show.group, strict=True) if g == group} for group in (0, 1)])
        tick += 1
    return danced, tick


@pytest.mark.long
def test_live_sequence_changes_one_group_only():
    show, other = made_show(), made_show()
    before, tick = dance(show, 3)
    assert show.apply(events.SetSequence(steps="spin, glide x2", group="FRONT", **STAMP))
    after, _ = dance(show, 12, tick)
    expected, _ = dance(other, 15)
    wanted = [{"spin"}, {"glide"}, {"glide"}] * 5
    front = [front for front, _ in after]
    assert any(front[n : n + 9] == wanted[:9] for n in range(4))  # chosen at once, danced within two measures
    assert [back for _, back in before + after] == [back for _, back in expected]


def test_clear_restores_the_steps_of_the_patch():
    show = made_show()
    _, tick = dance(show, 2)
    show.apply(events.SetSequence(steps="sway", group="front", **STAMP))
    after, tick = dance(show, 6, tick)
    assert {name for front, _ in after[3:] for name in front} == {"sway"}
    show.apply(events.Clear(**STAMP))
    later, _ = dance(show, 10, tick)
    assert {"glide", "spin"} <= {name for front, _ in later for name in front}


@pytest.mark.long
def test_star_entry_allows_any_step():
    show = made_show()
    assert show.apply(events.SetSequence(steps="spin, *", group="front", **STAMP))
    danced, _ = dance(show, 10)
    places = [n for n, (front, _) in enumerate(danced) if front == {"spin"}]
    assert len(places) >= 4


def test_unknown_step_is_refused_with_nearest_name():
    show = made_show()
    assert not show.apply(events.SetSequence(steps="sway, glyde", **STAMP))
    assert "glide" in show.refusals.last_reason
    assert not show.apply(events.SetSequence(steps="sway", group="nobody", **STAMP))
    assert "nobody" in show.refusals.last_reason
    assert show.refusals.count == 2


@pytest.mark.long
def test_sequence_without_transition_is_refused_and_dance_continues():
    """A spin ends in a pose from which no sway begins: a sequence of spin and sway is refused as a whole."""
    steps = [
        replace(made_clip("sway"), begin_pose="low", end_pose="low"),
        replace(made_clip("sway"), begin_pose="low", end_pose="high"),
        replace(made_clip("spin"), begin_pose="high", end_pose="high"),
        replace(made_clip("bow"), begin_pose="high", end_pose="low"),
    ]
    patch = 'name = "p"\n[clock]\nbpm = 120\n[[group]]\nname = "all"\ndancers = 4\nsteps = ["sway"]\n'
    show = assemble(parse_patch(patch, "test.toml"), build_graph(build_library(steps), threshold=0.2))
    show.tick(TICK)
    assert not show.apply(events.SetSequence(steps="spin, sway", **STAMP))
    assert "cannot be joined" in show.refusals.last_reason
    assert show.apply(events.SetSequence(steps="sway, spin, bow", **STAMP))
    library, danced = show.graph.library, []
    for tick in range(2, 64 * 30):
        if show.tick(tick * TICK):
            danced.append({library.steps[s] for s in library.node_step[show.dancers.node]})
    assert [{"sway"}, {"spin"}, {"bow"}] * 3 in [danced[n : n + 9] for n in range(4)]
