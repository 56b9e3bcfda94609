"""Tests of moments of measures against known poses."""

import math

import numpy as np
import pytest

from live.graph.build.transitions import clouds
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import build_graph
from live.graph.node_features import body_features, heading_of, moments_of
from live.graph.select.candidates import turn_vectors
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps

LIBRARY = build_library(made_steps())
MOMENTS = moments_of(LIBRARY)


def test_hips_and_headings_match_clips():
    """A glide moves evenly, a spin turns evenly: both are known in closed form."""
    glide = LIBRARY.step_index("glide")
    for node in np.flatnonzero(LIBRARY.node_step == glide):
        way = LIBRARY.node_travel[node] * np.linspace(0, 1, 17)[:, None]
        assert MOMENTS.hips[node] - MOMENTS.hips[node, 0] == pytest.approx(way, abs=1e-5)
    spin = int(np.flatnonzero(LIBRARY.node_step == LIBRARY.step_index("spin"))[0])
    turned = np.unwrap(MOMENTS.facing[spin]) - MOMENTS.facing[spin, 0]
    assert turned == pytest.approx(2 * math.pi * np.linspace(0, 1, 17), abs=0.02)


def test_features_are_relative_to_body():
    """Position and heading make no difference; velocity does."""
    cloud = clouds(LIBRARY, LIBRARY.node_first[:, None])[:, 0]
    speed = np.random.default_rng(2).normal(0, 1, cloud.shape)
    stands = np.ones((*cloud.shape[:-2], 2), np.bool_)
    plain, hips, facing = body_features(cloud, speed, stands)
    yaw, shift = 1.1, np.array([3.0, -2.0])
    moved, turned_speed = cloud.copy(), speed.copy()
    moved[..., ::2] = turn_vectors(cloud[..., ::2], np.full(cloud.shape[:-1], yaw)) + shift
    turned_speed[..., ::2] = turn_vectors(speed[..., ::2], np.full(cloud.shape[:-1], yaw))
    again, there, heading = body_features(moved, turned_speed, stands)
    assert again == pytest.approx(plain, abs=1e-6)
    assert there == pytest.approx(turn_vectors(hips, np.full(len(hips), yaw)) + shift, abs=1e-6)
    assert np.angle(np.exp(1j * (heading - facing - yaw))) == pytest.approx(0.0, abs=1e-6)
    assert heading_of(moved) == pytest.approx(heading, abs=1e-12)
    faster, _, _ = body_features(cloud, 2.0 * speed, stands)
    assert np.abs(faster - plain).max() > 0.05


def test_each_moment_has_zero_distance_to_itself():
    nodes = np.arange(LIBRARY.node_count, dtype=np.int32)
    for k in (0, 5, 16):
        fraction = np.full(len(nodes), k / 16)
        distance = MOMENTS.distance(MOMENTS.feature[:, k], fraction, nodes)
        direct = np.linalg.norm(MOMENTS.feature[:, None, k] - MOMENTS.feature[None, :, k], axis=-1)
        assert distance == pytest.approx(direct, abs=2e-3)
        assert np.diag(distance) == pytest.approx(0.0, abs=2e-3)


def test_speed_distinguishes_glide_from_stand():
    """At its middle a glide looks like a sway; only the speed of 0.8 m a measure differs."""
    glide = next(n for n in range(LIBRARY.node_count) if LIBRARY.node_travel[n, 1] > 0.7)
    sway = int(np.flatnonzero(LIBRARY.node_step == LIBRARY.step_index("sway"))[0])
    own = MOMENTS.feature[glide, 8][None]
    near = MOMENTS.distance(own, np.array([0.5]), np.array([glide, sway], np.int32))[0]
    assert near[0] < 1e-2 < near[1]


def test_grown_graph_has_moments_of_full_build():
    clips = made_steps()
    whole = build_graph(build_library([*clips, made_clip("new", way=(0.1, 0.2))]), threshold=0.2)
    grown = insert_clips(build_graph(build_library(clips), threshold=0.2), [made_clip("new", way=(0.1, 0.2))])
    for name in ("feature", "hips", "facing"):
        assert (getattr(whole.moments, name) == getattr(grown.moments, name)).all()
