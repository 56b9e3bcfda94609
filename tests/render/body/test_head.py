"""Heads: closed and symmetric meshes with the proportions of faces; lids, lips and eyes move as they should."""

import itertools
from functools import cache

import numpy as np
import pytest

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.body.expression import BLINK_LEFT, BLINK_RIGHT, FACE_SIZE, GAZE_PITCH, GAZE_YAW, MOUTH_OPEN, SMILE
from live.render.body.body_mesh import CLOSE, COARSE, DISTANT, FINE, LIGHT, build_body
from live.render.body.drawn_joints import DETAIL_JOINTS, DRAWN_COUNT, DRAWN_NAMES
from live.render.body.face_shape import FACE_COUNT, FACES, faces_of
from live.render.body.head_cage import EYE_CENTRE, EYE_RADIUS, build_head_cage
from live.render.body.head_mesh import build_head
from live.render.body.surface_parts import EAR, EYE, FACE, PAINTED_FACE
from tests.fixtures.mostly_long import mostly_long

LEVELS = (LIGHT, CLOSE, FINE)
MM = 1e-3


def _is_closed(triangle):
    edges = np.concatenate([triangle[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    forward = {tuple(edge) for edge in edges.tolist()}
    return len(forward) == len(edges) and forward == {(b, a) for a, b in forward}


def _volume(mesh):
    a, b, c = (mesh.position[mesh.triangle[:, corner]].astype(np.float64) for corner in range(3))
    return float((np.cross(a, b) * c).sum()) / 6.0


@cache
def _weights(level, body=DEFAULT_BODY, face=0):
    mesh = build_head(level, body, face)
    dense = np.zeros((len(mesh.position), DRAWN_COUNT))
    np.add.at(dense, (np.arange(len(dense))[:, None], mesh.joint), mesh.weight)
    return dense


def _product(a, b):
    w = a[..., :1] * b[..., :1] - (a[..., 1:] * b[..., 1:]).sum(axis=-1, keepdims=True)
    return np.concatenate([w, a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])], -1)


def _moved(level, values, body=DEFAULT_BODY, face=0):
    """Vertices with an expression {column: value} in the rest pose, by dual quaternions (Kavan et al. 2007)."""
    mesh, expression = build_head(level, body, face), np.zeros(FACE_SIZE)
    for column, value in values.items():
        expression[column] = value
    real, dual = np.tile([1.0, 0.0, 0.0, 0.0], (DRAWN_COUNT, 1)), np.zeros((DRAWN_COUNT, 4))
    for joint in DETAIL_JOINTS:
        if joint.parent != "head":
            continue
        turn = sum(np.array(vector) * expression[column] for column, vector in (joint.first, joint.second))
        angle = np.linalg.norm(turn)
        axis = turn / max(angle, 1e-12)
        q = np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * axis)])
        pivot = np.array(joint.pivot)
        u = q[1:]
        turned = pivot + 2.0 * q[0] * np.cross(u, pivot) + 2.0 * np.cross(u, np.cross(u, pivot))
        number = DRAWN_NAMES.index(joint.name)
        real[number], dual[number] = q, 0.5 * _product(np.array([0.0, *(pivot - turned)]), q)
    r, d = _weights(level, body, face) @ real, _weights(level, body, face) @ dual
    size = np.linalg.norm(r, axis=1, keepdims=True)
    r, d = r / size, d / size
    p, u = mesh.position.astype(np.float64), r[:, 1:]
    conjugate = r * np.array([1.0, -1.0, -1.0, -1.0])
    return p + 2.0 * (r[:, :1] * np.cross(u, p) + np.cross(u, np.cross(u, p))) + 2.0 * _product(d, conjugate)[:, 1:]


