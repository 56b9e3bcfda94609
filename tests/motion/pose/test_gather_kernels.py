"""Tests of the kernels that gather pose inputs, against whole-array formulas."""

import numpy as np
import pytest

from live.graph.select.candidates import take_placement, transition_weight, turn_vectors
from live.motion.editing.time_warp import draw_measure_warps, measure_warp
from live.motion.pose.foot_lock_kernels import CLEARANCE, CLEARANCE_SOFTNESS, FEET_COLUMNS
from live.motion.pose.gather_kernels import (
    INTO_NEXT,
    LOWER,
    MAX_CLEARANCE,
    NEXT,
    NEXT_LOWER,
    NEXT_TAKE,
    PRESENT,
    PRESENT_TAKE,
    clip_hips,
    delay_phases,
    gather_dancers,
    set_clearance,
    standing_feet,
    warp_phases,
)
from live.motion.pose.pose_pipeline import PosePipeline
from live.show.dancers.measure_state import MeasureState
from tests.fixtures.hips import placements_at
from tests.show.made_show import GRAPH

COUNT = 40


def random_measures(seed):
    """Random measures with corrections, turns and takes."""
    chance, nodes = np.random.default_rng(seed), GRAPH.library.node_count
    result = MeasureState(GRAPH, COUNT)
    result.node[:] = chance.integers(0, nodes, COUNT)
    result.placement[:] = chance.normal(size=(COUNT, 3))
    result.correction[:] = 0.3 * chance.normal(size=(COUNT, 3))
    result.on_support[:] = chance.integers(0, 2, COUNT)
    mixed = chance.random(COUNT) < 0.5
    result.take[mixed] = chance.integers(0, nodes, int(mixed.sum()))
    result.take_share[:, mixed] = chance.uniform(0.1, 1.0, (2, int(mixed.sum())))
    result.amplitude[:] = chance.uniform(0.5, 1.5, (2, COUNT))
    return result


def gather_inputs(pipeline, own, then, phase, fraction, *, goes_on, takes=True):
    """Gather the inputs of all dancers at `phase` of `own`, followed by `then`."""
    library, window = GRAPH.library, GRAPH.window
    gather_dancers(
        np.arange(COUNT), phase, fraction, window, goes_on, takes,
        own.node, own.placement, own.correction, own.aim_origin, own.on_support, own.take,
        own.take_share, own.amplitude,
        then.node, then.placement, then.take, then.take_share, then.amplitude,
        library.node_first, library.node_last, library.node_lead, GRAPH.node_start, GRAPH.node_facing_start,
        GRAPH.node_turns, GRAPH.node_warp_curve,
        pipeline.sample, pipeline.placement, pipeline.share, pipeline.mean, pipeline.amplitude,
    )  # fmt: skip


@pytest.mark.parametrize("fraction", [0.0, 0.4, 0.81, 0.93, 1.0])
@pytest.mark.parametrize("goes_on", [True, False])
def test_gathered_inputs_match_measures(fraction, goes_on):
    own, then, pipeline = random_measures(1), random_measures(2), PosePipeline(COUNT)
    phase = np.clip(fraction + np.random.default_rng(3).uniform(-0.1, 0.1, COUNT), 0.0, 1.0)
    window = GRAPH.window
    gather_inputs(pipeline, own, then, phase, fraction, goes_on=goes_on)
    into = transition_weight((phase - (1.0 - window)) / window) * goes_on
    np.testing.assert_allclose(pipeline.share[INTO_NEXT], into, atol=1e-6)
    placement = placements_at(own, phase)
    _assert_inputs(pipeline, own, phase, placement, PRESENT, PRESENT_TAKE, LOWER, np.ones(COUNT, np.bool_))
    np.testing.assert_array_equal(pipeline.mean[0], np.where(own.take_share[1] > 0.5, own.take, own.node))
    eased = fraction * fraction * (3.0 - 2.0 * fraction)
    loud = own.amplitude[0] + eased * (own.amplitude[1] - own.amplitude[0])
    np.testing.assert_allclose(pipeline.amplitude, loud + into * (then.amplitude[0] - loud), atol=1e-5)
    blends = into > 0.0
    np.testing.assert_array_equal(pipeline.sample[NEXT, ~blends], pipeline.sample[PRESENT, ~blends])
    lies = np.column_stack([then.placement, then.placement[:, 2]])
    _assert_inputs(pipeline, then, phase - 1.0, lies, NEXT, NEXT_TAKE, NEXT_LOWER, blends)


