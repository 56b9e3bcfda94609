"""Hair styles: closed meshes that cover the scalp of every face, and the pieces that dancers are drawn in."""

import numpy as np
import pytest

from live.base.body.appearance import BODY, DEFAULT_APPEARANCE, HAIR, HAIRS
from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.stage_snapshot import Camera, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.body.body_lookup import FAMILIES, bodies_of, build_figure, kinds_of, pieces_of
from live.render.body.body_mesh import CLOSE, COARSE, FINE, LEVELS, LIGHT, skeleton_weights
from live.render.body.body_variants import trunk_of
from live.render.body.face_shape import FACE_COUNT
from live.render.body.hair_mesh import build_hair
from live.render.body.head_mesh import build_head
from live.render.body.implicit_surface import Shape
from live.render.body.surface_parts import FACE, PAINTED_FACE
from tests.fixtures.mostly_long import mostly_long
from tests.render.body.test_head import _is_closed, _volume

MIDDLE = np.array([0.0, 1.625, -0.010])


@pytest.mark.parametrize("style", HAIRS[1:])
def test_every_style_is_closed_at_every_level(style) -> None:
    for level in LEVELS:
        mesh = build_hair(level, DEFAULT_BODY, style)
        if style == "bald" or (level == COARSE and style == "crop"):  # no thicker than the coarse skull
            assert len(mesh.triangle) == 0
        else:
            assert _is_closed(mesh.triangle)
            assert _volume(mesh) > 0.0
    assert len(build_hair(LIGHT, DEFAULT_BODY, style).triangle) <= 260
    assert len(build_hair(FINE, DEFAULT_BODY, style).triangle) <= 2200


@mostly_long("body", BODIES, quick=[0, 3, 4, 8])
@mostly_long("level", [LIGHT, CLOSE, FINE], quick=[0])
def test_hair_covers_the_scalp_of_every_face(level, body) -> None:
    """Along each ray from the middle of the skull through the top of the head, hair lies beyond the skin."""
    for style in ("bun", "crop", "long"):
        hair = build_hair(level, body, style)
        a, b, c = (hair.position[hair.triangle[:, k]].astype(np.float64) - MIDDLE for k in range(3))
        for face in range(FACE_COUNT):
            head = build_head(level, body, face)
            scalp = np.isin(head.part, (FACE, PAINTED_FACE)) & (head.place[:, 1] > 1.672)
            for point in head.position[scalp].astype(np.float64) - MIDDLE:
                far = np.linalg.norm(point)
                ray = point / far
                n = np.cross(b - a, c - a)
                down = n @ ray
                t = (n * a).sum(axis=1) / np.where(np.abs(down) < 1e-12, 1e-12, down)
                hit = ray * t[:, None]
                inside = np.all(
                    [(np.cross(q - p, hit - p) * n).sum(axis=1) >= -1e-12 for p, q in ((a, b), (b, c), (c, a))], axis=0
                )
                assert t[inside & (t > 0.0)].max(initial=0.0) > far


@pytest.mark.parametrize("style", ["long", "braid", "ponytail"])
def test_hanging_hair_stays_out_of_the_trunk(style) -> None:
    hair = build_hair(FINE, DEFAULT_BODY, style)
    low = hair.position[:, 1] < 1.42
    depth = Shape(trunk_of(DEFAULT_BODY)).distance(hair.position[low].astype(np.float64))
    outside = hair.openness[low] > 0.8
    assert style == "ponytail" or low.any()
    assert depth[outside].min(initial=0.0) > -0.003


def _scene(*bodies):
    return Scene((10.0, 8.0), Camera(), 4, JOINT_COUNT, bodies=bodies)


def test_dancers_are_drawn_in_a_body_a_head_and_hair() -> None:
    scene = _scene("man", DEFAULT_BODY, "man")
    kinds = kinds_of(scene)
    assert [kind.body for kind in kinds[:2]] == list(bodies_of(scene)) == [DEFAULT_BODY, "man"]
    appearance = np.tile(np.array(DEFAULT_APPEARANCE, np.int32), (4, 1))
    appearance[:, HAIR] = HAIRS.index("bob"), HAIRS.index("bald"), HAIRS.index("usual"), 99
    appearance[3, BODY] = 1
    pieces = pieces_of(kinds, scene, appearance)
    assert pieces.shape == (4, len(FAMILIES))
    found = [[kinds[piece] for piece in row if piece >= 0] for row in pieces]
    assert [row[0].body for row in found] == ["man", DEFAULT_BODY, "man", "man"]  # the last one by its appearance
    for row, style in zip(found, ("bob", "bald", "crop", HAIRS[-1]), strict=True):
        assert [kind.family for kind in row] == list(FAMILIES[:3])  # a leotard and bare feet are painted
        assert {kind.body for kind in row} == {row[0].body}
        assert HAIRS[row[2].style] == style


def test_faces_are_spread_evenly_and_stay_with_their_dancers() -> None:
    scene = _scene()
    kinds = kinds_of(scene)
    many = pieces_of(kinds, scene, np.tile(np.array(DEFAULT_APPEARANCE, np.int32), (400, 1)))
    faces = np.array([kinds[piece].style for piece in many[:, 1]])
    assert np.bincount(faces, minlength=FACE_COUNT).min() > 70
    few = pieces_of(kinds, scene, np.tile(np.array(DEFAULT_APPEARANCE, np.int32), (7, 1)))
    np.testing.assert_array_equal(few, many[:7])


def test_figure_for_other_programs_has_a_head_and_moves_with_the_skeleton_only() -> None:
    figure = build_figure(FINE)
    assert figure.position[:, 1].max() > 1.69
    joint, weight = skeleton_weights(figure)
    assert joint.max() < JOINT_COUNT
    np.testing.assert_allclose(weight.sum(axis=1), 1.0, atol=1e-6)
    for row in np.flatnonzero((weight > 0.0).sum(axis=1) > 1)[::50]:
        used = joint[row][weight[row] > 0.0]
        assert len(set(used.tolist())) == len(used)
