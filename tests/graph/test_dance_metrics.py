"""Tests of dance metrics: inserted jumps are measured, beats are found in the motion, and all keys are present."""

import json
from dataclasses import replace

import numpy as np
import pytest

from live.graph.dance_metrics import DanceMetrics, RawClips, list_and_p95, median_and_p95, ratio
from live.graph.motion_graph import build_graph
from live.graph.render_dance import render_dance
from live.graph.search.path_following import Targets
from live.graph.step_library import build_library
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.metrics import beat_alignment, largest_at_samples, mean_speed, motion_beats
from tests.fixtures.made_steps import made_clip
from tests.fixtures.steps_of_the_project import project_steps

KEYS = {
    "foot_slide_mean", "foot_slide_p99", "skating_ratio", "join_velocity_ratio", "join_acceleration_ratio",
    "beat_offset_ms", "beat_alignment", "path_error_m", "heading_error_deg", "overlaps", "min_distance_m",
    "self_contact_ratio", "neighbour_contact_ratio", "hand_contact_ratio",
}  # fmt: skip


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(project_steps("samba", "walk", "groove")))


@pytest.fixture(scope="module")
def dance(graph):
    chance = np.random.default_rng(5)
    path = [int(np.flatnonzero(graph.alive)[0])]
    while len(path) < 8:
        path.append(int(chance.choice(graph.edge_target[graph.edge_start[path[-1]] : graph.edge_start[path[-1] + 1]])))
    return render_dance(graph, path, bpm=117.0)


@pytest.mark.long
def test_result_has_all_keys_and_is_json(graph, dance):
    targets = Targets(np.vstack([[0.0, 0.0], dance.end[:, :2]]), np.concatenate([[0.0], dance.end[:, 2]]))
    values = DanceMetrics(graph, dance, targets).result()
    assert set(values) == KEYS
    json.dumps(values, allow_nan=False)
    assert values["foot_slide_mean"] < 0.02
    assert 0.1 < values["join_velocity_ratio"] < 2.0
    assert len(values["path_error_m"]["list"]) == 8
    assert values["heading_error_deg"]["p95"] == pytest.approx(0.0, abs=1e-6)
    assert DanceMetrics(graph, dance).result()["path_error_m"] == {"list": [], "p95": None}


@pytest.mark.long
def test_kinematic_beats_are_told_beside_chance(graph, dance):
    figures = DanceMetrics(graph, dance)
    values, own = figures.result(), motion_beats(mean_speed(figures.position, 60.0), 60.0)
    told = values["beat_alignment"]
    assert told["music"] == beat_alignment(dance.beat_time, own)
    assert told["kinematic"] == beat_alignment(own, dance.beat_time)
    beat = 60.0 / 117.0
    assert told["kinematic_chance"] == pytest.approx(np.sqrt(2.0 * np.pi) * 0.05 / beat, rel=1e-3)
    for name in ("music", "kinematic"):
        assert told[f"{name}_ratio"] == told[name] / told[f"{name}_chance"]
    assert 0.0 < values["beat_offset_ms"]["kinematic_chance"]["median"] < 1e3 * beat


def test_only_jumps_at_joins_are_measured(graph, dance):
    whole = DanceMetrics(graph, dance).joins

    def jumped(seconds):
        root = dance.clip.root_position.copy()
        root[round(seconds * 60.0), 0] += 0.2  # one displaced sample: 12 m/s back and forth
        return DanceMetrics(graph, replace(dance, clip=replace(dance.clip, root_position=root))).joins

    join = dance.join[2]
    at_join = jumped(join.mean())
    assert at_join[0][2] > 10.0
    assert at_join[1][2] > 100.0
    np.testing.assert_allclose(np.delete(at_join[0], 2), np.delete(whole[0], 2))
    elsewhere = jumped(join[1] + 0.9)
    np.testing.assert_allclose(elsewhere[0], whole[0])


def test_raw_clips_are_played_at_tempo_of_dance(graph):
    """At half the tempo, velocities are half and accelerations a quarter."""
    steps = tuple(graph.library.clips[:4])
    fast, slow = (RawClips(steps, seconds, 60.0) for seconds in (2.0, 4.0))
    assert fast.slide.mean() == pytest.approx(2.0 * slow.slide.mean(), abs=2e-3)
    step = steps[0]
    position, _ = forward_kinematics(step.clip.root_position.astype(float), step.clip.rotation.astype(float))
    own = step.samples_per_measure / step.clip.sample_rate
    np.testing.assert_allclose(RawClips((step,), own, step.clip.sample_rate).sampled_clips[0][0], position, atol=1e-5)
    assert (
        largest_at_samples(fast.sampled_clips[0][0], 60.0)[1].max()
        > 2.5 * largest_at_samples(slow.sampled_clips[0][0], 60.0)[1].max()
    )


def test_annotated_beats_match_music_beats(graph, dance):
    """As planned, and found again in the motion: when the arms match the clip's pose on its beat."""
    figures = DanceMetrics(graph, dance)
    np.testing.assert_allclose(figures.annotated_offsets, 0.0, atol=1e-9)
    library, clip = graph.library, dance.clip
    off = []
    for n, node in enumerate(dance.node):
        step = library.clips[library.node_clip[node]]
        for beat in (1, 2):
            sample = round(library.node_first[node] + beat * step.samples_per_measure / 4)
            pose = library.clip_rotation[sample, 4:14]
            around = round(dance.beat_time[4 * n + beat] * 60.0) + np.arange(-12, 13)
            near = np.abs(np.sum(clip.rotation[around][:, 4:14] * pose, axis=-1)).sum(axis=1)
            if np.ptp(near) > 1e-2:
                off.append(around[np.argmax(near)] / 60.0 - dance.beat_time[4 * n + beat])
    assert len(off) >= 5
    assert np.abs(off).max() <= 1.0 / 60.0


def test_wrong_beat_annotation_is_measured_as_late():
    """The node ends early, so that the clip is played slower than its beats indicate."""
    graph = build_graph(build_library([made_clip("sway"), made_clip("glide", way=(0.0, 0.5))]), threshold=0.3)
    last = graph.library.node_last.copy()
    last[0] -= 4.0  # of 32 samples
    late = replace(graph, library=replace(graph.library, node_last=last))
    dance = render_dance(late, [0, 0], bpm=120.0)
    offsets = DanceMetrics(late, dance).annotated_offsets
    np.testing.assert_allclose(offsets[0], np.arange(4) * 0.5 * (32.0 / 28.0 - 1.0))
    assert DanceMetrics(late, dance).result()["beat_offset_ms"]["annotated"]["p95"] > 100.0


def test_ratio_and_summaries_handle_empty_input():
    assert ratio(np.array([2.0]), 4.0) == 0.5
    assert ratio(np.zeros(0), 4.0) is None
    assert ratio(np.ones(3), 0.0) is None
    assert median_and_p95(np.zeros(0)) == {"median": None, "p95": None}
    assert median_and_p95(np.array([-0.004, 0.002, 0.003]))["median"] == pytest.approx(3.0)
    assert list_and_p95([]) == {"list": [], "p95": None}
