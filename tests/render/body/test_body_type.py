"""Tests of body types: different widths on the same skeleton."""

import numpy as np
import pytest

from live.base.body.catalogue import BODIES, DEFAULT_BODY, MEN
from live.render.body.body_lookup import build_figure
from live.render.body.body_mesh import COARSE, LIGHT, build_body
from live.render.body.body_parts import BODY
from live.render.body.body_variants import TYPES, parts_of
from live.render.body.implicit_surface import Shape
from live.render.dancers.particle_points import build_points

WOMEN = (DEFAULT_BODY, "woman", "slim")


def half_width(name, height):
    line = np.stack([np.linspace(0.0, 0.3, 301), np.full(301, height), np.zeros(301)], axis=1)
    return float(line[np.flatnonzero(Shape(parts_of(name)).distance(line) < 0.0).max(), 0])


def litres(name, level=COARSE):
    mesh = build_body(level, name)
    a, b, c = (mesh.position[mesh.triangle[:, corner]].astype(np.float64) for corner in range(3))
    return 1000.0 * float((np.cross(a, b) * c).sum()) / 6.0


def test_every_body_name_has_type_and_default_is_base_body():
    assert tuple(TYPES) == BODIES
    assert parts_of(DEFAULT_BODY) == BODY
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


def girth(name, height):
    """Length around the body at a height, without the arms [m]."""
    shape = Shape(parts_of(name))
    around = np.linspace(0.0, np.pi, 91)
    way = np.linspace(0.0, 0.35, 351)
    total, last = 0.0, None
    for angle in around:
        line = np.stack([way * np.sin(angle), np.full(351, height), way * np.cos(angle)], axis=1)
        inside = line[np.flatnonzero(shape.distance(line) < 0.0).max()]
        total += 0.0 if last is None else float(np.linalg.norm(inside - last))
        last = inside
    return 2.0 * total


def waist_to_hip(name):
    return min(girth(name, y) for y in (1.02, 1.05, 1.08)) / max(girth(name, y) for y in (0.84, 0.87, 0.90))


@pytest.mark.long
def test_waists_are_those_of_women_and_men():
    """Waist to hip of young adults is about 0.7 to 0.8 for women and 0.8 to 0.95 for men, more with age (WHO 2008,
    waist circumference and waist-hip ratio: at risk above 0.85 and 0.90)."""
    ratio = {name: waist_to_hip(name) for name in BODIES}
    for name in WOMEN:
        assert 0.64 < ratio[name] < 0.82, ratio
    for name in ("man", "strong"):
        assert 0.78 < ratio[name] < 0.95, ratio
    assert ratio["older woman"] > 1.05 * ratio["woman"]
    assert ratio["older man"] > 1.05 * ratio["man"]
    assert ratio["child"] > 1.05 * ratio[DEFAULT_BODY]
    assert ratio["man"] > 1.08 * ratio["woman"]


def test_men_have_broader_chests_for_their_hips_than_women():
    """Chest breadth to hip breadth is larger for men (ANSUR II, Gordon et al. 2014)."""
    ratio = {name: half_width(name, 1.24) / half_width(name, 0.84) for name in BODIES}
    assert min(ratio[name] for name in MEN) > 1.08 * max(ratio[name] for name in WOMEN), ratio


def test_women_have_breasts():
    """Below the breast a woman's chest falls back by more than a man's or a child's."""

    def fall(name):
        heights = (1.25, 1.17)
        lines = [np.stack([np.full(301, 0.06), np.full(301, y), np.linspace(0.0, 0.3, 301)], axis=1) for y in heights]
        most, least = (line[np.flatnonzero(Shape(parts_of(name)).distance(line) < 0.0).max(), 2] for line in lines)
        return float(most - least)

    assert min(map(fall, WOMEN)) > max(map(fall, ("man", "strong", "child")))


def test_particle_points_lie_on_skin_and_any_prefix_is_evenly_spread():
    points = build_points(1500)
    distance = np.abs(
        Shape(parts_of(DEFAULT_BODY, toes=False, details=False)).distance(points.position.astype(np.float64))
    )
    assert np.median(distance) < 0.005
    np.testing.assert_allclose(points.weight.sum(axis=1), 1.0, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=1), 1.0, atol=1e-5)
    for axis in range(3):
        first, all_ = (np.percentile(points.position[:count, axis], [20, 50, 80]) for count in (300, 1500))
        np.testing.assert_allclose(first, all_, atol=0.09)
    assert points.joint.max() <= build_figure(LIGHT).joint.max()
