"""Interrupts: cues act on the half beat without a jump, the dance continues on the graph, collisions take priority."""

import re

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import Performer, StepNow
from live.show.assembly import assemble
from live.show.loader import load_show
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import find_patch
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, PATCH, made_show

BEAT = 0.5  # s at 120 bpm
MEASURE = 2.0


def tick_before(time):
    """The last tick not after `time`."""
    return int(time / TICK + 1e-9)


def run(show, first, last, each=lambda number: None):
    for number in range(first, last + 1):
        show.tick(number * TICK)
        each(number)


def unlocked_joints(show):
    """All joints now, without foot lock: the made figures slide on straight legs, which the foot lock does not hide."""
    everybody = np.arange(len(show.group), dtype=np.int32)
    return show.dancers.raw_poses(everybody, show.span.fraction(show.timeline.beat_at(show.time)), show.time)[0].copy()


def largest_jump(poses):
    """The largest change of a joint's speed from tick to tick [m/s]: 0.8 is a jump of the pose by 12 mm."""
    speed = np.diff(np.array(poses), axis=0) / TICK
    return np.linalg.norm(np.diff(speed, axis=0), axis=-1).max()


def step_cue(time, name="spin", **more):
    return StepNow(time=time, source="test", name=name, **more)


def steps_of(show):
    """The name of each dancer's current step."""
    library = show.graph.library
    return [library.steps[step] for step in library.node_step[show.dancers.node]]


def test_cue_acts_at_next_half_beat_on_its_group_only():
    show = made_show()
    run(show, 1, tick_before(3.1))
    before = steps_of(show)
    assert show.apply(step_cue(3.1, group="front"))
    changed = []
    run(show, tick_before(3.1) + 1, tick_before(3.4), lambda number: changed.append(steps_of(show) != before))
    at = tick_before(3.1) + 1 + changed.index(True)
    assert at == tick_before(3.25 + TICK / 2)
    now = steps_of(show)
    assert now[:5] == ["spin"] * 5
    assert now[5:] == before[5:]
    assert show.interrupts.cue_count == 1


@mostly_long("time", [4.02, 4.6, 5.2, 5.55, 5.8, 5.98], quick=[1])
def test_joints_stay_continuous_and_dance_follows_graph_after_cue(time):
    """For cues anywhere in the measure, with the next one planned or not: joint speeds stay continuous, and
    every measure is a valid successor.
    """
    show = made_show()
    run(show, 1, tick_before(time))
    poses = [unlocked_joints(show)]
    nodes = [show.dancers.node.copy()]
    cut = set()
    show.apply(step_cue(time, measures=2.0))

    def each(number):
        poses.append(unlocked_joints(show))
        if (show.dancers.node != nodes[-1]).any():
            nodes.append(show.dancers.node.copy())
            cut.add(len(nodes) - 1) if show.interrupts.clip_cutter.cuts and not cut else None

    run(show, tick_before(time) + 1, tick_before(time + 3 * MEASURE), each)
    assert largest_jump(poses) < 0.8
    graph = show.graph
    for index in range(1, len(nodes)):
        if index in cut:
            continue
        for one, then in zip(nodes[index - 1], nodes[index], strict=True):
            follows = graph.edge_target[graph.edge_start[one] : graph.edge_start[one + 1]]
            assert one == then or then in follows
    assert "spin" in steps_of(show) or show.span.number > int(time / MEASURE) + 2


@pytest.mark.long
def test_cued_group_keeps_step_for_given_measures():
    swaying = re.sub(r"\nsteps = .*", '\nsteps = ["sway"]', re.sub(r"travel_step = .*\n", "", PATCH))
    show = assemble(parse_patch(swaying, "test.toml"), GRAPH)
    run(show, 1, tick_before(4.6))
    show.apply(step_cue(4.6, measures=2.0))
    found = {}
    run(
        show, tick_before(4.6) + 1, tick_before(12.5), lambda number: found.setdefault(show.span.number, steps_of(show))
    )
    assert set(found[3]) == set(found[4]) == {"spin"}
    assert set(found[2]) == {"sway"}
    assert "spin" not in found[5]


def test_cue_after_measure_decision_sets_next_measure():
    """The next measure is already decided when the cue acts."""
    show = made_show()
    run(show, 1, tick_before(5.6))
    assert show.dancers.decided
    show.apply(step_cue(5.6, measures=1.0))
    run(show, tick_before(5.6) + 1, tick_before(6.1))
    assert set(steps_of(show)) == {"spin"}


