"""Tests of blend feasibility of joins: known rotations, and a direct loop on random ones."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.build.blend_feasibility import MIN_CHORD, MIN_ROOT_COSINE, MOMENTS, Blends
from live.graph.build.blend_kernels import is_blendable
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.motion import quaternion
from live.motion.skeleton import SKELETON
from tests.fixtures.made_steps import made_clip

Y = np.array((0.0, 1.0, 0.0))
HAND = SKELETON.index("leftHand")


def can_blend(library, window, source, target, yaw):
    """Whether each pair of nodes can be blended with the target's clip turned by `yaw`, as an array."""
    blends = Blends.of(library, window, source, target)
    rows = zip(blends.end, blends.start, yaw, blends.end_stands, blends.start_stands, strict=True)
    limits = MIN_ROOT_COSINE, MIN_CHORD
    return np.array([is_blendable(a, b, y, blends.weight, c, d, *limits) for a, b, y, c, d in rows])


def rotate_joint(clip, joint, axis, angle):
    """The clip with one joint rotated by `angle` [rad] at all samples."""
    rotation = clip.clip.rotation.copy()
    turn = quaternion.from_axis_angle(np.array(axis), np.asarray(angle))
    rotation[:, joint] = quaternion.mul(turn, rotation[:, joint])
    return replace(clip, clip=replace(clip.clip, rotation=rotation.astype(np.float32)))


def test_opposite_facing_is_infeasible_unless_clip_is_turned():
    library = build_library([made_clip("sway"), rotate_joint(made_clip("away"), 0, Y, math.radians(170))])
    source, target = np.array([0, 0, 1], np.int32), np.array([0, 1, 1], np.int32)
    assert can_blend(library, 0.2, source, target, np.zeros(3)).tolist() == [True, False, True]
    assert can_blend(library, 0.2, source, target, np.radians([0, -170, 170])).tolist() == [True, True, False]


@pytest.mark.parametrize(("degrees", "good"), [(100, True), (140, True), (150, False), (180, False), (230, True)])
def test_bodies_up_to_145_degrees_apart_can_blend(degrees, good):
    library = build_library([made_clip("sway"), made_clip("other")])
    found = can_blend(library, 0.2, np.array([0], np.int32), np.array([1], np.int32), np.radians([degrees]))
    assert found.tolist() == [good]


def test_hand_rotated_far_both_ways_cannot_blend():
    """160 degrees to one side and 150 to the other: 310 apart by their signs, which would spin the hand."""
    clips = [
        rotate_joint(made_clip("sway"), HAND, Y, math.radians(160)),
        rotate_joint(made_clip("b"), HAND, Y, math.radians(-150)),
    ]
    clips.append(made_clip("plain"))
    library = build_library(clips)
    found = can_blend(library, 0.2, np.array([0, 0, 1], np.int32), np.array([1, 2, 2], np.int32), np.zeros(3))
    assert found.tolist() == [False, True, True]
    graph = build_graph(library, threshold=1.0)
    targets = graph.edge_target[graph.edge_start[0] : graph.edge_start[1]].tolist()
    assert 1 not in targets
    assert 2 in targets


@pytest.mark.long
@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.9))
def test_feasibility_equals_direct_loop(seed, window):
    chance = np.random.default_rng(seed)
    clips = []
    for name in ("a", "b", "c"):
        clip = made_clip(name)
        shape = clip.clip.rotation.shape
        wander = quaternion.unit(np.cumsum(chance.normal(0.0, 0.12, shape), axis=0) + np.array([1.0, 0, 0, 0]))
        clips.append(replace(clip, clip=replace(clip.clip, rotation=wander.astype(np.float32))))
    library = build_library(clips)
    source, target = np.repeat(np.arange(3), 3).astype(np.int32), np.tile(np.arange(3), 3).astype(np.int32)
    yaw = chance.uniform(-math.pi, math.pi, 9)
    found = can_blend(library, window, source, target, yaw)
    for e in range(9):
        good, sure = True, True
        for p in MOMENTS:
            samples = [round(line[n] + (p - 1.0) * window * 32.0) for line, n in
                       ((library.node_last, source[e]), (library.node_first, target[e]))]  # fmt: skip
            a, b = (library.clip_rotation[sample].astype(float) for sample in samples)
            half = abs(float(np.dot(a[0], quaternion.mul(quaternion.from_axis_angle(Y, np.asarray(yaw[e])), b[0]))))
            w = 3 * p**2 - 2 * p**3
            chord = np.linalg.norm((1 - w) * a[1:] + w * b[1:], axis=-1).min()
            good &= half >= MIN_ROOT_COSINE and chord >= MIN_CHORD
            sure &= abs(half - MIN_ROOT_COSINE) > 1e-3 and abs(chord - MIN_CHORD) > 1e-3
        assert found[e] == good or not sure
