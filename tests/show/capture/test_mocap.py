"""Tests of captured performers: pose, dropout, canon, mirroring, trackers, snapshots and replay."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events import events
from live.motion import quaternion
from live.motion.capture.packed_pose import pack_pose, unpack_pose
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_clip
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.show.capture.performer import HOLD_S
from live.show.dancers.footfalls import FootfallDetector
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter, read_journal
from live.show.journal.replay import first_start, run_from
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import PatchError, parse_patch
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.status import Status
from tests.show.made_show import GRAPH, PATCH, made_show

MEASURE = round(2.0 / TICK)
"""Ticks of a measure: four beats of 120 bpm."""


def pose(time):
    """A packed pose of a performer who walks in a circle and waves."""
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    arm, angle = SKELETON.index("leftUpperArm"), 0.8 * math.sin(3.0 * time)
    rotation[arm] = math.cos(angle), 0.0, 0.0, math.sin(angle)
    rotation[0] = math.cos(0.2 * time), 0.0, math.sin(0.2 * time), 0.0
    return pack_pose([1.0 + 0.5 * math.sin(time), 0.93, 0.5 * math.cos(time)], rotation)


def frame(time, name="live"):
    return events.MocapFrame(time=time, source="vmc", performer=name, pose=pose(time))


def run(show, first, last, silent=lambda tick: False, name="live"):
    """Joints of all dancers after each tick, (T, A, J, 3); a pose arrives before each tick that is not `silent`."""
    view, seen = show.view(), []
    for tick in range(first, last + 1):
        if not silent(tick):
            show.apply(frame(tick * TICK - 0.004, name))
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        seen.append(view.joint_position.copy())
    return np.array(seen)


def joints_at(time):
    """Joint positions of the packed pose at `time`, (J, 3)."""
    root, rotation = unpack_pose(pose(time))
    return forward_kinematics(root[None], rotation[None])[0][0]


def performer(extra="", name="anna"):
    return f'[[mocap]]\nname = "{name}"\n{extra}\n'


def test_dancer_and_agent_match_captured_pose_and_position():
    show = made_show()
    seen = run(show, 1, MEASURE + 20)
    delay = show.mocap.performers["live"].display_delay
    for tick in (MEASURE + 2, MEASURE + 20):
        np.testing.assert_allclose(seen[tick - 1, 0], joints_at(tick * TICK - delay), atol=2e-3)
    np.testing.assert_allclose(show.state.position[0], seen[-1, 0, 0, ::2], atol=2e-3)
    assert np.abs(seen[-1, 1:, 0] - seen[-1, 0, 0]).max() > 0.5
    assert show.mocap.facts(show.time)["live"]["seen"] == [1.0]
    assert show.motion.model.responsibility[0] == 0.0
    assert show.refusals.count == 0


@pytest.mark.long
def test_dropout_holds_pose_then_blends_out_and_back_without_pop():
    show = made_show()
    begin = MEASURE + 40
    gap = range(begin, begin + 2 * MEASURE)
    seen = run(show, 1, gap[-1] + MEASURE + 10, silent=lambda tick: tick in gap)
    held = round(HOLD_S / TICK)
    last = seen[begin - 2 + 3, 0]  # the delay passes first
    np.testing.assert_allclose(seen[begin + held - 4, 0], last, atol=1e-3)
    share = show.mocap.performers["live"]
    assert share.fade[0] == 1.0
    own = seen[begin + held + MEASURE + 10 : gap[-1], 0]
    assert np.ptp(own[:, 0, 0]) < 0.5  # the dancer continues at the last position
    np.testing.assert_allclose(own[0, 0, ::2], last[0, ::2], atol=0.3)
    speed = np.linalg.norm(np.diff(seen[MEASURE:, 0], axis=0), axis=-1).max(axis=1) / TICK
    usual = np.linalg.norm(np.diff(seen[:, 1:], axis=0), axis=-1).max() / TICK
    assert speed.max() < 2.0 * usual
    assert np.abs(np.diff(seen[MEASURE:, 0, 0], axis=0)).max() < 0.03


@pytest.mark.long
def test_short_gap_is_caught_up_smoothly():
    show = made_show("[motion]\narm_clearance = 0.0\n")  # the arm is shown as it was captured
    gap = range(MEASURE + 40, MEASURE + 52)
    seen = run(show, 1, gap[-1] + 60, silent=lambda tick: tick in gap)
    speed = np.linalg.norm(np.diff(seen[MEASURE:, 0], axis=0), axis=-1).max(axis=1) / TICK
    assert speed.max() < 2.0 * speed[:30].max()
    np.testing.assert_allclose(
        seen[-1, 0], joints_at(show.time - show.mocap.performers["live"].display_delay), atol=2e-3
    )


@pytest.mark.long
def test_rendering_does_not_change_state():
    show, other = made_show(), made_show()
    view = show.view()
    for tick in range(1, MEASURE + 80):
        for each in (show, other):
            if tick % 3:
                each.apply(frame(tick * TICK - 0.004))
            each.tick(tick * TICK)
        for ahead in (0.3, 0.9, 0.6):
            show.fill(view, (tick + ahead) * TICK)
    assert show.state_hash() == other.state_hash()


def test_mirrored_performer_matches_mirrored_clip():
    show = made_show(performer("mirrored = true\nat = [0.5, -1.0]\nturn_deg = 90"))
    seen = run(show, 1, MEASURE + 10, name="anna")
    when = show.time - show.mocap.performers["anna"].display_delay
    root, rotation = unpack_pose(pose(when))
    clip = mirror_clip(Clip("pose", root[None], rotation[None], 60.0, np.zeros((1, 2), np.bool_)))
    expected = forward_kinematics(clip.root_position, clip.rotation)[0][0]
    turned = quaternion.rotate(quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(math.pi / 2)), expected)
    np.testing.assert_allclose(seen[-1, 0], turned + np.array([0.5, 0.0, -1.0]), atol=3e-3)


@pytest.mark.long
def test_performer_switches_to_mirror_image_without_pop():
    show = made_show(performer())
    seen = [run(show, 1, MEASURE + 20, name="anna")]
    for number, mirrored in enumerate((True, False)):
        show.apply(events.MirrorMocap(time=show.time, source="osc", performer="anna", mirrored=mirrored))
        first = MEASURE + 21 + 60 * number
        seen.append(run(show, first, first + 59, name="anna"))
    speed = np.linalg.norm(np.diff(np.concatenate(seen)[MEASURE:, 0], axis=0), axis=-1).max(axis=1) / TICK
    # hips that go 2.9 m aside within 0.6 s go 7 m/s in the middle, hands that change sides a bit faster
    assert speed.max() < 14.0
    np.testing.assert_allclose(
        seen[-1][-1, 0], joints_at(show.time - show.mocap.performers["anna"].display_delay), atol=2e-3
    )


@pytest.mark.long
def test_canon_group_repeats_performer_in_sequence():
    show = made_show(performer('dancer = "back & 6"\ncanon = "front & 1-2"\ncanon_beats = 2.0'))
    seen = run(show, 1, 4 * MEASURE, name="anna")
    own, beat = seen[:, 5], MEASURE // 4
    own = own - own[:, :1] * [1.0, 0.0, 1.0]
    later = round(show.mocap.performers["anna"].display_delay / TICK)
    for dancer, beats in ((0, 2), (1, 4)):
        repeated = seen[:, dancer] - seen[:, dancer, :1] * [1.0, 0.0, 1.0]
        np.testing.assert_allclose(repeated[-20:], own[-20 - beats * beat + later : -beats * beat + later], atol=0.02)
    ways = (
        np.diff(seen[[-200, -1], 0, 0, ::2], axis=0),
        np.diff(seen[[-200 - 2 * beat, -1 - 2 * beat], 5, 0, ::2], axis=0),
    )
    np.testing.assert_allclose(ways[0], ways[1], atol=0.05)
    show.apply(events.CanonMocap(time=show.time, source="osc", performer="anna", group="none"))
    run(show, 4 * MEASURE + 1, 5 * MEASURE + 40, name="anna")
    assert show.mocap.facts(show.time)["anna"]["dancers"] == [6]


@pytest.mark.long
def test_performer_can_be_recast_or_hidden():
    show = made_show(performer() + performer(name="ben"))
    for tick in range(1, MEASURE):
        for name in ("anna", "ben"):
            show.apply(frame(tick * TICK - 0.004, name))
        show.tick(tick * TICK)
    told = show.mocap.facts(show.time)
    assert (told["anna"]["dancers"], told["ben"]["dancers"]) == ([1], [2])
    show.apply(events.CastMocap(time=show.time, source="osc", performer="anna", dancer="back"))
    show.apply(events.ShowMocap(time=show.time, source="osc", performer="ben", shown=False))
    run(show, MEASURE, 2 * MEASURE + 20, name="anna")
    told = show.mocap.facts(show.time)
    assert (told["anna"]["dancers"], told["ben"]["dancers"]) == ([6], [])
    assert show.motion.model.responsibility[[0, 1, 5]].tolist() == [1.0, 1.0, 0.0]


@pytest.mark.long
def test_performer_without_dancer_can_be_obstacle_and_attractor():
    show = made_show(performer('dancer = "none"\nobstacle = true\nattract = 1.0\nattracts = "front"'))
    run(show, 1, 40, name="anna")
    assert show.motion.surroundings.obstacle_names == ("performer anna",)
    (element,) = show.motion.elements.in_force
    assert math.dist(element.points[0], show.mocap.performers["anna"].position(show.time)) < 0.1
    show.apply(events.DrawMocap(time=show.time, source="osc", performer="anna", strength=-1.0))
    run(show, 41, 200, name="anna")
    assert [each.kind for each in show.motion.elements.in_force] != [element.kind]
    run(show, 201, 201 + 3 * MEASURE, silent=lambda tick: True)
    assert not show.motion.elements.in_force
    assert show.motion.surroundings.obstacle_names == ()


@pytest.mark.long
def test_footfalls_follow_captured_feet_instead_of_dancer_clip():
    show = made_show()
    falls, view, ears = [], show.view(), FootfallDetector(show)
    legs = [SKELETON.index(name) for name in ("leftUpperLeg", "leftLowerLeg", "leftFoot")]
    for tick in range(1, 2 * MEASURE + 130):
        time = tick * TICK - 0.004
        bend = 0.5 * max(math.sin(2.0 * math.pi * time), 0.0)  # the left foot comes down on every half second
        rotation = np.zeros((JOINT_COUNT, 4))
        rotation[:, 0] = 1.0
        for joint, angle in zip(legs, (-bend, 2.0 * bend, -bend), strict=True):
            rotation[joint] = math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0
        packed = pack_pose([0.0, 0.935, 0.0], rotation)
        show.apply(events.MocapFrame(time=time, source="vmc", performer="live", pose=packed))
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        falls += [fall for fall in ears.detect(view) if fall.dancer == 0 and fall.time > 4.2]
    assert {fall.foot for fall in falls} == {0}
    later = show.mocap.performers["live"].display_delay
    landed = [fall.time - later for fall in falls]  # heel and ball come down one after the other
    assert {round(time) for time in np.array(landed) + 0.5} == {5, 6}
    assert landed == pytest.approx([round(time + 0.5) - 0.5 for time in landed], abs=0.1)


def tracker_event(time, name, x, z):
    return events.TrackerMoved(time=time, source="psn", tracker=name, x=x, y=1.0, z=z)


@pytest.mark.long
def test_tracker_moves_patch_performer_or_becomes_obstacle():
    extra = performer('dancer = "front & 2"\nattract = 1.0\nattracts = "back"\nat = [0.5, 0.0]', name="Anna")
    show = made_show(extra + performer(name="Ben") + '[psn]\naxes = "-x z"\n')
    begin = show.state.position[1].copy()
    for tick in range(1, 3 * MEASURE):
        if tick % 2:
            way = min(tick / MEASURE, 1.0)
            for name, x, z in (("Anna", -begin[0] + 0.5 - way, begin[1]), ("Ben", 1.0, 1.0), ("chariot", 2.0, 0.0)):
                show.apply(tracker_event(tick * TICK - 0.004, name, x, z))
        show.tick(tick * TICK)
    np.testing.assert_allclose(show.state.position[1], begin + np.array([1.0, 0.0]), atol=1e-3)
    # the dancer follows by clip steps, which travel 0.3 m per measure
    assert np.hypot(*(show.dancers.drawn_hips[1] - begin)) > 0.2
    assert show.motion.model.responsibility[:3].tolist() == [1.0, 0.0, 1.0]
    assert list(show.motion.surroundings.obstacle_names) == ["performer chariot"]
    place = show.motion.surroundings.obstacles[0][:2]
    np.testing.assert_allclose(place, [-2.0, 0.0])
    (element,) = show.motion.elements.in_force
    assert math.dist(element.points[0], begin + np.array([1.0, 0.0])) < 0.05
    assert show.mocap.facts(show.time)["Anna"]["dancers"] == [2]
    assert show.mocap.facts(show.time)["Ben"]["dancers"] == []
    for tick in range(3 * MEASURE, 3 * MEASURE + 40):
        show.tick(tick * TICK)
    assert show.motion.model.responsibility[1] == 1.0
    assert show.mocap.facts(show.time)["Anna"]["dancers"] == []


def test_invalid_frames_and_casts_are_refused_and_counted():
    show = made_show(performer())
    damaged = events.MocapFrame(time=0.1, source="vmc", performer="anna", pose="!" * 192)
    assert not show.apply(damaged)
    assert not show.apply(frame(0.1, "nobody"))
    assert not show.apply(events.CastMocap(time=0.1, source="osc", performer="anna", dancer="dancers unheard of"))
    assert show.refusals.count == 3
    assert not made_show().apply(frame(0.1, "nobody"))
    with pytest.raises(PatchError, match="anna"):
        parse_patch(PATCH + performer() + performer(), "test.toml")
    with pytest.raises(Exception, match="anna"):
        made_show(performer('canon = "unheard of"'))


@pytest.mark.long
def test_edited_patch_keeps_captured_performer():
    patches = [parse_patch(PATCH + performer(f"mirrored = {each}"), "test.toml") for each in ("false", "true")]
    show = made_show(performer("mirrored = false"))
    run(show, 1, MEASURE + 10, name="anna")
    fresh = show.hot_swap.make_show(patches[1], GRAPH)
    show.mocap.apply_patch(fresh.mocap)
    (captured,) = show.mocap.performers.values()
    assert captured.mirrored
    assert captured.fade.tolist() == [1.0]
    assert show.dancers.captured is show.mocap.performers


CANON = performer('dancer = "front & 2"\ncanon = "back"\nattract = 0.5\nattracts = "front"')
LOADED = LoadedShow(Path("test.toml"), parse_patch(PATCH + CANON, "test.toml"), GRAPH)


@pytest.mark.long
def test_restored_show_continues_capture_bit_identically():
    show = LOADED.start()
    tick, source = MEASURE + 20, Snapshotter(show)
    run(show, 1, tick, name="anna")
    while (taken := source.capture(tick)) is None:
        tick += 1
        run(show, tick, tick, name="anna")
    restored = restore(LOADED, taken.seal())
    for each in (show, restored):
        run(each, tick + 1, tick + 80, silent=lambda at: at > tick + 40, name="anna")
    assert restored.state_hash() == show.state_hash()


@pytest.mark.long
def test_journal_replay_of_capture_is_bit_identical(tmp_path):
    show, clock, inbox = LOADED.start(), ManualClock(), EventQueue()
    writer = JournalWriter(tmp_path / "a.jsonl", {"seed": 3, "tempo": None})
    engine = Engine(
        show, clock=clock, inbox=inbox, status=Status(show, rejected=dict, memory=lambda: 0.0), journal=writer
    )
    lane = inbox.add_queue()
    for number in range(1, 141):
        for part in (0.25, 0.75):  # a capture faster than the frames: the newest alone is taken
            lane.put(frame((number - part) / 40.0, "anna"), ("mocap", "anna"))
        clock.set(number / 40.0)
        engine.frame(lambda view: None)
    writer.close(engine.ticks.index)
    lines = [json.loads(line) for line in (tmp_path / "a.jsonl").read_text().splitlines()]
    assert sum("event" in line for line in lines) == 140
    assert engine._status.events_accepted == 0
    journal = read_journal(tmp_path / "a.jsonl")
    start = first_start(journal, LOADED)
    assert run_from(start, journal).different == 0
    assert start.show.state_hash() == show.state_hash()
