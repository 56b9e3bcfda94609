"""Kernels of garments against an independent XPBD in numpy, and laws of mechanics."""

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.motion.cloth.body_sections import LIMBS
from live.motion.cloth.cloth_kernels import AT_MOST, EXACT, project_runs
from live.motion.cloth.contact_kernels import keep_out
from live.motion.cloth.garment_batch import limb_rows
from live.motion.cloth.limb_kernels import LANES, interpolate_joints
from live.motion.cloth.pattern import Pattern
from live.motion.skeleton import SKELETON
from live.render.body.body_limbs import body_sections
from live.render.body.body_variants import parts_of
from live.render.body.implicit_surface import Shape
from tests.motion.cloth.cloth_bodies import STILL, dressed, posed


def random_places(count, seed=1):
    return np.random.default_rng(seed).normal(0.0, 0.3, (3, count * LANES)).astype(np.float32)


def test_runs_are_projected_as_xpbd_says():
    """Against the formulas of Macklin et al. (2016) with one iteration, one constraint after the other."""
    places = random_places(8)
    runs = np.array([(EXACT, 0, 2, 2), (AT_MOST, 2, 4, 2), (EXACT, 4, 6, 2)], np.int32)
    amounts = np.array([(0.2, 1e-5, 1.0, 1.0), (0.1, 0.0, 0.0, 1.0), (0.3, 3e-6, 1.0, 0.5)], np.float32)
    per_step = 192.0**2
    x = places.reshape(3, 8, LANES).astype(np.float64)
    for (kind, first, second, count), (rest, compliance, wa, wb) in zip(runs.tolist(), amounts.tolist(), strict=True):
        a, b = x[:, first : first + count].copy(), x[:, second : second + count].copy()
        length = np.linalg.norm(b - a, axis=0)
        error = length - rest
        error = np.maximum(error, 0.0) if kind == AT_MOST else error
        push = (error / (wa + wb + compliance * per_step) / length) * (b - a)
        x[:, first : first + count] = a + wa * push
        x[:, second : second + count] = b - wb * push
    project_runs(places, runs, amounts, np.float32(per_step))
    assert np.abs(places.reshape(3, 8, LANES) - x).max() < 2e-6


def test_constraints_between_free_particles_keep_momentum():
    places = random_places(40, seed=3)
    before = places.reshape(3, 40, LANES).astype(np.float64).sum(axis=1)
    runs = np.array([(EXACT, 0, 20, 20), (EXACT, 10, 11, 1), (AT_MOST, 5, 25, 10)], np.int32)
    amounts = np.array([(0.2, 0.0, 1.0, 1.0), (0.1, 1e-5, 1.0, 1.0), (0.05, 0.0, 1.0, 1.0)], np.float32)
    project_runs(places, runs, amounts, np.float32(1e4))
    after = places.reshape(3, 40, LANES).astype(np.float64).sum(axis=1)
    assert np.abs(after - before).max() < 1e-5


def test_what_has_its_length_stays():
    places = np.zeros((3, 2 * LANES), np.float32)
    places[0, LANES:] = 0.5
    runs, amounts = np.array([(EXACT, 0, 1, 1)], np.int32), np.array([(0.5, 0.0, 1.0, 1.0)], np.float32)
    still = places.copy()
    project_runs(places, runs, amounts, np.float32(1e4))
    assert np.array_equal(places, still)


def ribbon(**changes):
    """A strip of 2 by 5 particles that hangs from the hips, far from the body, and touches nothing."""
    rows = 5
    shape = np.zeros((rows, 2, 3))
    shape[:, :, 1] = 1.4 - 0.1 * np.arange(rows)[:, None]
    shape[:, :, 0] = 1.0 + 0.05 * np.arange(2)
    values = {
        "name": "strip", "kind": "cloth", "rows": rows, "columns": 2, "closed": False, "pinned_rows": 1, "length": 0.4,
        "widths": (0.05,) * rows, "joints": ("hips",), "rest_shape": lambda sections: shape,
        "share": ((0.0, 0.0),) * rows, "second": ((0, 0),) * rows, "contacts": (), "sheared": False,
    }  # fmt: skip
    return Pattern(**(values | changes))


def reference(steps, substeps, matter, runs, limits, last, start, pins, wind=(0.0, 0.0, 0.0)):
    """The whole simulation in plain numpy: particles (P, 3), one after the other, double precision."""
    x, v, h = start.copy(), np.zeros_like(start), TICK / substeps

    def project(constraints):
        for (kind, first, second, count), (rest, compliance, wa, wb) in constraints:
            for a, b in zip(range(first, first + count), range(second, second + count), strict=True):
                way = x[b] - x[a]
                length = np.linalg.norm(way)
                error = length - rest if kind == EXACT else max(length - rest, 0.0)
                push = error / (wa + wb + compliance / h**2) * way / length
                x[a] += wa * push
                x[b] -= wb * push

    kept = 1.0 / (1.0 + matter[0] * h)
    for _ in range(steps):
        for s in range(substeps):
            old = x.copy()
            v *= kept
            v += (1.0 - kept) * np.array(wind)
            v[:, 1] -= matter[1] * h
            x += h * v
            x[: len(pins)] = pins
            project(runs)
            if s == substeps - 1:
                project(last)
            else:
                project(limits)
            v = (x - old) / h
    return x


