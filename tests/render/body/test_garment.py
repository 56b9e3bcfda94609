"""Loose clothes: cut cleanly along their hems, off the skin everywhere, moved by the joints below them."""

import numpy as np
import pytest

from live.base.body.appearance import COSTUMES, DEFAULT_APPEARANCE, HAIR, HAIRS, SHOES
from live.base.body.catalogue import BODIES
from live.base.stage_snapshot import Camera, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.body.body_lookup import FAMILIES, kinds_of, pieces_of
from live.render.body.body_mesh import CLOSE, COARSE, DISTANT, FINE, LIGHT, build_body
from live.render.body.body_variants import trunk_of
from live.render.body.garment_mesh import GARMENTS, MAX_LIFT, build_garment, cut_mesh
from live.render.body.implicit_surface import Shape
from live.render.body.mesh_simplify import mirror_partners
from live.render.body.surface_parts import CLOTH, SECOND_CLOTH, SHIRT
from tests.fixtures.mostly_long import mostly_long

CHORD_M = {LIGHT: 0.018, CLOSE: 0.018, FINE: 0.002}
"""How far the triangles of a body at a level lie within its smooth surface at most [m], at the feet."""
DRAWN = [(level, name) for level in (LIGHT, CLOSE, FINE) for name in GARMENTS]


def test_every_shell_belongs_to_a_costume_or_to_shoes() -> None:
    assert set(GARMENTS) <= {*COSTUMES, *SHOES}
    for level in (COARSE, DISTANT):
        assert len(build_garment(level, "dancer", "jacket").triangle) == 0
    assert len(build_garment(FINE, "dancer", "leotard").triangle) == 0


def test_cut_keeps_the_area_on_one_side_of_the_line() -> None:
    count = 24
    x, y = np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count))
    rows = np.column_stack([x.ravel(), y.ravel(), np.zeros(count * count)])
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = np.concatenate(
        [
            np.column_stack([corner, corner + 1, corner + count]),
            np.column_stack([corner + 1, corner + count + 1, corner + count]),
        ]
    )
    kept, faces, hem = cut_mesh(rows, triangles, lambda place: 0.3 - place[:, 0] - 0.5 * place[:, 1])
    a, b, c = (kept[faces[:, at]] for at in range(3))
    area = 0.5 * np.cross(b - a, c - a)[:, 2]
    assert (area > -1e-12).all()  # nothing is turned over
    # by hand: the line crosses y = -1 at x = 0.8 and y = 1 at x = -0.2
    assert area.sum() == pytest.approx(0.5 * ((0.8 + 1.0) + (-0.2 + 1.0)) * 2.0, rel=1e-9)
    ends = kept[hem]
    np.testing.assert_allclose(0.3 - ends[..., 0] - 0.5 * ends[..., 1], 0.0, atol=1e-12)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(np.hypot(1.0, 2.0), rel=1e-9)


@pytest.mark.parametrize(("level", "name"), DRAWN)
def test_shell_lies_off_the_skin_and_near_it(level, name) -> None:
    mesh = build_garment(level, "dancer", name)
    assert 20 < len(mesh.triangle) < 3 * len(build_body(level).triangle)
    distance = Shape(trunk_of("dancer")).distance(mesh.position.astype(np.float64))
    assert distance.min() > -CHORD_M[CLOSE if name in SHOES else level]
    assert distance.max() < MAX_LIFT + 0.01
    assert (distance > 0.002).mean() > (0.5 if name in ("jacket", "trousers") else 0.1)
    assert mesh.position[:, 1].min() >= -1e-6
    np.testing.assert_allclose(mesh.weight.sum(axis=1), 1.0, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(mesh.normal, axis=1), 1.0, atol=1e-4)


@mostly_long("body", BODIES, quick=[0, 8])
def test_shells_fit_every_body(body) -> None:
    shape = Shape(trunk_of(body))
    for name in GARMENTS:
        mesh = build_garment(FINE, body, name)
        distance = shape.distance(mesh.position.astype(np.float64))
        assert distance.min() > -CHORD_M[CLOSE if name in SHOES else FINE], name


def test_jacket_is_symmetric_and_open_over_the_breast() -> None:
    mesh = build_garment(FINE, "dancer", "jacket")
    mirrored = mesh.position * np.array([-1.0, 1.0, 1.0], np.float32)
    partner = mirror_partners(mesh.position.astype(np.float64))
    nearest = np.linalg.norm(mirrored - mesh.position[partner], axis=1)
    assert np.median(nearest) < 1e-3
    in_front = (mesh.place[:, 2] > 0.03) & (mesh.part == CLOTH)
    opening = in_front & (np.abs(mesh.place[:, 0]) < 0.03)
    assert not (opening & (mesh.place[:, 1] > 1.25)).any()
    assert (opening & (mesh.place[:, 1] < 1.0)).any()


@mostly_long("level", [LIGHT, CLOSE, FINE], quick=[0, 1])
def test_lapels_and_collars_lie_on_the_jacket(level) -> None:
    mesh, shape = build_garment(level, "man", "jacket"), Shape(trunk_of("man"))
    distance = shape.distance(mesh.position.astype(np.float64))
    side, height, front = np.abs(mesh.place[:, 0]), mesh.place[:, 1], mesh.place[:, 2] > 0.03
    breast = front & (side > 0.02) & (side < 0.12) & (height > 1.12) & (height < 1.36)

    def median(chosen) -> float:
        raised = distance[chosen & (distance > 0.004)]  # without the hems on the skin
        return float(np.median(raised))

    jacket, lapels = (median(breast & (mesh.part == part)) for part in (CLOTH, SECOND_CLOTH))
    assert level == LIGHT or 0.003 < lapels - jacket < 0.012  # large triangles lie deep in the skin
    collar = (mesh.part == SECOND_CLOTH) & (height > 1.40)
    assert (collar & (mesh.place[:, 2] < -0.03)).any()  # it goes around the neck
    shirt = mesh.part == SHIRT
    assert shirt.any()
    assert side[shirt].max() < 0.08
    assert height[shirt].min() > 1.38


def test_men_have_short_hair_unless_another_is_said() -> None:
    scene = Scene((8.0, 6.0), Camera(), 2, JOINT_COUNT, bodies=("woman", "man"))
    kinds, rows = kinds_of(scene), np.tile(DEFAULT_APPEARANCE, (2, 1)).astype(np.int32)
    for said, worn in (("usual", ("bun", "crop")), ("bun", ("bun", "bun")), ("long", ("long", "long"))):
        rows[:, HAIR] = HAIRS.index(said)
        pieces = pieces_of(kinds, scene, rows)[:, FAMILIES.index("hair")]
        assert tuple(HAIRS[kinds[kind].style] for kind in pieces) == worn
