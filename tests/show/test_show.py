"""The deterministic core: same events, same states; measure lines; effects of events."""

import numpy as np
import pytest

from live.base.element_kinds import ATTRACTOR, SPREADER
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.skeleton import SKELETON
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.hips import hips
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, made_show


def event_now(kind, show, /, **values):
    return kind(time=show.time, source="test", **values)


def run(show, seconds, script=()):
    """Runs ticks for `seconds`; `script`: functions of the show by tick. Returns hashes at measure lines."""
    hashes = []
    start = round(show.time / TICK)
    for tick in range(start + 1, start + round(seconds / TICK) + 1):
        for when, act in script:
            if when == tick:
                act(show)
        if show.tick(tick * TICK):
            hashes.append(show.state_hash())
    return hashes


def gather_dancers(show):
    show.apply(event_now(events.PlaceElement, show, kind="attract", points=((3.0, 1.0),), measures=8.0))


def hips_now(show):
    return hips(show.dancers, show.span.fraction(show.timeline.beat_at(show.time)))


SCRIPT = (
    (200, gather_dancers),
    (700, lambda s: s.apply(event_now(events.PlaceElement, s, kind="spread"))),
    (900, lambda s: s.apply(event_now(events.One, s))),
)


@pytest.mark.long
def test_same_patch_seed_and_events_give_the_same_states():
    first, second = run(made_show(), 18, SCRIPT), run(made_show(), 18, SCRIPT)
    assert len(first) == len(set(first)) >= 8
    assert first == second


def test_other_seed_or_events_change_the_states():
    plain = run(made_show(), 6)
    assert run(made_show(seed=4), 6) != plain
    assert run(made_show(), 6, SCRIPT) != plain


@pytest.mark.long
def test_measures_are_crossed_on_the_beat():
    show = made_show()
    for tick in range(1, 64 * 10 + 1):
        crossed = show.tick(tick * TICK)
        assert crossed == (tick % 128 == 0)  # four beats at 120 bpm are two seconds
        assert show.span.number == tick // 128


@pytest.mark.long
def test_next_step_is_decided_one_beat_before_measure_line():
    show = made_show()
    for tick in range(1, 64 * 8):
        show.tick(tick * TICK)
        left = show.span.end - show.timeline.beat_at(tick * TICK)
        assert show.dancers.decided == (left <= 1.0)


def test_all_dancers_dance_the_sequence_in_order():
    show = made_show()
    library = show.graph.library
    danced = []
    for tick in range(1, 64 * 24 + 1):
        if show.tick(tick * TICK) or tick == 1:
            danced.append({library.steps[library.node_step[n]] for n in show.dancers.node[:5]})
    names = ["sway", "glide", "glide", "spin", "phrase", "phrase"]
    assert danced[:12] == [{name} for name in names * 2]


@pytest.mark.long
def test_dancers_gather_at_attractor_and_spread_again():
    show = made_show()
    run(show, 4)
    before = np.hypot(*(hips_now(show) - [3, 1]).T).mean()
    gather_dancers(show)
    run(show, 16)
    gathered = np.hypot(*(hips_now(show) - [3, 1]).T).mean()
    assert gathered < 0.5 * before
    show.apply(event_now(events.Clear, show))
    show.apply(event_now(events.PlaceElement, show, kind="spread", measures=12.0))
    run(show, 24)
    assert np.hypot(*(hips_now(show) - [3, 1]).T).mean() > 1.8 * gathered


@mostly_long(("lock", "left"), [("false", 0.05), ("true", 0.15)], quick=[])
def test_dancers_follow_their_agents_and_catch_up(lock, left):
    """A dancer follows with her next measure: an agent that starts to move is at most a measure's distance ahead.

    These steps lift no foot: with foot lock the last part of the distance stays, since locked feet would be dragged.
    """
    show = made_show(f"[motion]\nfoot_lock = {lock}\n")
    gather_dancers(show)
    errors = []
    for tick in range(1, 64 * 32 + 1):
        if show.tick(tick * TICK):
            errors.append(np.hypot(*(hips_now(show) - show.state.position).T).max())
    assert max(errors) < 1.1
    assert max(errors[-2:]) < left


@pytest.mark.long
def test_poses_are_continuous_in_time():
    """No joint moves faster than a body can: 9 m/s; the synthetic steps themselves reach about 3."""
    show = made_show()
    gather_dancers(show)
    view, before, fastest = show.view(), None, 0.0
    for tick in range(1, 64 * 14):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        if before is not None:
            moved = np.linalg.norm(view.joint_position - before, axis=2).max() / TICK
            fastest = max(fastest, float(moved))
        before = view.joint_position.copy()
    assert fastest < 9.0


