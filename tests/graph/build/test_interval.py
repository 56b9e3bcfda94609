"""Tests of transitions near the measure line (T140): late landings move the line, and the meter is kept."""

from dataclasses import replace

import numpy as np
import pytest

from live.graph.build.transitions import JoinSettings, retime_library
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.motion import quaternion
from live.motion.skeleton import SKELETON
from tests.fixtures.made_steps import made_clip, made_steps


def _late_landing_step(name: str, samples: float):
    """A sway whose arms come down to the starting pose of sway `samples` after the measure line."""
    step = made_clip(name)
    count = step.clip.sample_count + 8
    time = np.arange(count) - (step.first + step.samples_per_measure)
    arm = np.where(time < -16, 1.2, np.interp(time - samples, (-10.0, -6.0), (-0.6, 1.2)))
    rotation = np.concatenate([step.clip.rotation, step.clip.rotation[-1:].repeat(8, axis=0)]).copy()
    for side, sign in (("left", -1.0), ("right", 1.0)):
        turned = quaternion.from_axis_angle(np.array((0.0, 0.0, 1.0)), sign * arm)
        rotation[:, SKELETON.index(f"{side}UpperArm")] = turned
    root = np.concatenate([step.clip.root_position, step.clip.root_position[-1:].repeat(8, axis=0)])
    contact = np.ones((count, 2), np.bool_)
    clip = replace(step.clip, root_position=root, rotation=rotation, contact=contact)
    return replace(step, clip=clip)


def test_lines_stay_by_default_and_without_gain():
    library = build_library(made_steps())
    assert retime_library(library, JoinSettings(), 0.0) is library
    still = build_library([made_clip("sway", turn=0.0)])
    assert np.array_equal(retime_library(still, JoinSettings(), 0.1).node_last, still.node_last)


def test_late_landing_step_ends_at_landing():
    library = build_library([made_clip("sway"), _late_landing_step("late", 4.0)])
    plain, moved = (build_graph(library, threshold=0.15, interval=interval, prune=False) for interval in (0.0, 0.125))
    late = library.steps.index("late")

    def distance(graph):
        return [
            cost
            for u, v, cost in zip(graph.joins.source, graph.joins.target, graph.joins.cost, strict=True)
            if (u, v) == (late, 1 - late)
        ]

    assert not distance(plain) or distance(moved)[0] < 0.5 * distance(plain)[0]
    assert distance(moved)[0] < 0.1
    assert moved.library.node_last[late] - library.node_last[late] == pytest.approx(4.0, abs=0.1)
    # the measure covers its new length from line to line, and its end is measured there
    assert moved.node_end[late] == pytest.approx(plain.node_end[late], abs=0.05)


def test_lines_stay_within_interval_and_fixed_inside_steps():
    library = build_library([*made_steps(), _late_landing_step("late", 3.0)])
    moved = retime_library(library, JoinSettings(threshold=0.2), 0.1)
    size = library.node_last - library.node_first
    assert (np.abs(moved.node_first - library.node_first) <= 0.1 * size + 1e-9).all()
    assert (np.abs(moved.node_last - library.node_last) <= 0.1 * size + 1e-9).all()
    phrase = np.flatnonzero(library.node_step == library.steps.index("phrase"))
    assert moved.node_last[phrase[0]] == library.node_last[phrase[0]]
    assert moved.node_first[phrase[1]] == library.node_first[phrase[1]]
    assert moved.node_last.max() <= len(library.clip_root) - 1


@pytest.mark.parametrize("interval", [-0.1, 0.3, float("nan")])
def test_invalid_intervals_are_refused(interval):
    with pytest.raises(ValueError, match="interval around the measure line"):
        build_graph(build_library(made_steps()), interval=interval)
