"""Tests of canon bounds: dancers who repeat a captured performer stay on the stage; paths bend only at the edge."""

import math

import numpy as np
import pytest

from live.agents.crowd.contact_kernels import EDGE_TIME
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.capture.packed_pose import pack_pose
from live.motion.skeleton import JOINT_COUNT
from live.show.capture.stage_presence import MAX_RETURN_SPEED, CanonBounds
from tests.fixtures.mostly_long import mostly_long
from tests.show.capture.test_mocap import MEASURE, performer, run
from tests.show.made_show import made_show

ALL = np.ones(1, np.bool_)
FLOOR = (0.0,)


def bounded_path(path, half=(5.0, 3.0)):
    """Bounded positions (T, 2) of a dancer whose unbounded path is (T, 2) [m], one row per tick."""
    edges, moved, found = CanonBounds(np.array(half)), np.zeros((1, 2)), []
    edges.add(path[:1])
    for tick, there in enumerate(path):
        moved += edges.update(there[None] + moved, tick * TICK, FLOOR, ALL)
        found.append((there + moved)[0])
    return np.array(found)


def random_path(chance, time, reach, fastest):
    """A smooth random path (T, 2) [m], within `reach` (2,) of the center and no faster than `fastest` [m/s]."""
    rate, phase = chance.uniform(0.02, 0.12, (4, 2)), chance.uniform(0.0, 2.0 * math.pi, (4, 2))
    way = np.sin(2.0 * math.pi * rate * time[:, None, None] + phase).sum(axis=1)
    way *= np.array(reach) / np.abs(way).max(axis=0)
    speed = np.hypot(*np.gradient(way, time, axis=0).T).max()
    return way * min(1.0, fastest / speed)


def test_path_over_border_slows_before_edge_and_continues_along_edge():
    time = TICK * np.arange(round(8.0 / TICK))
    path = np.stack([4.0 + 2.0 * np.sin(time * math.pi / 4.0), 0.5 * np.cos(time)], axis=1)
    found = bounded_path(path)
    np.testing.assert_allclose(found[:, 1], path[:, 1], atol=1e-9)  # along the edge nothing is changed
    speed, wanted = np.diff(found[:, 0]) / TICK, np.diff(path[:, 0]) / TICK
    bound = (5.0 - found[:-1, 0]) / EDGE_TIME
    np.testing.assert_allclose(speed, np.minimum(wanted, bound), atol=1e-9)
    assert found[:, 0].max() < 5.0
    back = speed < 0.0  # on the way back the path is unchanged
    np.testing.assert_allclose(speed[back], wanted[back], atol=1e-9)


def test_path_away_from_border_is_unchanged():
    chance, time = np.random.default_rng(2), TICK * np.arange(2000)
    path = random_path(chance, time, (4.0, 2.0), 1.5)
    np.testing.assert_array_equal(bounded_path(path), path)


def test_dancer_outside_returns_at_walking_speed():
    found = bounded_path(np.full((200, 2), (6.5, -0.5)))
    fast = -np.diff(found[:, 0]) / TICK
    assert fast[1:].max() <= MAX_RETURN_SPEED + 1e-9 or found[1, 0] <= 5.0
    edges, half = CanonBounds(np.array([5.0, 3.0])), np.array([5.0, 3.0])
    edges = CanonBounds(half)
    edges.add(np.array([[4.8, 0.0]]))
    there = np.array([[4.8, 0.0]])
    edges.update(there, TICK, FLOOR, ALL)
    half[0] = 3.0  # the stage becomes smaller
    ways = []
    for tick in range(2, 400):
        way = edges.update(there, tick * TICK, FLOOR, ALL)
        there = there + way
        ways.append(way[0, 0] / TICK)
    assert -MAX_RETURN_SPEED - 1e-9 <= min(ways) < -MAX_RETURN_SPEED + 1e-9
    assert max(ways) <= 0.0
    assert there[0, 0] == pytest.approx(3.0, abs=0.01)


