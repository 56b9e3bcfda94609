"""Tests of drift correction of a capture suit by a tracker: low-pass response, speed bounds and use in a show."""

import math
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events import events
from live.motion.capture.packed_pose import pack_pose, unpack_pose
from live.motion.skeleton import JOINT_COUNT
from live.show.capture.pose_buffer import FAR_DISTANCE, LAG_S, MAX_SPEED, DriftCorrection
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter, read_journal
from live.show.journal.replay import first_start, run_from
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.status import Status
from tests.show.capture.test_mocap import MEASURE
from tests.show.made_show import GRAPH, PATCH, made_show

ANNA = '[[mocap]]\nname = "anna"\ntracker = "7"\n'
MM = 0.001


def standing_pose(x, z):
    """A packed pose of a performer who stands at (x, z)."""
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    return pack_pose([x, 0.935, z], rotation)


def run(show, first, last, suit, tracker):
    """Hip positions after each tick, (T, 2) [m]; `suit` and `tracker` map a tick to a position or None."""
    view, seen = show.view(), []
    for tick in range(first, last + 1):
        time = tick * TICK
        if (place := tracker(tick)) is not None:
            x, z = place
            show.apply(events.TrackerMoved(time=time - 0.006, source="psn", tracker="7", x=x, y=1.0, z=z))
        if (place := suit(tick)) is not None:
            show.apply(events.MocapFrame(time=time - 0.004, source="vmc", performer="anna", pose=standing_pose(*place)))
        show.tick(time)
        show.fill(view, time)
        seen.append(view.joint_position[0, 0, ::2].copy())
    return np.array(seen)


def constant_place(*place):
    return lambda tick: place


def offsets_over_ticks(anchor, count):
    """The offset after each of `count` ticks, (T, 2) [m]."""
    found = []
    for _ in range(count):
        anchor.tick()
        found.append(anchor.offset)
    return np.array(found)


def test_step_response_matches_two_low_passes():
    anchor = DriftCorrection()
    anchor.set_difference((0.3, -0.2), (0.0, 0.0))
    found = offsets_over_ticks(anchor, round(3.0 / TICK))
    time = TICK * np.arange(1, len(found) + 1)
    # the answer of 1 / (1 + s LAG / 2)^2 to a step
    expected = 1.0 - (1.0 + 2.0 * time / LAG_S) * np.exp(-2.0 * time / LAG_S)
    np.testing.assert_allclose(found, expected[:, None] * (0.3, -0.2), atol=0.005)


@pytest.mark.parametrize("far", [0.5, 2.0, 6.0, 20.0])
def test_correction_is_limited_to_walking_speed_unless_far(far):
    anchor = DriftCorrection()
    anchor.set_difference((far, 0.0), (0.0, 0.0))
    found = offsets_over_ticks(anchor, round(12.0 / TICK))[:, 0]
    speed, left = np.diff(found) / TICK, far - found[:-1]
    assert (speed >= -1e-12).all()
    assert (speed <= MAX_SPEED * np.maximum(1.0, (left / FAR_DISTANCE) ** 2) + 1e-9).all()
    assert speed.max() <= 0.74 * far
    assert left[-1] < 0.01


@pytest.mark.long
def test_drifting_suit_stays_at_tracker_and_tracker_noise_is_suppressed():
    show = made_show(ANNA)
    drifts = run(show, 1, 15 * 64, lambda tick: (0.1 * tick * TICK, 0.5), constant_place(1.0, -1.0))
    off = np.hypot(*(drifts[MEASURE + 20 :] - (1.0, -1.0)).T)
    assert off.max() < 0.1 * LAG_S + 0.01  # the lag of the low-passes, and what is shown later than it came
    chance = np.random.default_rng(5)
    show = made_show(ANNA)
    # 60 places a second, 64 ticks: a sixteenth of these hears of none
    noise = run(
        show, 1, 60 * 64, constant_place(0.3, 0.2), lambda tick: chance.normal(0.0, 0.05, 2) if tick % 16 else None
    )[4 * MEASURE :]
    assert noise.std(axis=0).max() < 7 * MM
    assert np.abs(noise - noise.mean(axis=0)).max() < 25 * MM
    assert np.abs(noise.mean(axis=0)).max() < 5 * MM
    speed = np.diff(noise, axis=0) / TICK
    assert speed.std() < 0.02


@pytest.mark.long
def test_new_performer_starts_at_tracker_position():
    show = made_show(ANNA)
    begun = show.dancers.drawn_hips[0].copy()
    seen = run(show, 1, 2 * MEASURE, constant_place(-4.0, 3.0), constant_place(1.0, -1.0))
    np.testing.assert_allclose(seen[MEASURE + 10 :], np.broadcast_to((1.0, -1.0), (MEASURE - 10, 2)), atol=2 * MM)
    assert np.abs(np.diff(seen, axis=0)).max() / TICK < 1.6 * np.abs(begun - (1.0, -1.0)).max()


@pytest.mark.long
def test_stale_tracker_holds_offset_and_returning_tracker_corrects_smoothly():
    show, end = made_show(ANNA), 12 * 64
    silent, back = range(4 * 64, 8 * 64), 8 * 64
    tracker = lambda tick: None if tick in silent else (1.0, -1.0) if tick < back else (3.0, -1.0)  # noqa: E731
    seen = run(show, 1, end, constant_place(0.0, 0.0), tracker)
    held = seen[silent.start : back - 1]
    np.testing.assert_allclose(held, np.broadcast_to((1.0, -1.0), held.shape), atol=2 * MM)
    speed = np.diff(seen[MEASURE + 20 :, 0]) / TICK
    assert MAX_SPEED / 2 < speed.max() < MAX_SPEED + 0.02
    np.testing.assert_allclose(seen[-1], (3.0, -1.0), atol=0.02)
    facts = show.mocap.facts(show.time)["anna"]
    assert (facts["tracker"], facts["corrected_m"][0]) == ("7", pytest.approx(3.0, abs=0.02))


