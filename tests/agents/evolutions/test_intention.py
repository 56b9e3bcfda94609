"""The running plan: arrival on the measure, boundary conditions, live segments, edits (T085-T089, T095-T103)."""

from dataclasses import replace

import numpy as np
import pytest

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentState
from live.agents.evolutions.dry_run import simulate_plan
from live.agents.evolutions.facing import Facing, Orientation, shortest_turn
from live.agents.evolutions.intention import (
    AssignmentMethod,
    Evolve,
    FollowMode,
    Hold,
    Matching,
    PathMode,
    Pause,
    Places,
    Procedural,
    Repertoire,
    Segment,
    Trajectory,
)
from live.agents.evolutions.planned_segment import MAX_LATE_CALLS
from live.agents.evolutions.running_plan import MAX_IMMEDIATE_DANCERS, Plan
from live.agents.evolutions.slot_assignment import Cost
from live.agents.evolutions.slot_layout import edge_places
from live.agents.evolutions.start_delays import Arrival, Ripple, StartOrder
from live.agents.groups.roster import Line, Roster, mirror_places
from live.base.errors import PersonError

A = 12
START = np.stack([np.arange(A) - 5.5, np.tile([0.0, -1.0], A // 2)], 1)
ANGLE = np.arange(A) * 2 * np.pi / A
RING = Places("ring", np.stack([np.sin(ANGLE), np.cos(ANGLE)], 1) * 3, ANGLE)
ROWS = Places("rows", np.stack([np.tile(np.arange(6) - 2.5, 2), np.repeat([1.0, -1.0], 6)], 1), np.zeros(A))
CURVE = np.stack([np.linspace(0, 2, 30), np.sin(np.linspace(0, 3, 30))], 1)
REPERTOIRE = Repertoire({"ring": RING, "rows": ROWS}, {"curve": CURVE}, {"to the ring": Evolve("ring")})


def plan(*segments, roster=None, **options):
    return Plan(roster or Roster.create(A), REPERTOIRE, segments, **options)


def dance(running, measures, position=START, push=None, bpm=120.0):
    """Follows the plan without obstacles; returns the positions at the measure lines."""
    state, wants = AgentState.at_rest(position), AgentCommand(len(position))
    heading, lines = np.zeros(len(position)), []
    for measure in range(measures):
        running.begin_measure(measure, state.position, heading)
        for tick in range(128):
            wants.clear()
            running.write_commands(wants, state, 4 * (measure + tick / 128), bpm / 60)
            state.position += wants.velocity * np.float32(4 * 60 / bpm / 128)
            if push is not None and measure == 0 and tick == 64:
                state.position += push
        there = running.predicted_state(4.0 * (measure + 1))
        heading = np.where(there.controlled == 1, there.heading, heading)
        lines.append(state.position.copy())
    return np.array(lines)


def same_places(one, other, within):
    gaps = np.hypot(*np.moveaxis(np.asarray(one)[:, None] - np.asarray(other)[None], -1, 0))
    return (gaps.min(axis=0) < within).all() and (gaps.min(axis=1) < within).all()


@pytest.mark.parametrize(
    "ripple", [Ripple(), Ripple(3, StartOrder.CENTRE), Ripple(3, StartOrder.RANDOM, Arrival.APART)]
)
@pytest.mark.parametrize("facing", list(Facing))
def test_all_dancers_arrive_on_the_measure_line(ripple, facing):
    evolve = Evolve("ring", orientation=Orientation(facing, headings=(0.5,)))
    running = plan(Segment(evolve, measures=2, ripple=ripple))
    lines = dance(running, 2)
    assert same_places(lines[-1], RING.slots, 0.01)
    target = running.predicted_state(8.0)
    slot = running.motions[0].motion.slot
    assert target.position == pytest.approx(RING.slots[slot], abs=1e-5)
    if facing is not Facing.DECLARED:
        assert shortest_turn(target.heading, RING.heading[slot]) == pytest.approx(np.zeros(A), abs=1e-5)
    assert running.state_at(20.0).position == pytest.approx(RING.slots[slot], abs=1e-5)  # the dancers stay


def test_pushed_dancers_still_arrive_on_time():
    push = np.random.default_rng(1).uniform(-0.4, 0.4, (A, 2)).astype(np.float32)
    assert same_places(dance(plan(Segment("to the ring", measures=2)), 2, push=push)[-1], RING.slots, 0.05)


def test_edited_formation_applies_to_segments_not_yet_started():
    running = plan(Segment(Hold("rows")), Segment("to the ring", start=2))
    running.prepare(2, START, np.zeros(A))
    running.repertoire = running.repertoire.with_formation(replace(RING, slots=RING.slots + 1.0))
    assert same_places(dance(running, 3)[-1], RING.slots + 1.0, 0.01)


def test_matching_by_id_gives_each_dancer_its_slot():
    lines = dance(plan(Segment(Evolve("ring", Matching(AssignmentMethod.ID)), measures=2)), 2)
    assert lines[-1] == pytest.approx(RING.slots, abs=0.02)


def test_end_state_of_groups_is_boundary_condition_of_next_segment():
    """Two groups end at different places; the next pause keeps them there and the next path starts there."""
    running = plan(
        Segment(Trajectory("curve"), "1-6"), Segment(Evolve("rows"), "7-12"), Segment(Pause(), start=1),
        Segment(Trajectory("curve"), start=2),
    )  # fmt: skip
    lines = dance(running, 3)
    assert lines[0][:6] == pytest.approx(START[:6] + CURVE[-1] - CURVE[0], abs=0.02)
    assert lines[1] == pytest.approx(lines[0], abs=0.02)
    assert lines[2] == pytest.approx(lines[1] + CURVE[-1] - CURVE[0], abs=0.03)


def test_single_file_keeps_gaps_along_path():
    line = [[-5.0, 3.0], [5.0, 3.0]]
    rep = REPERTOIRE.with_path("line", line)
    running = Plan(Roster.create(A), rep, [Segment(Trajectory("line", FollowMode.FILE, gap=0.7), measures=4)])
    x = np.sort(dance(running, 4)[-1][:, 0])
    assert np.diff(x) == pytest.approx(np.full(A - 1, 0.7), abs=0.02)
    assert x[-1] == pytest.approx(5.0, abs=0.02)


def test_canon_is_delayed_and_mirror_is_reflected():
    first = Segment(Trajectory("curve"), "1-6", measures=1)
    second = replace(first, group="7-12", delay=2.0)
    running = plan(first, second)
    running.begin_measure(0, START, np.zeros(A))
    early = running.state_at(2.5).position[0] - START[0]
    late = running.predicted_state(4.5).position[7] - START[7]
    assert late == pytest.approx(early, abs=1e-5)
    assert running.predicted_state(1.9).controlled.tolist() == [1] * 6 + [0] * 6
    motion = Segment(Trajectory("curve"), "1-6")
    image = replace(motion, group="7-12", mirror=Line())
    running = plan(motion, image)
    ends = dance(running, 1)[-1] - START
    assert ends[7:8] == pytest.approx(mirror_places(ends[:1], Line()), abs=0.02)
    ring = plan(Segment(Evolve("rows"), mirror=Line(1.0)))
    assert same_places(dance(ring, 1)[-1], mirror_places(ROWS.slots, Line(1.0)), 0.03)


def test_later_segments_replace_and_procedural_segments_release():
    running = plan(Segment(Hold("rows"), measures=4), Segment(Procedural(), "1-4", start=1), Segment(Pause(), "3", 2))
    dance(running, 1)
    running.begin_measure(1, START, np.zeros(A))
    assert running.state_at(5.0).controlled.tolist() == [0] * 4 + [1] * 8
    running.begin_measure(2, START, np.zeros(A))
    assert running.state_at(9.0).controlled.tolist() == [0, 0, 1, 0] + [1] * 8
    running.release(np.arange(A) >= 10)
    assert running.state_at(9.0).controlled.tolist() == [0, 0, 1, 0] + [1] * 6 + [0] * 2
    running.add(Segment(Hold("rows"), start=3))
    running.clear(np.arange(A) < 8)
    running.begin_measure(3, START, np.zeros(A))
    assert running.state_at(13.0).controlled.tolist() == [0] * 8 + [1] * 4


def test_live_segment_ends_on_a_measure_line():
    running = plan()
    running.begin_measure(0, START, np.zeros(A))
    (early,) = running.start_now(Segment(Evolve("ring")), 1.0, START, np.zeros(A))
    assert (early.begin, early.departure.end) == (1.0, 4.0)
    (late,) = running.start_now(Segment(Evolve("rows")), 2.5, running.state_at(2.5).position, np.zeros(A))
    assert (late.begin, late.departure.end) == (2.5, 8.0)
    assert running.motions == (late,)  # the first controls no dancer any more
    running.add(Segment("to the ring", start=1))
    running.begin_measure(1, running.state_at(4.0).position, np.zeros(A))
    assert same_places(running.predicted_state(8.0).position, RING.slots, 1e-4)


def test_large_group_is_planned_incrementally():
    count = MAX_IMMEDIATE_DANCERS + 60
    x, z = np.meshgrid(np.arange(16) * 0.7 - 5, np.arange(10) * 0.7 - 3)
    grid = np.stack([x.ravel(), z.ravel()], 1)[:count]
    rep = Repertoire().with_formation(Places("grid", grid * 0.9, np.zeros(count)))
    running = Plan(Roster.create(count), rep)
    running.begin_measure(0, grid, np.zeros(count))
    running.start_now(Segment(Evolve("grid")), 0.5, grid, np.zeros(count))
    assert not running.state_at(0.6).controlled.any()
    pieces = 0
    while not running.idle:
        running.work()
        pieces += 1
    assert pieces > 3
    assert running.state_at(0.6).controlled.all()
    running.start_now(Segment(Evolve("grid")), 0.7, grid, np.zeros(count))
    running.prepare(1, grid, np.zeros(count))
    assert not running.idle
    running.drop_incomplete()
    assert running.idle
    assert running.state_at(0.8).controlled.all()  # the completed earlier motion still controls the dancers
    running.add(Segment(Evolve("grid"), start=1))
    running.prepare(1, grid, np.zeros(count))
    assert not running.idle
    running.work()
    running.begin_measure(1, grid, np.zeros(count))
    assert running.predicted_state(8.0).position == pytest.approx(
        running.state_at(8.0).position
    )  # every dancer has a goal
    assert running.state_at(8.0).controlled.all()
    for _ in range(MAX_LATE_CALLS + 1):  # remaining repairs take at most this many calls
        running.work()
    assert running.idle


def test_paths_repaired_after_start_keep_their_ends():
    ring = 3.0 * np.stack([np.sin(np.arange(12) * np.pi / 6), np.cos(np.arange(12) * np.pi / 6)], 1)
    rep = Repertoire().with_formation(Places("across", -ring, np.zeros(12)))
    running = Plan(Roster.create(12), rep)
    across = Evolve("across", Matching(by=AssignmentMethod.ID))
    running.start_now(Segment(across), 0.0, ring, np.zeros(12))
    rough = running.motions[0].motion
    assert not running.idle
    assert not rough.checked
    while not running.idle:
        running.work()
    mended = running.motions[0].motion
    assert mended.checked
    assert mended.bent
    for beat, places in ((0.0, ring), (4.0, -ring)):
        assert running.state_at(beat).position == pytest.approx(places, abs=1e-5)
    running.finish()
    assert running.motions[0].motion is mended


def test_prepared_segment_starts_at_actual_positions():
    running = plan(Segment("to the ring", start=1))
    running.begin_measure(0, START, np.zeros(A))
    running.prepare(1, START, np.zeros(A))
    while not running.idle:
        running.work()
    foreseen = running.predicted_state(8.0).position.copy()
    assert not running.predicted_state(3.9).controlled.any()
    running.begin_measure(1, START + 0.2, np.zeros(A))
    assert running.predicted_state(4.0).position == pytest.approx(START + 0.2, abs=1e-5)
    assert running.predicted_state(8.0).position == pytest.approx(foreseen, abs=1e-5)


def test_soloist_takes_marked_slot_and_unplaced_dancers_stand_clear():
    marks = ("soloist", *[""] * 7)
    eight = Places("eight", RING.slots[:8], np.zeros(8), marks)
    roster = Roster.create(A, {12: ["soloist"]})
    running = Plan(roster, REPERTOIRE.with_formation(eight), [Segment(Evolve("eight"), measures=2)])
    end = dance(running, 2)[-1]
    assert end[11] == pytest.approx(eight.slots[0], abs=0.01)
    slot = running.motions[0].motion.slot
    assert sorted(slot) == [-1] * 4 + list(range(8))
    gaps = np.hypot(*np.moveaxis(end[:, None] - end[None], -1, 0)) + np.eye(A) * 9
    assert gaps[slot < 0].min() > 0.95


def test_edge_places_are_sufficient_and_separated_on_full_stage():
    for count in (0, 1, 30, 400):
        places = edge_places(count, START, RING.slots, half=(4.0, 3.0))
        assert len(places) == count
        every = np.concatenate([places, RING.slots])
        gaps = np.hypot(*np.moveaxis(places[:, None] - every[None], -1, 0))
        gaps[np.arange(count), np.arange(count)] = 9
        assert gaps.min(initial=9) > 0.99 if count else True


def test_unknown_names_are_refused_at_planning():
    for segment in (Segment("nothing"), Segment(Hold("nothing")), Segment(Trajectory("x")), Segment(Pause(), "who")):
        with pytest.raises(PersonError):
            plan().add(segment)
        with pytest.raises(PersonError):
            plan().start_now(segment, 0.0, START, np.zeros(A))
    with pytest.raises(PersonError, match="lasts at least one"):
        Segment(Pause(), measures=0)


def test_same_plan_gives_identical_positions():
    segments = (
        Segment(
            Evolve("ring", Matching(cost=Cost.EQUAL), PathMode.DIVIDED), measures=2, ripple=Ripple(2, StartOrder.RANDOM)
        ),
        Segment(Evolve("rows"), start=2),
    )
    assert (dance(plan(*segments, seed=5), 3) == dance(plan(*segments, seed=5), 3)).all()


def test_commands_allocate_nothing_per_tick():
    import tracemalloc

    running = plan(Segment("to the ring", measures=2))
    state, wants = AgentState.at_rest(START), AgentCommand(A)
    running.begin_measure(0, START, np.zeros(A))
    running.write_commands(wants, state, 0.1, 2.0)
    tracemalloc.start()
    before = tracemalloc.take_snapshot()
    for tick in range(200):
        running.write_commands(wants, state, 0.1 + tick / 32, 2.0)
    grown = sum(entry.size_diff for entry in tracemalloc.take_snapshot().compare_to(before, "filename"))
    tracemalloc.stop()
    assert grown < 20_000


def test_simulated_plan_reports_long_paths_and_collisions():
    segments = [
        Segment(Evolve("ring", Matching(AssignmentMethod.ID), PathMode.STRAIGHT)), Segment(Evolve("rows"), "1-6", 2, 4),
        Segment(Procedural(), "7-12", 3),
    ]  # fmt: skip
    done = simulate_plan(Roster.create(A), REPERTOIRE, segments, START, measures=6)
    ways = np.hypot(*(RING.slots - START).T)
    assert done.distances[0] == pytest.approx(ways, abs=1e-5)
    far = done.too_far(2.0)
    assert {(t.dancer, t.measure) for t in far} == {(int(d), 0) for d in np.flatnonzero(ways > 2.0)}
    assert done.too_near
    assert all(near.measure == 0 or near.second >= 6 for near in done.too_near)
    assert not done.under[3:, 6:].any()
    assert {link.source for link in done.links} == {-1, 0, 1, 2}