def test_hanging_strip_moves_as_an_independent_simulation_in_numpy():
    batch = dressed("", pattern=ribbon())
    position, rotation = posed()
    wind = np.array([2.0, 0.0, 1.0], np.float32)
    batch.tick(position, rotation, wind, 3, TICK)  # begins
    one = batch.compiled
    x0 = batch.position[0, :, :, 0].T.astype(np.float64)
    batch.velocity[:] = 0.0

    def rows(runs, amounts):
        return list(zip(runs.tolist(), amounts.astype(np.float64).tolist(), strict=True))

    for _ in range(40):
        batch.tick(position, rotation, wind, 3, TICK)
    wanted = reference(
        40, 3, one.matter.astype(np.float64), rows(one.runs, one.amounts), rows(one.limit_runs, one.limits),
        rows(one.last_runs, one.last_limits), x0, x0[:2], wind,
    )  # fmt: skip
    found = batch.position[0, :, :, 0].T
    assert np.abs(found - x0).max() > 0.1  # the wind has moved it
    assert np.abs(found - wanted).max() < 2e-3


def test_free_fall_of_what_nothing_holds():
    """With pins that fall as well, a strip is weightless: it falls with g and keeps its shape."""
    batch = dressed("", pattern=ribbon())
    batch.compiled.matter[:] = 0.0, 9.81, 0.0, -100.0, 0.0, 0.0, 0.0  # no air, no floor
    for tick in range(20):
        drop = -0.5 * 9.81 * (tick * TICK) ** 2
        position, rotation = posed(lift=drop)
        batch.tick(position, rotation, STILL, 4, TICK)
    shape = batch.position[0, :, :, 0].T
    fallen = 0.5 * 9.81 * (19 * TICK) ** 2
    rest = np.array([1.4 - 0.1 * row for row in range(5) for _ in range(2)])
    lowered = rest[:, None] + (position[0, 0, 1] - posed()[0][0, 0, 1]) - shape[:, 1:2]
    offset = lowered - lowered[0]
    assert fallen > 0.4
    assert np.abs(offset).max() < 0.012  # the steps of the pins are not those of the fall within a substep


@pytest.mark.long
@pytest.mark.parametrize("body", ["dancer", "slim", "strong", "round", "child"])
def test_contact_brings_points_out_of_the_body_that_is_drawn(body):
    """Points inside the trunk, legs and head of the implicit surface are outside of it afterwards."""
    chance, shape = np.random.default_rng(5), Shape(parts_of(body))
    points = chance.uniform((-0.2, 0.1, -0.15), (0.2, 1.65, 0.15), (40_000, 3))
    inside = points[shape.distance(points) < -0.001]
    inside = inside[np.abs(inside[:, 0]) > 0.01]
    count = len(inside) // LANES // 24 * 24
    places = np.ascontiguousarray(inside[: count * LANES].T, np.float32)
    rows = limb_rows(body_sections(body))[:, :, None]
    limbs = np.repeat(rows, LANES, axis=2)
    rest = SKELETON.rest_positions()
    for k, limb in enumerate(LIMBS):
        limbs[:3, k] += rest[limb.joint][:, None]
    contacts = np.array([(row * 24, 24, k, 0) for k in range(len(LIMBS)) for row in range(count // 24)], np.int32)
    for _ in range(6):
        keep_out(places, contacts, np.ascontiguousarray(limbs), np.float32(0.014))
    depth = shape.distance(places.T.astype(np.float64))
    assert count > 500
    assert np.mean(depth < -0.005) < 0.02
    assert depth.min() > -0.035


def test_points_far_from_the_body_are_left_alone():
    places = random_places(24, seed=7) + np.float32(5.0)
    rows = np.ascontiguousarray(np.repeat(limb_rows(body_sections("dancer"))[:, :, None], LANES, axis=2))
    before = places.copy()
    keep_out(places, np.array([(0, 24, k, 2) for k in range(rows.shape[1])], np.int32), rows, np.float32(0.01))
    assert np.array_equal(places, before)


def test_joints_between_two_ticks_turn_evenly():
    first, second = np.zeros((2, 7, 1, LANES), np.float32)
    first[3] = 1.0
    angle = 0.6
    second[3], second[5], second[0] = np.cos(0.5 * angle), np.sin(0.5 * angle), 2.0
    out = np.zeros((12, 1, LANES), np.float32)
    interpolate_joints(first, second, np.float32(0.5), out)
    assert out[0, 0, 0] == pytest.approx(1.0)
    assert out[3, 0, 0] == pytest.approx(np.cos(0.5 * angle), abs=1e-4)
    assert out[5, 0, 0] == pytest.approx(np.sin(0.5 * angle), abs=1e-4)
    interpolate_joints(
        first, -second * np.array([-1, 1, 1, 1, 1, 1, 1], np.float32)[:, None, None], np.float32(0.5), out
    )
    assert out[3, 0, 0] == pytest.approx(np.cos(0.5 * angle), abs=1e-4)  # the shorter way, whatever the sign
