"""Set items: closed bodies of the right volume with outward triangles."""

import math

import numpy as np
import pytest

from live.base.set_geometry import SIDES, SetItem, item_triangles

SIZE = (3.0, 1.2, 2.0)


def volume(corners):
    """The volume of a closed surface, by the divergence theorem; positive if its triangles face outwards."""
    return float(np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        (SetItem("box", (1.0, -2.0), SIZE, 30.0, 0.5), 7.2),
        (SetItem("cylinder", (1.0, -2.0), SIZE, 30.0), 7.2 * SIDES / 8.0 * math.sin(math.tau / SIDES)),
        (SetItem("steps", (0.0, 0.0), SIZE, steps=4), 7.2 * (0.25 + 0.5 + 0.75 + 1.0) / 4.0),
    ],
)
def test_items_are_closed_and_face_outwards(item, expected):
    corners, normals = item_triangles(item)
    assert volume(corners.astype(float)) == pytest.approx(expected, rel=1e-5)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.allclose(np.linalg.norm(normals, axis=2), 1.0, atol=1e-5)
    assert (np.einsum("ti,tci->tc", flat, normals) > 0.0).all()


def test_steps_rise_upstage_and_items_turn_like_dancers():
    corners, _ = item_triangles(SetItem("steps", (0.0, 0.0), SIZE))
    high = corners[corners[..., 1] > 1.1]
    assert high[:, 2].max() <= -0.49
    assert high[:, 2].min() == pytest.approx(-1.0)
    turned, _ = item_triangles(SetItem("steps", (0.0, 0.0), SIZE, 90.0))
    assert turned[turned[..., 1] > 1.1][:, 0].max() <= -0.49  # what faced the audience faces +x
