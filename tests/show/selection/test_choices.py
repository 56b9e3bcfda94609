"""Explanations of step choices, dancers that lag, standing groups, and planning in pieces."""

import json

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.show.selection.choices import BEHIND_M, BEHIND_MEASURES, explanation_lines
from tests.show.made_show import made_show

STAMP = {"time": 0.0, "source": "test"}


def run(show, seconds, watch=lambda: None):
    for tick in range(round(show.time / TICK) + 1, round((show.time + seconds) / TICK)):
        show.tick(tick * TICK)
        watch()


def test_explanation_matches_the_chosen_candidate():
    show = made_show()
    show.apply(events.AskWhy(dancer=3, **STAMP))
    for _ in range(4):
        run(show, 2.0)
        told = show.explain_choice()
        while not show.dancers.decided:
            run(show, 0.1)
            told = show.explain_choice()
        library, choices = show.graph.library, show.scheduler.choices
        assert told["dancer"] == 3
        assert told["chosen"]["clip"] == library.describe(int(show.dancers.coming.node[2]))
        assert told["wanted"] == library.steps[library.node_step[show.dancers.coming.node[2]]]
        parts = [told["chosen"][name] for name in ("place", "heading", "pose", "wrong_step", "other")]
        assert told["chosen"]["score"] == pytest.approx(sum(parts), abs=1e-3)
        if told["runner_up"] is not None:
            assert told["runner_up"]["score"] >= told["chosen"]["score"]
            assert choices.node[2, 0] != choices.node[2, 1]
        taken = show.dancers.coming.take_share[0, 2]
        assert told["chosen"].get("share", 0.0) == pytest.approx(taken)
        assert json.loads(json.dumps(told)) == told
        assert 1 <= len(explanation_lines(told)) <= 3


@pytest.mark.long
def test_explanation_request_does_not_change_the_dance():
    asked, plain = made_show(), made_show()
    asked.apply(events.AskWhy(dancer=2, **STAMP))
    assert not asked.apply(events.CallStep(name="moonwalk", **STAMP))
    for show in (asked, plain):
        run(show, 5.0)
    assert asked.state_hash() == plain.state_hash()
    assert plain.explain_choice() is None
    asked.apply(events.AskWhy(dancer=99, **STAMP))
    assert asked.explain_choice() is None


@pytest.mark.long
def test_planning_is_spread_over_ticks_before_decision():
    """No tick does more than its share; only the assembly of the result is left for the decision."""
    show = made_show()
    scheduler = show.scheduler
    left, heaviest = [], [0]

    def look():
        left.append(scheduler._planning.pieces.remaining)
        heaviest.extend(scheduler._planning.pieces.weights())

    run(show, 7.0, look)
    left = np.array(left)
    done = -np.diff(left)
    begun = left[:-1] > 0
    most = left.max()
    ticks = round(0.75 * 0.5 / TICK)  # three quarters of a beat of 0.5 s
    assert done[begun].max() <= max(max(heaviest), 1.5 * most / ticks) + 1e-6
    assert left[np.flatnonzero(done > 0) + 1].min() == pytest.approx(0.0, abs=1e-6)
    assert max(heaviest) < 0.2 * most


def test_stalled_show_plans_everything_at_decision():
    """A show that skips all ticks of the planning still decides, with the complete plan."""
    show = made_show()
    run(show, 1.0)
    show.tick(1.9)
    assert show.dancers.decided
    assert (show.dancers.coming.node >= 0).all()


@pytest.mark.long
def test_targets_stay_within_reach_and_report_suggests_recording():
    show = made_show("[locomotion]\ncorrection_m = 0.35\n")
    show.apply(events.SetSequence(steps="sway", group="*", **STAMP))
    run(show, 4.0)
    assert all(told["record"] is None for told in show.scheduler.reachability_report().values())
    # a formation at the other end of the stage, for dancers who sway on the spot
    show.apply(events.Evolve(formation="line", measures=2.0, group="front", time=show.time, source="test"))
    for index, section in enumerate(show.patch.group):
        assert section.name == ("front", "back")[index]
    show.scheduler.choices.wish[:] = 0.0
    choices = show.scheduler.choices
    for programme in show.scheduler.programmes:
        programme.travel_step = None
    far = np.zeros((9, 2))

    def sent(*_):
        return show.state.position + far, np.zeros(9, np.bool_), np.zeros(9)

    show.motion.predicted_ends = sent
    far[:5] = [0.0, 2.0]
    run(show, 2.0 * (BEHIND_MEASURES + 2))
    assert (np.hypot(*(choices.target - choices.start_position).T) < 0.3).all()
    assert (choices.lag[:5] > BEHIND_M).all()
    told = show.scheduler.reachability_report()
    assert told["front"]["behind"] == 5
    assert told["back"]["behind"] == 0
    assert "'sway'" in told["front"]["record"]
    assert "forward" in told["front"]["record"]
    assert show.scheduler.detours == 0  # they keep their step


def planned_end_errors(seconds=16.0):
    """Distance of uncorrected measure ends from the dancers' targets, decision by decision [m]."""
    show, found, seen = made_show(), [], set()
    show.apply(events.PlaceElement(kind="attract", points=((2.7, 1.3),), measures=30.0, **STAMP))

    def look():
        if show.dancers.decided and show.span.number not in seen:
            seen.add(show.span.number)
            coming = show.dancers.coming
            end = coming.end_position() - coming.correction[:, :2]
            found.append(np.hypot(*(show.scheduler.choices.target - end).T))

    run(show, seconds, look)
    return np.array(found)


@pytest.mark.long
def test_refined_shares_end_mixtures_nearer_to_targets(monkeypatch):
    refined = planned_end_errors()
    monkeypatch.setattr("live.show.selection.measure_draft.SHARE_REFINEMENT", 0.0)
    stepped = planned_end_errors()
    assert len(refined) == len(stepped) == 8
    assert (refined[0] <= stepped[0] + 2e-3).all()  # until then nothing else differs
    assert refined[:4].mean() < stepped[:4].mean()


def test_standing_group_draws_no_traveling_step(monkeypatch):
    """Only glide is patched to have no measure in place: it is drawn only while the group travels."""
    show = made_show()
    programme = show.scheduler.programmes[1]
    library = show.graph.library
    nodes = show.dancers.node[show.group == 1]
    monkeypatch.setattr("live.show.score.step_program.is_in_place", lambda graph, step: library.steps[step] != "glide")
    for stands in (True, False):
        programme.standing = stands
        drawn = {library.steps[programme._draw(measure, nodes)] for measure in range(200)}
        assert ("glide" in drawn) == (not stands)