@pytest.mark.long
def test_frame_between_line_and_crossing_tick_continues_the_dance():
    """The same moment, drawn a tick before the line is crossed and right after it: no dancer waits for the tick."""
    show, other = made_show(), None
    show.apply(event_now(events.SetTempo, show, tempo=113.0))
    apart, view = [], show.view()
    for tick in range(1, round(30.0 / TICK)):
        before = show.time
        beyond = show.timeline.beat_at(before + TICK) - show.span.end
        line = beyond > 0.01 and show.timeline.beat_at(before) < show.span.end
        at_tick = before + TICK * (1.0 - 1e-6)
        if line:
            show.fill(view, at_tick)
            other = view.joint_position.copy()
        show.tick(tick * TICK)
        if line:
            show.fill(view, at_tick)
            apart.append(np.abs(view.joint_position - other)[:, SKELETON.index("leftUpperArm")].max())
    assert len(apart) >= 3
    assert max(apart) < 3e-4


@pytest.mark.long
def test_all_dancers_dance_called_step_for_its_measures():
    show = made_show()
    library = show.graph.library
    show.apply(event_now(events.CallStep, show, name="Spin", measures=2.0))
    danced = []
    for tick in range(1, 64 * 10):
        if show.tick(tick * TICK):
            danced.append({library.steps[library.node_step[n]] for n in show.dancers.node})
    assert danced[0] == danced[1] == {"spin"}
    assert danced[2] != {"spin"}


def test_unknown_step_is_counted_without_effect():
    show, plain = made_show(), made_show()
    show.apply(event_now(events.CallStep, show, name="moonwalk"))
    assert show.refusals.count == 1
    assert run(show, 6) == run(plain, 6)


@pytest.mark.long
def test_downbeat_event_moves_line_without_jump():
    show = made_show()
    run(show, 3.0)  # beat 6: phase 2 of measure 1
    before = show.span.fraction(show.timeline.beat_at(show.time))
    show.apply(event_now(events.One, show))
    fractions, numbers = [before], [show.span.number]
    for tick in range(193, 193 + 64 * 6):
        show.tick(tick * TICK)
        beat = show.timeline.beat_at(tick * TICK)
        fractions.append(show.span.number + show.span.fraction(beat))
        numbers.append(show.span.number)
    steps = np.diff(fractions[1:])
    assert (steps >= 0).all()
    assert steps.max() < 3 * TICK / 2.0  # at most three times the plain speed
    assert set(np.diff(numbers)) <= {0, 1}
    assert (show.span.end - show.timeline.measure_origin) % 4 == pytest.approx(0)


def test_blackout_fades_out_and_back_within_300_ms():
    show = made_show()
    show.apply(event_now(events.Blackout, show, on=True))
    run(show, 0.3)
    assert show.brightness < 0.05
    show.apply(event_now(events.Blackout, show, on=False))
    run(show, 0.3)
    assert show.brightness > 0.95


@pytest.mark.long
def test_slower_tempo_stretches_the_measures():
    show = made_show()
    show.apply(event_now(events.SetTempo, show, tempo=60.0))
    crossed = [tick for tick in range(1, 64 * 13) if show.tick(tick * TICK)]
    assert np.diff(crossed) == pytest.approx(256, abs=1)


def test_score_places_elements_in_their_measures():
    show = made_show('[[element]]\nkind = "attract"\nmeasure = 3\nmeasures = 2\nat = [1.0, 2.0]\n')
    view = show.view()
    seen = {}
    for tick in range(1, 64 * 12):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        seen.setdefault(show.span.number, set()).add(view.element_count)
    assert seen[1] == {0}
    assert 1 in seen[2]
    assert 1 in seen[3]
    assert seen[4] == {0}
    assert view.element_kind[0] == ATTRACTOR


def test_dragged_attractor_moves_alone():
    show = made_show('[[element]]\nkind = "spread"\nmeasure = 2\nmeasures = 4\n')
    show.apply(events.PlaceElement(time=0.0, source="pointer", kind="attract", points=((0.0, 0.0),)))
    for tick in range(1, 64 * 4):  # over a measure line, at which the score adds a spreader
        show.tick(tick * TICK)
        if tick % 60 == 0:
            show.apply(
                events.PlaceElement(
                    time=tick * TICK, source="pointer", kind="attract", points=((0.01 * tick, 0.0),), drag=True
                )
            )
    kinds = [element.kind for element in show.motion.elements.in_force]
    assert kinds == [ATTRACTOR, SPREADER]
    assert show.motion.elements.in_force[0].x == pytest.approx(2.4)
    show.apply(
        event_now(events.PlaceElement, show, kind="attract", points=((0.0, 0.0),), drag=True)
    )  # another source: nothing to move yet
    show.apply(events.PlaceElement(time=9.0, source="pointer", kind="attract", points=((0.0, 0.0),)))
    assert len(show.motion.elements.in_force) == 4


