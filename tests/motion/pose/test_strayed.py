"""Tests of corrections that follow deviating agents, against whole-array formulas."""

import numpy as np

from live.motion.pose.root_warp_kernels import (
    AGENT_AT_DECISION,
    AGENT_LEAD,
    AIM,
    AIM_SPEED,
    BEGIN,
    DESIRED,
    END,
    GOAL,
    PLAN,
    ROWS,
    clamp_ends,
    compute_references,
    desire_corrections,
    follow_goals,
)
from live.motion.pose.warp_curve_kernels import KNOTS

COUNT = 50


def random_rows(seed=5):
    chance = np.random.default_rng(seed)
    return chance, chance.normal(0.0, 0.5, (ROWS, COUNT, 2))


def test_correction_follows_deviation_by_obedience():
    chance, rows = random_rows()
    position, shown = chance.normal(0.0, 1.0, (2, COUNT, 2)).astype(np.float32)
    obedience, late = chance.uniform(0.0, 1.0, COUNT), np.where(np.arange(COUNT) % 5 == 0, 0.4, 0.0)
    desire_corrections(rows, position, obedience, late, shown, 0.3, 0.08, 0.6, 0, COUNT)
    plan, passed = rows[END] + rows[PLAN], (0.3 / (1.0 + late))[:, None]
    bound = np.where(late[:, None] > 0.0, shown, rows[BEGIN] + passed * (plan - rows[BEGIN]))
    # from where agents were to where they were foreseen, unless their leash is shorter
    foreseen = (
        rows[BEGIN] + rows[AGENT_LEAD] + passed * (rows[AGENT_AT_DECISION] - rows[BEGIN] - rows[AGENT_LEAD]) - bound
    )
    foreseen *= np.minimum(1.0, 0.6 / np.linalg.norm(foreseen, axis=1))[:, None]
    stray = position - bound - foreseen
    size = np.linalg.norm(stray, axis=1)
    expected = stray * (obedience * np.maximum(size - 0.08, 0.0) / size)[:, None]
    np.testing.assert_allclose(rows[DESIRED] - rows[PLAN], expected, atol=1e-6)


def test_predicted_agent_motion_causes_no_correction():
    _, rows = random_rows()
    rows[AGENT_LEAD] *= 0.2
    rows[AGENT_AT_DECISION] = rows[END] + rows[PLAN] + rows[AGENT_LEAD]
    late = np.linspace(0.0, 0.9, COUNT)
    for fraction in (0.0, 0.3, 0.8):
        passed = (fraction / (1.0 + late))[:, None]
        position = rows[BEGIN] + rows[AGENT_LEAD] + passed * (rows[AGENT_AT_DECISION] - rows[BEGIN] - rows[AGENT_LEAD])
        shown = (position - 0.4 * rows[AGENT_LEAD]).astype(np.float32)  # anywhere within the leash
        desire_corrections(
            rows, position.astype(np.float32), np.ones(COUNT), late, shown, fraction, 0.08, 0.6, 0, COUNT
        )
        np.testing.assert_array_equal(rows[DESIRED], rows[PLAN])


def test_ends_of_present_dancers_stay_on_stage():
    chance, _ = random_rows()
    end, way = chance.uniform(-8.0, 8.0, (COUNT, 2)), chance.normal(0.0, 1.0, (COUNT, 2))
    state, before = (np.arange(COUNT) % 2).astype(np.int8), way.copy()
    room = np.tile([6.0, 4.0], (COUNT, 1))
    clamp_ends(way, end, state, 1, room)
    there = state == 1
    np.testing.assert_allclose((end + way)[there], np.clip(end + before, (-6.0, -4.0), (6.0, 4.0))[there], atol=1e-12)
    np.testing.assert_array_equal(way[~there], before[~there])


def test_corrections_reach_goals_without_overshoot():
    _, rows = random_rows()
    rows[AIM], rows[AIM_SPEED], rows[GOAL] = 0.0, 0.0, 0.3
    rise = np.zeros((1, KNOTS, 2))
    rise[0] = np.column_stack([np.linspace(0.0, 1.0, KNOTS), np.ones(KNOTS)])
    correction, aimed, phase = np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros(COUNT)
    foot_aim, feet = np.zeros((COUNT, 2, 6)), np.zeros((1, 2, KNOTS, 5))
    way = []
    for _ in range(64):
        node = np.zeros(COUNT, np.int32)
        follow_goals(rows, correction, aimed, foot_aim, phase, node, rise, feet, 14.0, 1.0 / 64.0, 0.15, 0, COUNT)
        way.append(correction[:, 0].copy())
    way = np.array(way)
    assert (np.diff(way, axis=0) > 0.0).all()
    assert way.max() <= 0.3
    np.testing.assert_allclose(way[-1], 0.3 * (1.0 - 15.0 * np.exp(-14.0)), atol=1e-9)  # critically damped, after 1 s


def test_references_are_linear_or_follow_late_dancers():
    chance, rows = random_rows()
    correction, shown = chance.normal(0.0, 0.2, (COUNT, 3)), chance.normal(0.0, 1.0, (COUNT, 2)).astype(np.float32)
    late = np.where(np.arange(COUNT) % 3 == 0, 0.2, 0.0)
    reference, pace = np.zeros((2, COUNT, 2), np.float32)
    compute_references(reference, pace, rows, correction, 0.25, 0.5, late, shown)
    way, on_time = rows[END] + correction[:, :2] - rows[BEGIN], late == 0.0
    np.testing.assert_allclose(reference[on_time], (rows[BEGIN] + 0.25 * way)[on_time], atol=1e-6)
    np.testing.assert_allclose(pace[on_time], 0.5 * way[on_time], atol=1e-6)
    np.testing.assert_array_equal(reference[~on_time], shown[~on_time])
    assert not pace[~on_time].any()
