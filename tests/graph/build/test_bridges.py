"""Tests of bridges: hidden sections of a recording are found, distances cover whole windows, bridges connect steps."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from live.graph.build.bridges import BASE_RATE, PosedRecording, _metric, _nearest, _windows, find_bridges
from live.graph.build.transitions import all_pairs
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON
from tests.fixtures.made_steps import made_clip


def _recording(seconds: float, arms: list[tuple[float, float]], rate: float = 60.0) -> Clip:
    """Clip of a walk in a circle with arms raised to the angles [rad] given for some times [s]."""
    time = np.arange(int(seconds * rate) + 1) / rate
    heading = 0.4 * time
    root = np.stack([2 * np.sin(heading), 0.93 + 0.02 * np.cos(2 * np.pi * 2 * time), 2 * np.cos(heading)], axis=1)
    rotation = np.zeros((len(time), JOINT_COUNT, 4))
    rotation[..., 0] = 1.0
    rotation[:, 0] = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), heading + math.pi / 2)
    arm = np.interp(time, *zip(*arms, strict=True))
    for name, sign in (("leftUpperArm", -1.0), ("rightUpperArm", 1.0)):
        rotation[:, SKELETON.index(name)] = quaternion.from_axis_angle(np.array((0.0, 0.0, 1.0)), sign * arm)
    contact = np.ones((len(time), 2), np.bool_)
    return Clip("walk", root.astype(np.float32), rotation.astype(np.float32), rate, contact)


LOW, MIDDLE, HIGH = 1.2, 0.2, -0.8
TIMES = (0.0, 8.0, 9.0, 10.0, 11.9, 13.0, 14.9, 16.0, 17.0, 20.0)
ARMS = list(zip(TIMES, (MIDDLE, MIDDLE, LOW, LOW, HIGH, HIGH, LOW, LOW, MIDDLE, MIDDLE), strict=True))
"""Arms go from low to high in two seconds only after 10 s, and back only after 13 s."""


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library([made_clip("low"), made_clip("high", arm=HIGH)]), threshold=0.1)


def test_connecting_section_of_recording_is_found(graph):
    assert len(graph.joins.source) == 2  # each step only follows itself
    recorded = [
        PosedRecording.of(_recording(6.0, [(0.0, -1.0), (6.0, -1.0)])),
        PosedRecording.of(_recording(20.0, ARMS)),
    ]
    found = find_bridges(graph, recorded, 0, 1, measure_s=2.0)
    best = found[0]
    assert best.recording == 1
    assert 9.3 < best.start < 10.4
    assert 11.6 < best.stop < 13.1
    assert abs(best.stop - best.start - 2.0) <= 0.15 * 2.0 + 1e-9
    assert (best.source, best.target) == (0, 1)
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    assert best.cost < 0.1  # the arms move at the line
    for one, other in itertools.pairwise(found):
        assert one.recording != other.recording or abs(one.start - other.start) >= 0.8


def bridge_clip(library, recording, bridge):
    """The stretch of a recording as a step, with up to a measure of lead-in."""
    name, rate = "{} to {}".format(*(library.steps[library.node_step[n]] for n in (bridge.source, bridge.target))), 60.0
    size = (bridge.stop - bridge.start) * rate
    begin = max(0, math.floor(bridge.start * rate - size))
    end = min(recording.sample_count, math.ceil(bridge.stop * rate) + 9)
    clip = replace(
        recording,
        root_position=recording.root_position[begin:end],
        rotation=recording.rotation[begin:end],
        contact=recording.contact[begin:end],
    )
    return replace(
        made_clip(name), clip=clip, first=bridge.start * rate - begin, samples_per_measure=size, bpm=240.0 * rate / size
    )


def test_bridge_connects_unconnected_steps(graph):
    recording = _recording(20.0, ARMS)
    low, high = (graph.library.steps.index(name) for name in ("low", "high"))
    clips = [
        bridge_clip(
            graph.library, recording, find_bridges(graph, [PosedRecording.of(recording)], a, b, measure_s=2.0)[0]
        )
        for a, b in ((low, high), (high, low))
    ]
    whole = insert_clips(graph, clips)
    assert whole.library.steps[2:] == ("low to high", "high to low")
    assert whole.alive.all()
    assert whole.hops[high, low] == 2  # from low through the bridge


def test_bridge_distances_equal_whole_window_distances(graph):
    """Block products against the metric on windows that are built one by one."""
    recorded, library = PosedRecording.of(_recording(4.0, [(0.0, 1.3), (4.0, 0.0)])), graph.library
    metric = _metric(graph.rule.metric, 9)
    nodes = np.arange(2)
    distance, which = _nearest(recorded, _windows(library, nodes, library.node_last, graph.window, metric), metric)
    position = np.stack([recorded.floor.real, recorded.height, recorded.floor.imag], axis=-1).astype(np.float64)
    built = np.stack([position[n : n + 9] for n in range(len(position) - 8)])
    ends = window_positions(library, nodes, graph.window)
    table = all_pairs(ends, built, metric).distance
    assert distance == pytest.approx(table.min(axis=0), abs=2e-3)  # single precision about a mean height of one meter
    chosen = table[which, np.arange(len(which))]
    assert chosen == pytest.approx(table.min(axis=0), abs=2e-3)


def window_positions(library, nodes, window):
    from live.graph.build.transitions import clouds
    from live.graph.step_library import window_samples

    length = (library.node_last[nodes] - library.node_first[nodes]) * window
    return clouds(library, window_samples(library.node_last[nodes] - length, library.node_last[nodes], 9))


def test_short_recordings_have_no_bridges(graph):
    assert (
        find_bridges(graph, [PosedRecording.of(_recording(1.0, [(0.0, 1.0), (1.0, 1.0)]))], 0, 1, measure_s=2.0) == []
    )
    assert find_bridges(graph, [], 0, 1, measure_s=2.0) == []
    assert len(PosedRecording.of(_recording(2.0, [(0.0, 1.0), (1.0, 1.0)])).floor) == 2 * BASE_RATE + 1


def test_invalid_length_is_refused(graph):
    with pytest.raises(ValueError, match=r"measures of 0\.0 s"):
        find_bridges(graph, [], 0, 1, measure_s=0.0)
