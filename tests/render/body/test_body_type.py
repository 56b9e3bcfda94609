"""Tests of body types: different widths on the same skeleton."""

import numpy as np
import pytest

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.render.body.body_mesh import COARSE, LIGHT, build_body
from live.render.body.body_variants import TYPES, parts_of
from live.render.body.implicit_surface import BODY, Shape
from live.render.dancers.particle_points import build_points


def half_width(name, height):
    line = np.stack([np.linspace(0.0, 0.3, 301), np.full(301, height), np.zeros(301)], axis=1)
    return float(line[np.flatnonzero(Shape(parts_of(name)).distance(line) < 0.0).max(), 0])


def litres(name, level=COARSE):
    mesh = build_body(level, name)
    a, b, c = (mesh.position[mesh.triangle[:, corner]].astype(np.float64) for corner in range(3))
    return 1000.0 * float((np.cross(a, b) * c).sum()) / 6.0


def test_every_body_name_has_type_and_default_is_base_body():
    assert tuple(TYPES) == BODIES
    assert parts_of(DEFAULT_BODY) is BODY
    with pytest.raises(ValueError, match="body 'tall'"):
        parts_of("tall")


@pytest.mark.parametrize("name", BODIES)
def test_every_body_type_is_closed_with_equal_floor_and_reach(name):
    mesh = build_body(COARSE, name)
    edges = np.concatenate([mesh.triangle[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(edge) for edge in edges.tolist()} == {(b, a) for a, b in edges.tolist()}
    usual = build_body(COARSE)
    assert mesh.position[:, 1].min() == pytest.approx(usual.position[:, 1].min(), abs=0.006)
    assert mesh.position[:, 0].max() == pytest.approx(usual.position[:, 0].max(), abs=0.012)


def test_volumes_are_ordered_by_body_type():
    weight = {name: litres(name) for name in BODIES}
    assert weight["slim"] < 0.9 * weight[DEFAULT_BODY]
    assert weight["child"] < 0.92 * weight[DEFAULT_BODY]
    assert weight["strong"] > 1.12 * weight[DEFAULT_BODY]
    assert weight["round"] > 1.25 * weight[DEFAULT_BODY]


def test_widths_are_ordered_by_body_type():
    shoulders, waist = ({name: half_width(name, y) for name in BODIES} for y in (1.33, 1.06))
    assert shoulders["strong"] == max(shoulders.values())
    assert waist["round"] == max(waist.values())
    assert waist["slim"] == min(waist.values())
    assert waist["child"] / shoulders["child"] > 1.1 * waist[DEFAULT_BODY] / shoulders[DEFAULT_BODY]  # no waist yet


def test_particle_points_lie_on_skin_and_any_prefix_is_evenly_spread():
    points = build_points(1500)
    distance = np.abs(Shape(BODY).distance(points.position.astype(np.float64)))
    assert np.median(distance) < 0.004
    np.testing.assert_allclose(points.weight.sum(axis=1), 1.0, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=1), 1.0, atol=1e-5)
    for axis in range(3):
        first, all_ = (np.percentile(points.position[:count, axis], [20, 50, 80]) for count in (300, 1500))
        np.testing.assert_allclose(first, all_, atol=0.09)
    mesh = build_body(LIGHT)
    assert points.joint.max() <= mesh.joint.max()