def _front(points, triangle, at):
    """Largest z of a surface over places (N, 2) in the plane of the face; below 0 where there is none."""
    a, b, c = (points[triangle[:, k]][:, None, :] for k in range(3))
    p = at[None, :, :]
    area = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    area = np.where(np.abs(area) < 1e-14, 1e-14, area)
    u = ((p[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (p[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])) / area
    v = ((b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (p[..., 0] - a[..., 0])) / area
    inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    z = a[..., 2] + u * (b[..., 2] - a[..., 2]) + v * (c[..., 2] - a[..., 2])
    return np.where(inside, z, -1.0).max(axis=0)


def _eye_seen(level, blink, scale):
    """Share of places in the eye's opening where the eyeball is in front of the skin; `scale` of the opening."""
    mesh = build_head(level)
    skin = mesh.triangle[mesh.part[mesh.triangle[:, 0]] == FACE]
    points = _moved(level, {BLINK_LEFT: blink, BLINK_RIGHT: blink})
    near = np.linalg.norm(points[skin].mean(axis=1)[:, :2] - EYE_CENTRE[:2], axis=1) < 0.03
    angle, share = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False), (0.15, 0.4, 0.7, 1.0))
    across, up = scale * share * 12.0 * MM * np.cos(angle), scale * share * 4.5 * MM * np.sin(angle)
    at = np.column_stack([EYE_CENTRE[0] + across.ravel(), EYE_CENTRE[1] + up.ravel()])
    ball = EYE_CENTRE[2] + np.sqrt(np.maximum(EYE_RADIUS**2 - across.ravel() ** 2 - up.ravel() ** 2, 0.0))
    return float((_front(points, skin[near], at) < ball).mean())


@mostly_long("body", BODIES, quick=[0, 2, 4, 5])
@mostly_long("level", LEVELS, quick=[0, 1])
def test_every_head_is_closed_and_faces_outward(level, body) -> None:
    for face in range(FACE_COUNT):
        mesh = build_head(level, body, face)
        assert _is_closed(mesh.triangle)
        assert 3.0e-3 < _volume(mesh) < 5.5e-3
        np.testing.assert_allclose(np.linalg.norm(mesh.normal, axis=1), 1.0, atol=1e-5)
        np.testing.assert_allclose(mesh.weight.sum(axis=1), 1.0, atol=1e-6)


def test_bodies_have_heads_of_their_own_only_far_away() -> None:
    for level in (COARSE, DISTANT):
        assert len(build_head(level).triangle) == 0
        assert build_body(level).position[:, 1].max() > 1.65
    for level in LEVELS:
        assert build_body(level).position[:, 1].max() < 1.60


@pytest.mark.parametrize(("level", "most"), [(LIGHT, 400), (CLOSE, 1800), (FINE, 5600)])
def test_heads_keep_their_budget_of_triangles(level, most) -> None:
    assert 0.5 * most < len(build_head(level).triangle) <= most


@pytest.mark.parametrize("level", LEVELS)
def test_left_and_right_half_are_mirror_images(level) -> None:
    mesh = build_head(level)
    reflected = mesh.position * np.array([-1.0, 1.0, 1.0], np.float32)
    apart = np.linalg.norm(mesh.position[:, None] - reflected[None], axis=2)
    assert apart.min(axis=0).max() < 1e-4


@pytest.mark.parametrize("body", ["dancer", "woman", "man", "strong"])
def test_proportions_follow_the_canon(body) -> None:
    """Loomis 1956 and Farkas 1994: eyes halfway, thirds, an eye's width between the eyes, ears from brow to nose."""
    mesh = build_head(FINE, body)
    skin, ear = mesh.position[mesh.part == FACE], mesh.position[mesh.part == EAR]
    place = mesh.place[mesh.part == FACE]
    crown = float(skin[:, 1].max())
    chin = float(skin[(place[:, 2] > 0.070) & (place[:, 1] > 1.48), 1].min())
    head = crown - chin
    assert 0.195 < head < 0.230
    assert (EYE_CENTRE[1] - chin) / head == pytest.approx(0.5, abs=0.03)

    def height(low, high):  # of the corners of the middle line that lie there on the usual head
        row = (np.abs(place[:, 0]) < 1e-4) & (place[:, 1] > low) & (place[:, 1] < high) & (place[:, 2] > 0.07)
        return float(skin[row, 1].mean())

    nose, brow = height(1.5465, 1.5485), 1.6115
    assert (nose - chin) / (brow - nose) == pytest.approx(1.0, abs=0.16)
    mouth = height(1.5255, 1.5295)
    assert (nose - mouth) / (nose - chin) == pytest.approx(1.0 / 3.0, abs=0.06)
    margin = build_head_cage().points[build_head_cage().loops["margin"]]
    inner, outer = margin[:, 0].min(), margin[:, 0].max()
    assert 2.0 * inner / (outer - inner) == pytest.approx(1.0, abs=0.2)
    assert ear[:, 1].max() == pytest.approx(brow, abs=8 * MM)
    assert ear[:, 1].min() == pytest.approx(nose, abs=8 * MM)
    width = 2.0 * skin[place[:, 1] > 1.60, 0].max()
    length = np.ptp(skin[place[:, 1] > 1.60, 2])
    assert 0.72 < width / length < 0.85  # cephalic index


def test_faces_of_a_body_and_of_bodies_differ() -> None:
    """No two of them are nearer than a millimetre somewhere, and few are alike all over."""
    assert set(FACES) == set(BODIES)
    faces = [(body, face) for body in BODIES for face in range(FACE_COUNT)]
    for (body, one), (other, two) in itertools.combinations(faces, 2):
        a, b = build_head(LIGHT, body, one), build_head(LIGHT, other, two)
        skin = (a.part == PAINTED_FACE) & (a.place[:, 1] > 1.49)
        apart = np.linalg.norm(a.position[skin] - b.position[skin], axis=1)
        assert faces_of(body)[one] != faces_of(other)[two]
        assert apart.max() > 0.4 * MM
    looks = [build_head(LIGHT, DEFAULT_BODY, face).position for face in range(FACE_COUNT)]
    assert min(np.abs(a - b).max() for a, b in itertools.combinations(looks, 2)) > 1.5 * MM


@pytest.mark.parametrize("level", [CLOSE, FINE])
def test_lids_cover_the_eye_when_it_blinks(level) -> None:
    assert _eye_seen(level, 0.0, 0.75) > 0.93
    assert _eye_seen(level, 1.0, 0.92) == 0.0
    assert 0.15 < _eye_seen(level, 0.5, 0.9) < 0.75


def test_eyeball_turns_about_its_own_centre_and_up_is_up() -> None:
    mesh = build_head(FINE)
    ball = (mesh.part == EYE) & (mesh.position[:, 0] > 0.0)
    pupil = np.flatnonzero(ball)[mesh.position[ball, 2].argmax()]
    points = _moved(FINE, {GAZE_YAW: 0.4, GAZE_PITCH: 0.2})
    away = np.linalg.norm(points[ball] - np.array(EYE_CENTRE), axis=1)
    np.testing.assert_allclose(away, EYE_RADIUS, atol=1e-5)
    to = (points[pupil] - np.array(EYE_CENTRE)) / EYE_RADIUS
    assert np.arctan2(to[0], to[2]) == pytest.approx(0.4, abs=0.03)
    assert np.arcsin(to[1]) == pytest.approx(0.2, abs=0.03)


def _lips(values):
    """Heights of upper and lower lip in the middle where they touch, and half the mouth's width [m]."""
    mesh, points = build_head(CLOSE), _moved(CLOSE, values)
    cage = build_head_cage()
    touch = cage.points[cage.loops["touch"]]
    at = [int(np.linalg.norm(mesh.place - corner, axis=1).argmin()) for corner in touch]
    return points[at[0], 1], points[at[-1], 1], points[at[3]]


def test_jaw_opens_the_lips_and_they_close() -> None:
    upper, lower, corner = _lips({})
    assert lower - upper == pytest.approx(0.0, abs=1.5 * MM)
    open_upper, open_lower, open_corner = _lips({MOUTH_OPEN: 1.0})
    assert open_upper == pytest.approx(upper, abs=0.5 * MM)
    assert 10.0 * MM < open_upper - open_lower < 25.0 * MM
    assert open_lower < open_corner[1] < open_upper
    half = _lips({MOUTH_OPEN: 0.5})
    assert 4.0 * MM < half[0] - half[1] < 13.0 * MM
    assert corner[1] == pytest.approx(1.5275 + 1.3 * MM, abs=1 * MM)  # it turns up a little


def test_smile_lifts_and_widens_the_mouth_and_keeps_it_closed() -> None:
    upper, lower, corner = _lips({})
    smile = _lips({SMILE: 1.0})
    assert 2.0 * MM < smile[2][1] - corner[1] < 8.0 * MM
    assert 0.8 * MM < smile[2][0] - corner[0] < 6.0 * MM
    assert abs((smile[0] - smile[1]) - (upper - lower)) < 0.5 * MM
    assert _lips({SMILE: -1.0})[2][1] < corner[1] - 2.0 * MM
