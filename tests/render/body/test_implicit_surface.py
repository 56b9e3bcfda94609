"""The field of implicit surfaces against the same field in numpy, part by part; rays against a search of all places."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from live.base.body.catalogue import BODIES
from live.render.body.body_variants import parts_of, toes_of
from live.render.body.implicit_surface import Ellipsoid, Loft, Shape
from tests.fixtures.mostly_long import mostly_long

BLOB = (
    Loft((0.1, 1.0, 0.0), (0.1, 0.2, 0.02), (1.0, 0.0, 0.0),
         ((0.0, 0.09, 0.10, 0.11, 0.0), (0.3, 0.07, 0.09, 0.06, 0.01), (0.6, 0.08, 0.08, 0.10, -0.01),
          (1.0, 0.04, 0.05, 0.05, 0.0)), 0.03),
    Loft((0.1, 0.15, -0.05), (0.1, 0.02, 0.15), (1.0, 0.0, 0.0), ((0.0, 0.05, 0.04, 0.05, 0.0),
         (1.0, 0.03, 0.02, 0.03, 0.0)), 0.02),
    Ellipsoid((0.1, 1.1, 0.0), (0.10, 0.14, 0.12), 0.05, pitch_deg=20.0, roll_deg=-35.0),
    Ellipsoid((0.15, 1.1, 0.1), (0.02, 0.03, 0.02), 0.01, hollow=True),
    Ellipsoid((0.0, 0.7, 0.05), (0.05, 0.05, 0.05), 0.0),
)  # fmt: skip


def of_ellipsoid(unit, radii):
    k0, k1 = np.linalg.norm(unit, axis=1), np.linalg.norm(unit / radii, axis=1)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)


def turned(points, degrees, one, other):
    """Return points turned from axis `one` to axis `other`."""
    angle = np.deg2rad(degrees)
    out = points.copy()
    out[:, one] = np.cos(angle) * points[:, one] - np.sin(angle) * points[:, other]
    out[:, other] = np.sin(angle) * points[:, one] + np.cos(angle) * points[:, other]
    return out


def of_loft(part, points):
    start, end = np.array(part.start), np.array(part.end)
    length = np.linalg.norm(end - start)
    along = (end - start) / length
    across = np.array(part.across) - along * np.dot(part.across, along)
    across /= np.linalg.norm(across)
    front = np.cross(across, along)
    front *= np.sign(front[2] if abs(front[2]) > abs(front[1]) else front[1])
    a, b, c = ((points - start) @ axis for axis in (along, across, front))
    rows = np.array(part.rows)
    places = np.linspace(0.0, 1.0, 65)
    samples = PchipInterpolator(rows[:, 0], rows[:, 1:])(places)
    held = np.clip(a / length, 0.0, 1.0)
    wide, before, behind, shift = (np.interp(held, places, column) for column in samples.T)
    c = c - shift
    thick = np.where(c > 0.0, before, behind)
    radii = np.stack([np.minimum(wide, thick), wide, thick], axis=1)
    return of_ellipsoid(np.stack([a - held * length, b, c], axis=1) / radii, radii)


def blended(a, b, width):
    if width == 0.0:
        return np.minimum(a, b)
    return np.minimum(a, b) - np.maximum(width - np.abs(a - b), 0.0) ** 2 / width * 0.25


def field(parts, points):
    """Return the distances of points from parts, none of which is left out where it is far away."""
    mirrored = np.abs(points) * (1.0, 0.0, 0.0) + points * (0.0, 1.0, 1.0)
    total = np.full(len(points), np.inf)
    for part in parts:
        if isinstance(part, Loft):
            own = of_loft(part, mirrored)
        else:
            radii = np.array(part.radii)
            local = turned(turned(mirrored - part.centre, -part.roll_deg, 0, 1), part.pitch_deg, 1, 2)
            own = of_ellipsoid(local / radii, radii)
        if part.hollow:
            total = -blended(-total, own, part.blend)
        else:
            total = blended(total, own, part.blend)
    return np.maximum(total, -points[:, 1])


def near_skin(parts, count, within):
    points = np.random.default_rng(3).uniform((-0.4, -0.1, -0.3), (0.4, 1.4, 0.3), (count, 3))
    return points[np.abs(field(parts, points)) < within]


def test_field_near_skin_is_that_of_numpy():
    points = near_skin(BLOB, 400, 0.04)
    assert len(points) > 30
    np.testing.assert_allclose(Shape(BLOB).distance(points), field(BLOB, points), atol=1e-12)


def test_skin_is_where_a_sphere_has_it():
    points = np.random.default_rng(4).normal(size=(50, 3)) * 0.1 + (0.0, 1.0, 0.0)
    ball = Shape((Ellipsoid((0.0, 1.0, 0.0), (0.1, 0.1, 0.1), 0.0),))
    away = np.linalg.norm(points - (0.0, 1.0, 0.0), axis=1)
    np.testing.assert_allclose(ball.distance(points), away - 0.1, atol=1e-12)
    out = (points - (0.0, 1.0, 0.0)) / away[:, None]
    np.testing.assert_allclose(ball.normal(points[away > 0.05]), out[away > 0.05], atol=1e-3)


def test_mirrored_points_have_the_same_distance_and_soles_are_flat():
    points = near_skin(BLOB, 200, 0.1)
    shape = Shape(BLOB)
    assert np.array_equal(shape.distance(points), shape.distance(points * (-1.0, 1.0, 1.0)))
    low = Shape((Ellipsoid((0.0, 0.05, 0.0), (0.1, 0.1, 0.1), 0.0),))
    assert low.distance(np.array([[0.0, -0.02, 0.0], [0.0, 0.001, 0.0]])) == pytest.approx([0.02, -0.001])


def test_points_that_are_no_numbers_stay_within_the_table():
    odd = np.array([[np.nan, 1.0, 0.0], [0.0, np.inf, 0.0], [0.0, 1.0, -np.inf]])
    assert Shape(BLOB).distance(odd).shape == (3,)


def test_shape_needs_parts():
    with pytest.raises(ValueError, match="part"):
        Shape(())


def test_first_place_outside_is_that_of_a_search():
    reach = np.linspace(0.0, 0.2, 41)
    origins = np.array([[0.1, y, 0.0] for y in (1.1, 0.8, 0.5, 0.3)])
    for way in np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.6, -0.8]]):
        expected = [(Shape(BLOB).distance(at + reach[:, None] * way) > 0.0).argmax() for at in origins]
        assert Shape(BLOB).first_outside(origins, way, reach).tolist() == expected
    assert Shape(BLOB).first_outside(origins[:1], np.array([0.0, -1.0, 0.0]), reach).tolist() == [40]


@mostly_long("name", BODIES, quick=[0, 8])
def test_bodies_have_the_field_and_the_width_of_numpy(name):
    parts = parts_of(name)
    shape = Shape(parts)
    points = near_skin(parts, 9000, 0.004)
    away = np.abs(shape.distance(points) - field(parts, points))  # what is far away is left out
    assert len(points) > 50
    assert np.median(away) < 1e-12
    assert away.max() < 2e-4
    reach = np.linspace(0.0, 0.32, 321)
    origins = np.array([[0.0, y, 0.0] for y in np.linspace(0.9, 1.4, 15)])
    way = np.array([1.0, 0.0, 0.0])
    outside = shape.distance((origins[:, None] + reach[:, None] * way).reshape(-1, 3)).reshape(15, -1) > 0.0
    expected = np.where(outside.any(axis=1), outside.argmax(axis=1), 320)
    assert np.array_equal(shape.first_outside(origins, way, reach), expected)


@pytest.mark.parametrize("name", BODIES)
def test_toes_and_limbs_have_the_cross_sections_of_scipy(name):
    lofts = [replace(part, hollow=False) for part in (*parts_of(name), *toes_of(name)) if isinstance(part, Loft)]
    points = np.random.default_rng(5).uniform(-0.3, 0.3, (200, 3))
    for loft in lofts:
        around = np.abs(points + (np.array(loft.start) + loft.end) / 2.0)
        np.testing.assert_allclose(Shape((loft,)).distance(around), field((loft,), around), atol=1e-10)