@pytest.mark.long
def test_suit_motion_counts_while_tracker_is_silent():
    show = made_show(ANNA)
    run(show, 1, 4 * 64, constant_place(0.0, 0.0), constant_place(1.0, -1.0))
    walks = run(show, 4 * 64 + 1, 7 * 64, lambda tick: (0.5 * (tick * TICK - 4.0), 0.0), lambda tick: None)
    # at 40 ms later; while a silence is not one yet, nothing is compared
    np.testing.assert_allclose(walks[-1], (1.0 + 0.5 * (3.0 - 0.044 + 0.004), -1.0), atol=5 * MM)


@pytest.mark.long
def test_capture_floor_and_tracker_axes_follow_patch():
    extra = 'at = [0.5, 0.0]\nturn_deg = 90\nmirrored = true\n[psn]\naxes = "-y x"\n'
    show = made_show(ANNA + extra)
    show.apply(events.TrackerMoved(time=0.01, source="psn", tracker="7", x=0.4, y=0.3, z=9.0))
    seen = run(show, 1, 2 * MEASURE, constant_place(-4.0, 3.0), lambda tick: (0.4, 0.3))
    # of the tracker's (0.4, y = 1.0) the floor has (-1.0, 0.4), mirrored (1.0, 0.4), turned to +x (0.4, -1.0)
    np.testing.assert_allclose(seen[-1], (0.5 + 0.4, -1.0), atol=3 * MM)


@pytest.mark.long
def test_performer_without_tracker_returns_to_suit_position():
    show = made_show(ANNA)
    run(show, 1, 4 * 64, constant_place(0.0, 0.0), constant_place(1.0, -1.0))
    fresh = show.hot_swap.make_show(parse_patch(PATCH + '[[mocap]]\nname = "anna"\n', "test.toml"), GRAPH)
    show.mocap.apply_patch(fresh.mocap)
    seen = run(show, 4 * 64 + 1, 10 * 64, constant_place(0.0, 0.0), lambda tick: None)
    assert np.hypot(*np.diff(seen, axis=0).T).max() / TICK < MAX_SPEED + 0.02
    np.testing.assert_allclose(seen[-1], (0.0, 0.0), atol=5 * MM)


def test_restored_show_continues_correction_bit_identically():
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH + ANNA, "test.toml"), GRAPH)
    show, tick = loaded.start(), MEASURE + 20
    drift, place = (lambda tick: (0.1 * tick * TICK, 0.5)), (lambda tick: (math.sin(tick * TICK), 1.0))
    run(show, 1, tick, drift, place)
    source = Snapshotter(show)
    while (taken := source.capture(tick)) is None:
        tick += 1
        run(show, tick, tick, drift, place)
    restored = restore(loaded, taken.seal())
    seen = [run(each, tick + 1, tick + 80, drift, place) for each in (show, restored)]
    np.testing.assert_array_equal(*seen)
    assert restored.state_hash() == show.state_hash()


@pytest.mark.long
def test_replay_of_suit_and_tracker_is_bit_identical(tmp_path):
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH + ANNA + 'canon = "back"\n', "test.toml"), GRAPH)
    show, clock, inbox = loaded.start(), ManualClock(), EventQueue()
    writer = JournalWriter(tmp_path / "a.jsonl", {"seed": 3, "tempo": None})
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    engine, lane = Engine(show, clock=clock, inbox=inbox, status=status, journal=writer), inbox.add_queue()
    for number in range(1, 241):
        now = number / 40.0
        if not 120 < number < 160:
            lane.put(events.TrackerMoved(time=now - 0.01, source="psn", tracker="7", x=math.sin(now), y=1.0, z=1.0))
        pose = standing_pose(0.1 * now, 0.5 * math.cos(now))
        lane.put(events.MocapFrame(time=now - 0.005, source="vmc", performer="anna", pose=pose))
        clock.set(now)
        engine.frame(lambda view: None)
    writer.close(engine.ticks.index)
    assert abs(show.mocap.performers["anna"].drift_correction.offset[0]) > 0.1
    journal = read_journal(tmp_path / "a.jsonl")
    start = first_start(journal, loaded)
    assert run_from(start, journal).different == 0
    assert start.show.state_hash() == show.state_hash()


def test_unknown_or_shared_trackers_are_refused_with_line():
    listed = '[psn]\ntrackers = ["7", "Anna"]\n'
    assert parse_patch(PATCH + listed + ANNA, "test.toml").mocap[0].tracker == "7"
    with pytest.raises(PersonError, match=r"(?s)test\.toml.*line 26.*tracker.*'8'.*7, Anna"):
        parse_patch(PATCH + listed + ANNA.replace('"7"', '"8"'), "test.toml")
    with pytest.raises(PersonError, match=r"(?s)line 27.*ben.*'7' is already 'anna'"):
        parse_patch(PATCH + ANNA + '[[mocap]]\nname = "ben"\ntracker = "7"\n', "test.toml")
    with pytest.raises(PersonError, match=r"(?s)line 26.*ben.*'anna' is already 'anna'"):
        parse_patch(PATCH + ANNA.replace('tracker = "7"\n', "") + '[[mocap]]\nname = "ben"\ntracker = "anna"\n', "t")


def test_packed_pose_is_precise_enough():
    assert abs(unpack_pose(standing_pose(1.2345, -0.5))[0][0] - 1.2345) < 1e-4