@mostly_long("seed", [0, 1, *(pytest.param(more, marks=pytest.mark.long) for more in (2, 3))], quick=[])
def test_canon_dancers_stay_on_stage_when_performer_does(seed):
    chance = np.random.default_rng(seed)
    extra = f'dancer = "back & 6"\ncanon = "front"\ncanon_beats = {chance.choice([0.5, 1.0, 2.0])}'
    extra += f"\nmirrored = {('false', 'true')[seed % 2]}"
    show = made_show(performer(extra))
    half = show.motion.stage_area.half
    count = 12 * MEASURE
    path = random_path(chance, TICK * np.arange(count + 1), half - 0.05, 3.0)
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    view, seen, agents = show.view(), [], []
    for tick in range(1, count + 1):
        time = tick * TICK - 0.004
        angle = 0.5 * math.sin(time)
        rotation[0] = math.cos(angle), 0.0, math.sin(angle), 0.0
        packed = pack_pose([path[tick, 0], 0.935, path[tick, 1]], rotation)
        show.apply(events.MocapFrame(time=time, source="vmc", performer="anna", pose=packed))
        show.tick(tick * TICK)
        for ahead in (0.0, 0.5, 0.99):
            show.fill(view, (tick + ahead) * TICK)
            seen.append(view.joint_position[:5, 0, ::2].copy())
        if tick == 7 * MEASURE // 2:
            own = show.mocap.performers["anna"]
            begun = own.offset[own.delay > 0.0].copy()
        agents.append(show.state.position[:5].copy())
    captured = show.mocap.performers["anna"]
    assert captured.fade.tolist() == [1.0] * 6
    assert np.abs(captured.offset[captured.delay > 0.0] - begun).max() > 0.5  # the bounds were active
    whole = np.array(seen)[3 * 7 * MEASURE :]
    assert (np.abs(whole) <= half + 1e-5).all()
    assert (np.abs(np.array(agents)[7 * MEASURE :]) <= half + 1e-5).all()
    # bounded paths are slower than the original path, never faster, and have no jumps
    spans = np.tile([0.5, 0.49, 0.01], len(whole))[: len(whole) - 1] * TICK
    speed = np.hypot(*np.moveaxis(np.diff(whole, axis=0), 2, 0)).max(axis=1) / spans
    assert speed[spans > 0.4 * TICK].max() < 3.0 * 1.1
    step = np.abs(np.diff(whole, axis=0)).max()
    assert step < 3.0 * 1.1 * TICK


@pytest.mark.long
def test_moved_capture_floor_acts_at_once_and_keeps_dancers_on_stage():
    show = made_show(performer('dancer = "back & 6"\ncanon = "front & 1-2"\ncanon_beats = 0.5'))
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    for tick in range(1, 4 * MEASURE):
        pose = pack_pose([0.0, 0.935, 0.0], rotation)
        show.apply(events.MocapFrame(time=tick * TICK - 0.004, source="vmc", performer="anna", pose=pose))
        if tick == 3 * MEASURE:
            before = show.state.position[:2].copy()
            show.apply(events.PlaceMocap(time=tick * TICK, source="osc", performer="anna", x=0.0, z=1.0))
        show.tick(tick * TICK)
        if tick == 3 * MEASURE:
            np.testing.assert_allclose(show.state.position[:2] - before, [[0.0, 1.0]] * 2, atol=1e-4)
            show.apply(events.PlaceMocap(time=tick * TICK, source="osc", performer="anna", x=90.0, z=1.0))
    assert (np.abs(show.state.position[:2]) <= show.motion.stage_area.half + 1e-5).all()


@pytest.mark.long
def test_mirrored_canon_paths_continue_without_jump():
    show = made_show(performer('dancer = "back & 6"\ncanon = "front & 1-2"\ncanon_beats = 1.0'))
    seen = [run(show, 1, 4 * MEASURE, name="anna")]
    show.apply(events.MirrorMocap(time=show.time, source="osc", performer="anna", mirrored=True))
    seen.append(run(show, 4 * MEASURE + 1, 5 * MEASURE, name="anna"))
    hips = np.concatenate(seen)[3 * MEASURE :, :2, 0, ::2]
    step = np.hypot(*np.moveaxis(np.diff(hips, axis=0), 2, 0))
    assert step.max() < 0.52 * TICK  # the performer moves in a circle at 0.5 m/s