@pytest.mark.parametrize(
    ("event", "words"),
    [(step_cue(1.0, "pirouette"), "no step is called 'pirouette'"), (step_cue(1.0, group="nobody"), "nobody")],
)
def test_unknown_step_or_group_is_refused_with_reason(event, words):
    show = made_show()
    run(show, 1, 64)
    assert not show.apply(event)
    assert words in show.refusals.last_reason
    run(show, 65, 128)
    assert show.interrupts.clip_cutter.cuts == 0


def test_replayed_cues_are_bit_identical():
    events = [
        (100, step_cue(1.6)),
        (160, step_cue(2.5, "glide", group="back", measures=0.0)),
        (177, step_cue(2.8, "phrase")),
    ]

    def danced():
        show = made_show()
        hashes = []
        for number in range(1, 500):
            show.tick(number * TICK)
            hashes.append(show.state_hash() if number % 20 == 0 else "")
            for at, event in events:
                if at == number:
                    show.apply(event_from_json(event_to_json(event)))
        assert show.interrupts.cue_count == 3
        return hashes

    assert danced() == danced()


@pytest.mark.long
def test_canon_group_is_cut_in_its_own_measure():
    """A canon by two beats: in the first half of a measure its dancers are still in the previous one."""
    show = made_show('[[group]]\nname = "late"\ndancers = 3\nlike = "front"\nbeats_later = 2.0\n')
    run(show, 1, tick_before(6.1))
    poses = []
    show.apply(step_cue(6.1, group="late"))

    def each(number):
        poses.append(unlocked_joints(show))

    run(show, tick_before(6.1) + 1, tick_before(9.0), each)
    assert show.interrupts.clip_cutter.cuts - show.interrupts.avoidance_count == 3
    assert largest_jump(poses) < 0.8


def walk_performer_through(*, careful):
    """The smallest distance [m] from a performer, who walks along the front row, to any dancer."""
    show = made_show()
    if not careful:
        show.interrupts._collision_avoidance.tick = lambda *arguments: None
    nearest = []

    def each(number):
        time = number * TICK
        place = np.array([-6.0 + 1.2 * (time - 2.0), 1.5])
        if time >= 2.0:
            show.apply(Performer(time=time, source="camera", name="ann", x=float(place[0]), z=float(place[1])))
            nearest.append(np.hypot(*(show.dancers.drawn_hips - place).T).min())

    run(show, 1, tick_before(12.0), each)
    return min(nearest), show.interrupts.avoidance_count


@pytest.mark.long
def test_dancers_avoid_a_tracked_performer():
    with_care, avoided = walk_performer_through(careful=True)
    without, none = walk_performer_through(careful=False)
    assert avoided > 0 == none
    assert with_care > without + 0.05


@pytest.mark.long
def test_no_clip_is_cut_without_events():
    show = made_show()
    run(show, 1, tick_before(8.0))
    assert show.interrupts.clip_cutter.cuts == show.interrupts.avoidance_count == 0


@pytest.mark.long
def test_frames_between_ticks_do_not_change_state():
    """A cut dancer settles for about 26 ticks; a frame drawn late in the last of them must not end that early."""
    loaded = load_show(find_patch("score"))
    steps = loaded.graph.library.steps
    unseen, seen = loaded.start(seed=5), loaded.start(seed=5)
    view = seen.view()
    for number in range(1, 640):
        time = number * TICK
        happens = []
        for person in range(2 if number % 4 == 0 else 0):
            angle = 1.3 * time * (1 - 2 * person) + person
            x, z = 2.2 * float(np.sin(angle)), 1.5 * float(np.cos(1.7 * angle))
            happens.append(Performer(time=time, source="test", name=f"p{person}", x=x, z=z))
        if number % 41 == 0:
            happens.append(step_cue(time, steps[number // 41 % len(steps)], group="all", measures=0.0))
        for event in happens:
            unseen.apply(event)
            seen.apply(event)
        unseen.tick(time)
        seen.tick(time)
        seen.fill(view, time + 0.95 * TICK)
        assert np.array_equal(seen.dancers.inertia.cut_time, unseen.dancers.inertia.cut_time), number
    assert unseen.interrupts.clip_cutter.cuts > 100
    assert seen.state_hash() == unseen.state_hash()
