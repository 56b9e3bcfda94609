"""Tests of near pairs of clouds against all pairs in full precision, and of the metric's weights."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.build import nearest_pairs as near
from live.graph.build.blend_feasibility import MIN_CHORD, MIN_ROOT_COSINE, Blends
from live.graph.build.blend_kernels import NOT_ASKED, is_blendable
from live.graph.build.metric import WINDOW_SAMPLES, FlatClouds, Metric, joint_weights, window_weights
from live.graph.build.nearest_pairs import EdgeLimits, PairCodes, near_pairs
from live.graph.build.transitions import all_pairs
from live.motion.skeleton import JOINT_COUNT, SKELETON


def _clouds(seed, count, spread):
    """Clouds about a common body, `spread` [m] apart, turned and moved at random."""
    chance = np.random.default_rng(seed)
    body = np.random.default_rng(0).normal((0, 1, 0), 0.4, (1, WINDOW_SAMPLES, JOINT_COUNT, 3))
    cloud = body + chance.normal(0, spread, (count, *body.shape[1:]))
    yaw = chance.uniform(-3, 3, (count, 1, 1))
    x, z = cloud[..., 0].copy(), cloud[..., 2].copy()
    cloud[..., 0] = x * np.cos(yaw) + z * np.sin(yaw) + chance.uniform(-5, 5, (count, 1, 1))
    cloud[..., 2] = z * np.cos(yaw) - x * np.sin(yaw) + chance.uniform(-5, 5, (count, 1, 1))
    return cloud


def _codes(chance, count):
    return np.stack([chance.integers(-1, 2, count), chance.integers(-1, 3, count)], axis=1).astype(np.int32)


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    sizes=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    spread=st.floats(0.02, 0.2),
    block=st.sampled_from([1, 7, 100, 1 << 21]),
    plain=st.sampled_from([0, 1 << 16]),
    buffer=st.sampled_from([1, 1 << 15]),
)
def test_near_pairs_equal_pairs_of_dense_table(seed, sizes, spread, block, plain, buffer):
    """Any size of block and buffer, with BLAS or without: the same pairs as the full table within the threshold."""
    chance = np.random.default_rng(seed)
    first, second = _clouds(seed, sizes[0], spread), _clouds(seed + 1, sizes[1], spread)
    codes = _codes(chance, sizes[0]), _codes(chance, sizes[1])
    table = all_pairs(first, second)
    threshold = float(np.quantile(table.distance, 0.5)) * (1 + 1e-9)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(near, "_BLOCK_PAIRS", block)
        patch.setattr(near, "_MAX_PLAIN", plain)
        patch.setattr(near, "_BUFFER", buffer)
        metric = Metric.of()
        found = near_pairs(
            FlatClouds.of(first, metric),
            FlatClouds.of(second, metric),
            threshold,
            replace(PairCodes.free(*sizes), leaving=codes[0], entering=codes[1]),
        )
    expected = []
    for i, j in np.argwhere(table.distance <= threshold):
        (end, own), (begin, other) = codes[0][i], codes[1][j]
        if (end == begin or -1 in (end, begin)) and not (own == other and own >= 0):
            expected.append((i, j))
    assert list(zip(found.row.tolist(), found.column.tolist(), strict=True)) == expected
    rows = (found.row, found.column)
    assert found.distance == pytest.approx(table.distance[rows], abs=1e-7)
    assert found.motion[:, :2] == pytest.approx(table.shift[rows], abs=1e-9)
    assert np.cos(found.motion[:, 2] - table.yaw[rows]) == pytest.approx(1.0, abs=1e-12)


def test_identical_clouds_are_found_at_millimeter_threshold():
    """The single precision filter loses no pair, though its distances have a larger error."""
    cloud = _clouds(1, 300, 0.1) + np.array((400.0, 0.0, -300.0))
    metric = Metric.of()
    flat = FlatClouds.of(cloud, metric)
    found = near_pairs(flat, flat, 0.001, PairCodes.free(300, 300))
    assert found.row.tolist() == found.column.tolist() == list(range(300))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 0.5), st.floats(0.0, 1.0))
def test_coarse_distances_are_lower_bounds(seed, spread, emphasis):
    """The property the filter relies on: a projection makes no distance longer."""
    metric = Metric.of(emphasis=emphasis)
    cloud = _clouds(seed, 12, spread)
    flat = FlatClouds.of(cloud, metric)
    floor, height, size = flat.coarse_floor, flat.coarse_height, flat.coarse_size
    coarse = size[:, None] + size[None] - 2 * np.abs(floor.conj() @ floor.T) - 2 * height @ height.T
    assert (coarse <= all_pairs(cloud, cloud, metric).distance ** 2 + 1e-5).all()


def chosen_by_the_rule(distance, step, variation, limits):
    """The rule of EdgeLimits, word by word, on a whole table of distances (N, M), inf where there is no pair."""
    kept = set()
    for i, row in enumerate(distance):
        order = [j for j in np.argsort(row, kind="stable") if np.isfinite(row[j])]
        ranked = []
        for place, j in enumerate(order):
            rank = 1 + sum(variation[k] == variation[j] for k in order[:place])
            if not any(step[k] == step[j] for k in order[:place]):
                rank = 0
            if rank <= limits.per_variation:
                ranked.append((rank, row[j], j))
        kept |= {(i, int(j)) for _, _, j in sorted(ranked)[: limits.per_node]}
    for j, column in enumerate(distance.T):
        order = [i for i in np.argsort(column, kind="stable") if np.isfinite(column[i])]
        kept |= {(int(i), j) for i in order[: limits.into]}
    return sorted(kept)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    sizes=st.tuples(st.integers(1, 30), st.integers(1, 60)),
    limits=st.builds(EdgeLimits, st.integers(1, 40), st.integers(1, 9), st.integers(0, 3)),
    steps=st.integers(1, 6),
    block=st.sampled_from([1, 100, 1 << 21]),
    share=st.sampled_from([0.2, 0.7, 1.0]),
)
def test_kept_pairs_are_those_of_the_rule(seed, sizes, limits, steps, block, share):
    """The nearest of each step, then of each variation, and so on, and the nearest into each; among blendable pairs."""
    chance = np.random.default_rng(seed)
    first, second = _clouds(seed, sizes[0], 0.1), _clouds(seed + 1, sizes[1], 0.1)
    step = chance.integers(0, steps, sizes[1]).astype(np.int32)
    variation = (3 * step + chance.integers(0, 3, sizes[1])).astype(np.int32)
    codes = replace(PairCodes.free(*sizes), step=step, variation=variation)
    # a hip that is upright or upside down, so that half of the pairs cannot be blended, wherever the bodies face
    turned = [(chance.integers(0, 2, count) * np.array(share < 1.0)).astype(np.float32) for count in sizes]
    ends, starts = (np.stack([1 - t, t, 0 * t, 0 * t], axis=1).reshape(-1, 1, 1, 4) for t in turned)
    asked = [np.full((count, 1, 2), NOT_ASKED, np.uint8) for count in sizes]
    blends = Blends(ends, starts, np.array([0.5]), *asked)
    table = all_pairs(first, second)
    threshold = float(np.quantile(table.distance, share)) * (1 + 1e-9)
    blendable = [
        [
            is_blendable(a, b, yaw, blends.weight, asked[0][0], asked[1][0], MIN_ROOT_COSINE, MIN_CHORD)
            for b, yaw in zip(starts, yaws, strict=True)
        ]
        for a, yaws in zip(ends, table.yaw, strict=True)
    ]
    allowed = np.where(np.array(blendable) & (table.distance <= threshold), table.distance, np.inf)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(near, "_BLOCK_PAIRS", block)
        metric = Metric.of()
        flat = FlatClouds.of(first, metric), FlatClouds.of(second, metric)
        found = near_pairs(*flat, threshold, codes, limits, blends)
    assert list(zip(found.row.tolist(), found.column.tolist(), strict=True)) == chosen_by_the_rule(
        allowed, step, variation, limits
    )


def test_empty_clouds_have_no_pairs():
    flat = FlatClouds.of(_clouds(1, 3, 0.01), Metric.of())
    none = flat.select(np.zeros(0, np.int64))
    assert len(near_pairs(none, flat, 1.0, PairCodes.free(0, 3)).row) == 0
    assert len(near_pairs(flat, none, 1.0, PairCodes.free(3, 0)).row) == 0


def test_weights_change_distance():
    """A difference in one hand alone counts √(its share), at the measure line more than before it."""
    one = _clouds(2, 1, 0.0)
    hand = SKELETON.index("leftHand")
    for metric in (Metric.of(), Metric.of({"leftHand": 3.0}), Metric.of(emphasis=1.0)):
        for sample in (0, WINDOW_SAMPLES - 1):
            other = one.copy()
            other[0, sample, hand, 1] += 0.5
            distance = all_pairs(one, other, metric).distance[0, 0]
            assert distance == pytest.approx(0.5 * math.sqrt(metric.joint[hand] * metric.window[sample]), abs=1e-6)
    assert all_pairs(one, one, replace(Metric.of(), joint=joint_weights({"hips": 0.0}))).distance[0, 0] < 1e-6


def test_weights_are_normalized_and_validated():
    assert joint_weights().sum() == pytest.approx(1.0)
    assert window_weights(20, 0.0) == pytest.approx(np.full(20, 0.05))
    assert window_weights(12)[-1] == pytest.approx(3 * window_weights(12)[0])
    changed = joint_weights({"head": 4.0})
    assert changed[SKELETON.index("head")] / changed[SKELETON.index("hips")] == pytest.approx(2.0)
    with pytest.raises(ValueError, match="'elbow': no such joint; there are hips"):
        joint_weights({"elbow": 1.0})
    with pytest.raises(ValueError, match="'head' is -1"):
        joint_weights({"head": -1.0})
    with pytest.raises(ValueError, match="nothing is left"):
        joint_weights(dict.fromkeys(SKELETON.names, 0.0))
    with pytest.raises(ValueError, match=r"emphasis.* 1\.5"):
        window_weights(emphasis=1.5)
    with pytest.raises(ValueError, match=r"clouds of shape \(1, 3, 22, 3\)"):
        FlatClouds.of(np.zeros((1, 3, 22, 3)), Metric.of())