@mostly_long("press", [3.75, 3.9, 4.05, 5.5, 6.9], quick=[0])
def test_downbeat_event_causes_no_joint_jump(press):
    """At any press time, also where the stretched measure reaches its blend long before its end."""
    show = made_show()
    run(show, press * 0.5)
    show.apply(event_now(events.One, show))
    view, before, fastest = show.view(), None, 0.0
    for tick in range(round(press * 32) + 1, round(press * 32) + 64 * 5):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        if before is not None:
            fastest = max(fastest, float(np.linalg.norm(view.joint_position - before, axis=2).max()))
        before = view.joint_position.copy()
    assert fastest < 0.16  # a metre of arm in a tick is 60 m/s; the made steps reach 0.07 at twice their speed


@mostly_long("beat", [1.0, 3.2, 3.9], quick=[1])
def test_step_called_for_one_measure_is_danced_at_any_beat(beat):
    show = made_show()
    library = show.graph.library
    run(show, beat * 0.5)
    show.apply(event_now(events.CallStep, show, name="spin", measures=1.0))
    danced = []
    for tick in range(round(beat * 32) + 1, 64 * 9):
        if show.tick(tick * TICK):
            danced.append([library.steps[library.node_step[n]] for n in show.dancers.node[:5]].count("spin"))
    assert danced.count(5) >= 1


@pytest.mark.long
def test_dancers_stay_on_stage_with_attractor_outside():
    show = made_show()
    show.apply(
        event_now(events.PlaceElement, show, kind="attract", points=((100.0, 100.0),), strength=10.0, measures=40.0)
    )
    for tick in range(1, 64 * 16):
        show.tick(tick * TICK)
    ends = show.dancers.present.end_position()
    assert (np.abs(ends) <= np.array([6.0, 4.0]) + 1e-4).all()


@pytest.mark.long
def test_music_with_late_downbeat_starts_with_first_step():
    top = "loop_measures = 3\nmusic = {one_at_s = 1.5, bpm = 120}\n"
    show = made_show(top + 'element = [{kind = "spread", measure = 3}]\n', top=True)
    assert show.span.number == -1
    assert not show.motion.elements.in_force
    library = show.graph.library
    danced = {}
    for tick in range(1, 64 * 6):
        show.tick(tick * TICK)
        danced.setdefault(show.span.number, library.steps[library.node_step[show.dancers.node[0]]])
    assert (danced[-1], danced[0], danced[1]) == ("sway", "sway", "glide")


@pytest.mark.long
def test_extreme_tempo_and_many_elements_keep_state_finite():
    show = made_show()
    for k in range(400):
        show.apply(
            events.PlaceElement(
                time=0.0, source="osc", kind="attract", points=((100.0 * (-1) ** k, -100.0),), strength=10.0
            )
        )
        show.apply(events.PlaceElement(time=0.0, source="osc", kind="repel", points=((0.0, 0.0),), strength=10.0))
    for tick in range(1, 64 * 8):
        if tick % 20 == 0:
            show.apply(event_now(events.SetTempo, show, tempo=[20.0, 400.0][tick // 20 % 2]))
        show.tick(tick * TICK)
        assert np.isfinite(show.state.position).all()
    assert np.isfinite(hips_now(show)).all()
    assert (np.abs(show.state.position) <= np.array([6.0, 4.0]) + 1e-4).all()


def test_dancers_are_not_extrapolated_beyond_step_after_stall():
    show, view = made_show(), made_show().view()
    run(show, 5.0)
    count = 64 * 60
    show.apply(event_now(events.TicksSkipped, show, count=count))
    show.tick(show.time + TICK)
    behind = (show.timeline.beat_at(show.time) - show.span.end) / show.timeline.beats_per_measure
    assert behind > 10.0  # lines are crossed a few in each tick
    show.fill(view, show.time)
    on = 2.0 * TICK * show.timeline.tempo / 60.0 / show.timeline.beats_per_measure
    np.testing.assert_array_equal(view.joint_position, show.dancers.pose(1.0 + on, show.time)[0])
    assert not np.allclose(view.joint_position, show.dancers.pose(1.0 + behind, show.time)[0], atol=0.01)


def test_groups_with_the_same_start_position_are_separated():
    patch = "".join(f'[[group]]\nname = "g{k}"\ndancers = 5\nsteps = ["sway"]\n' for k in range(2))
    show = assemble(parse_patch('name = "x"\n' + patch, "x"), GRAPH)
    apart = np.hypot(*(show.state.position[:, None] - show.state.position[None]).transpose(2, 0, 1))
    assert apart[np.triu_indices(10, 1)].min() > 0.6