def test_poses_do_not_depend_on_earlier_inputs():
    """Bit by bit: a frame drawn between two ticks may request what no tick does. Shares of a next measure that remained
    made a whole block of dancers be mixed, and the others differed in the last bit.
    """
    own, then = random_measures(1), random_measures(2)
    fresh, used = PosePipeline(COUNT), PosePipeline(COUNT)
    blends = np.where(np.arange(COUNT) < 4, 0.95, 0.5)
    gather_inputs(used, own, then, np.ones(COUNT), 1.0, goes_on=True)
    for pipeline in (fresh, used):
        then.take_share[:, blends > 0.9] = 0.0
        gather_inputs(pipeline, own, then, blends, 0.5, goes_on=True)
    np.testing.assert_array_equal(used.share, fresh.share)
    for ours, theirs in zip(used.run(GRAPH.library.store), fresh.run(GRAPH.library.store), strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("beyond", [-30.0, -0.2, 1.2, 27.0])
def test_samples_are_clamped_to_measure(beyond):
    """After a stall a frame may be many measures late: samples outside the clip may not be numbers."""
    own, pipeline = random_measures(1), PosePipeline(COUNT)
    library = GRAPH.library
    gather_inputs(pipeline, own, own, np.full(COUNT, beyond), 1.0, goes_on=False)
    line = library.node_first if beyond < 0.0 else library.node_last
    np.testing.assert_array_equal(pipeline.sample[PRESENT], line[own.node])
    assert 0.0 <= pipeline.sample.min() <= pipeline.sample.max() < len(library.clip_root)


def _assert_inputs(pipeline, measures, phase, placement, row, take_row, share_row, rows):
    library = GRAPH.library

    def sample_of(node):
        first = library.node_first[node]
        return np.maximum(first + phase * (library.node_last[node] - first), library.node_lead[node])

    np.testing.assert_allclose(pipeline.sample[row, rows], sample_of(measures.node)[rows])
    np.testing.assert_allclose(pipeline.placement[row, rows], placement[rows], atol=1e-12)
    np.testing.assert_array_equal(pipeline.share[share_row : share_row + 2, rows], measures.take_share[:, rows])
    mixed = rows & (measures.take_share[0] > 0.0)
    assert mixed.any() == rows.any()
    np.testing.assert_allclose(pipeline.sample[take_row, mixed], sample_of(np.maximum(measures.take, 0))[mixed])
    lies = take_placement(GRAPH, measures.node, measures.take, placement)
    np.testing.assert_allclose(pipeline.placement[take_row, mixed], lies[mixed], atol=1e-12)


def test_phases_match_time_warp():
    warps = draw_measure_warps(np.random.default_rng(4), 200, window=0.2)
    table = np.array([warps.amplitude, warps.frequency, warps.start, warps.sign])
    out = np.empty(200)
    for fraction in np.linspace(0.0, 1.0, 21).tolist():
        warp_phases(out, fraction, table, 0.2)
        np.testing.assert_allclose(out, measure_warp(fraction, *table, 0.2), atol=1e-12)


def test_feet_stand_if_all_clips_have_contact():
    contact = np.array([[1, 0], [1, 1], [0, 1]], np.bool_)
    sample = np.array([[0, 1, 1, 1], [0, 0, 0, 2], [0, 2, 2, 1], [0, 0, 0, 0]], np.float64)
    share = np.zeros((5, 4), np.float32)
    share[INTO_NEXT] = 0.0, 0.5, 1.0, 0.0
    share[LOWER, 3] = 0.4
    out = np.empty((4, 2), np.bool_)
    lifted = np.zeros((4, 2, 3), np.float32)
    standing_feet(out, sample, 0.0, share, contact, lifted, 0, 4)
    np.testing.assert_array_equal(out, [[1, 0], [0, 1], [0, 1], [0, 1]])
    lifted[0, 0, 2] = 0.03  # a foot that its plan lifts does not stand
    standing_feet(out, sample, 0.0, share, contact, lifted, 0, 4)
    np.testing.assert_array_equal(out, [[0, 0], [0, 1], [0, 1], [0, 1]])
    standing_feet(out, sample, 1.0, share, contact, 0.0 * lifted, 1, 3)  # a sample later, and only some dancers
    np.testing.assert_array_equal(out, [[0, 0], [0, 1], [0, 1], [0, 1]])
    standing_feet(out, sample, 1.0, share, contact, 0.0 * lifted, 0, 1)
    np.testing.assert_array_equal(out[0], [1, 1])


def test_hips_need_neither_takes_nor_feet():
    own, then, phase = random_measures(1), random_measures(2), np.random.default_rng(3).uniform(0.7, 1.0, COUNT)
    hips = []
    for takes in (True, False):
        pipeline = PosePipeline(COUNT)
        gather_inputs(pipeline, own, then, phase, 0.9, goes_on=True, takes=takes)
        out = np.empty((COUNT, 2))
        clip_hips(out, np.arange(COUNT), pipeline.sample, pipeline.placement, pipeline.share, GRAPH.library.clip_root)
        hips.append(out)
    np.testing.assert_array_equal(hips[0], hips[1])


def test_phase_delay_is_limited_to_measure():
    chance = np.random.default_rng(6)
    warps = draw_measure_warps(chance, COUNT, window=0.2)
    table = np.array([warps.amplitude, warps.frequency, warps.start, warps.sign])
    ahead, before, late = chance.uniform(-0.1, 0.1, COUNT), *chance.uniform(0.0, 1.3, (2, COUNT))
    out, nobody = np.empty(COUNT), np.zeros(COUNT)
    for fraction in (0.0, 0.3, 1.0):
        lowest, highest = delay_phases(out, fraction, table, 0.2, ahead, before, late, nobody, 0.0)
        share = float(transition_weight(fraction))
        expected = measure_warp(fraction, *table, 0.2) + ahead - (1.0 - share) * before - share * late
        np.testing.assert_allclose(out, np.maximum(expected, -1.0), atol=1e-12)
        assert (lowest, highest) == (out.min(), out.max())


def test_clip_hips_match_for_any_rows():
    chance, pipeline, samples = np.random.default_rng(7), PosePipeline(COUNT), 50
    root = chance.normal(size=(samples, 3)).astype(np.float32)
    pipeline.sample[:] = chance.uniform(0.0, samples - 1.0, pipeline.sample.shape)
    pipeline.placement[:] = chance.normal(size=pipeline.placement.shape)
    pipeline.share[INTO_NEXT] = np.maximum(chance.uniform(-1.0, 1.0, COUNT), 0.0)

    def place(which, rows):
        hips = root[pipeline.sample[which, rows].astype(int)][:, ::2].astype(float)
        lies = pipeline.placement[which, rows]
        return lies[:, :2] + turn_vectors(hips, lies[:, 2])

    for rows in (np.arange(COUNT), np.array([3, 17, 20])):
        out = np.empty((len(rows), 2))
        clip_hips(out, rows, pipeline.sample, pipeline.placement, pipeline.share, root)
        into = pipeline.share[INTO_NEXT, rows][:, None]
        np.testing.assert_allclose(out, (1.0 - into) * place(PRESENT, rows) + into * place(NEXT, rows), atol=1e-6)


def test_changed_measure_updates_its_end():
    one = random_measures(3)
    before = one.own_end()[0].copy()
    one.node[4] = (one.node[4] + 1) % GRAPH.library.node_count
    fresh = random_measures(3)
    fresh.copy_from(one)
    fresh._ends = None
    np.testing.assert_array_equal(one.own_end()[0], fresh.own_end()[0])
    assert (one.own_end()[0] != before).any(axis=1).sum() == 1


def clearance_of(shares, heights):
    """CLEARANCE and its softness (A,) of a foot at `heights` (4,) [m] in the clips, with `shares` (5, A)."""
    count = shares.shape[1]
    feet = np.full((count, 2, FEET_COLUMNS), 7.0, np.float32)
    sample = np.tile(np.arange(4.0)[:, None], (1, count))
    set_clearance(feet, sample, shares.astype(np.float32), np.repeat(np.float32(heights)[:, None], 2, axis=1), 0, count)
    np.testing.assert_array_equal(feet[:, :, :CLEARANCE], 7.0)
    np.testing.assert_array_equal(feet[:, 0], feet[:, 1])
    return feet[:, 0, CLEARANCE], feet[:, 0, CLEARANCE_SOFTNESS]


def test_unblended_and_standing_feet_have_no_clearance():
    share = np.zeros((5, 3))
    share[INTO_NEXT] = 0.0, 1.0, 0.5
    share[NEXT_LOWER, 0] = 0.5  # of a clip that is not danced yet
    for heights in ([0.1, 0.2, 0.03, 0.2], [0.0, 0.3, 0.0, 0.3]):
        clear, soft = clearance_of(share[:, :2] if heights[0] else share, heights)
        np.testing.assert_array_equal(clear * soft, 0.0)
        np.testing.assert_array_equal(soft, 0.0)
    clear, _ = clearance_of(share, [0.0, 0.3, 0.0, 0.3])
    np.testing.assert_array_equal(clear, 0.0)


def test_blended_foot_reaches_height_of_highest_clip():
    share = np.zeros((5, 101))
    share[INTO_NEXT] = np.linspace(0.0, 1.0, 101)
    for heights in ([0.03, 0.0, 0.0, 0.0], [0.0, 0.0, 0.03, 0.0], [0.3, 0.0, 0.01, 0.0]):
        clear, soft = clearance_of(share, heights)
        blended = (1.0 - share[INTO_NEXT]) * heights[0] + share[INTO_NEXT] * heights[2]
        highest = max(heights) / np.sqrt(1.0 + (max(heights) / MAX_CLEARANCE) ** 2)
        assert clear.max() <= 1.2 * highest
        assert soft[0] == soft[-1] == 0.0
        middle = slice(26, 75)
        assert (clear[middle] > 0.99 * np.minimum(highest, blended[middle])).all()
        assert clear[middle] == pytest.approx(highest, rel=0.02)
        lifted = clear - blended  # as the legs do it
        lifted = blended + 0.5 * (lifted + np.sqrt(lifted * lifted + soft * soft))
        assert lifted[0] == pytest.approx(heights[0], abs=1e-6)
        assert lifted[-1] == pytest.approx(heights[2], abs=1e-6)
        assert np.abs(np.diff(lifted)).max() < 0.15 * max(heights)  # it is lifted, it does not jump


def test_mixed_takes_are_weighted_by_share():
    share = np.zeros((5, 3))
    share[LOWER] = 0.0, 0.5, 1.0
    clear, soft = clearance_of(share, [0.0, 0.04, 0.0, 0.0])
    assert soft[0] == soft[2] == 0.0
    assert clear[1] == pytest.approx(0.04 / np.sqrt(1.25), rel=1e-5)
    coming = np.zeros((5, 2))
    coming[INTO_NEXT], coming[NEXT_LOWER] = 0.5, (0.0, 0.5)
    clear, _ = clearance_of(coming, [0.0, 0.0, 0.0, 0.04])
    assert clear[0] == 0.0
    assert clear[1] == pytest.approx(0.04 / np.sqrt(1.25), rel=1e-5)
