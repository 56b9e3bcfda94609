"""Mathematics of the corner pin: exact corners, the projective map, and invalid corners."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.render.outputs.output import FULL_WINDOW
from live.render.outputs.warp import check_corners, homography, map_points


def quads(count: int, seed: int = 3):
    """Random convex quadrangles: each corner anywhere in its own quarter of the window."""
    draw = np.random.default_rng(seed)
    for _ in range(count):
        yield [tuple(corner + draw.uniform(-0.2, 0.2, 2)) for corner in np.array(FULL_WINDOW) * 0.6 + 0.2]


def test_picture_corners_map_to_given_corners():
    for quad in quads(200):
        np.testing.assert_allclose(map_points(homography(quad), FULL_WINDOW), quad, atol=1e-12)


def test_homography_matches_linear_solution():
    """Against the linear system of the eight unknowns, solved numerically instead of in closed form."""
    for quad in quads(50, seed=8):
        rows, right = [], []
        for (u, v), (x, y) in zip(FULL_WINDOW, quad, strict=True):
            rows += [[u, v, 1, 0, 0, 0, -u * x, -v * x], [0, 0, 0, u, v, 1, -u * y, -v * y]]
            right += [x, y]
        expected = np.append(np.linalg.solve(np.array(rows), right), 1.0).reshape(3, 3)
        np.testing.assert_allclose(homography(quad), expected, atol=1e-9)


def test_default_corners_give_identity():
    np.testing.assert_array_equal(homography(FULL_WINDOW), np.eye(3))


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([(0.5, 0.5)] * 4, "enclose nothing"),
        ([(0, 0), (1, 0), (1, 0), (0, 0)], "enclose nothing"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "cross"),
        ([(0, 0), (1, 0), (0, 1), (1, 1)], "cross"),
        ([(1, 0), (0, 0), (0, 1), (1, 1)], "turn the picture over"),
        ([(0, 0), (1, 0), (0.4, 0.4), (0, 1)], "have a dent"),
        ([(0, 0), (1, 0), (0.5, 0.5), (0, 1)], "lie in a line"),
        ([(0, 0), (9, 0), (1, 1), (0, 1)], "windows away"),
    ],
)
def test_invalid_corners_are_refused_with_reason(corners, words):
    with pytest.raises(PersonError, match=words):
        check_corners(corners)


def test_turned_corners_are_allowed():
    for turn in range(4):
        check_corners([FULL_WINDOW[(n + turn) % 4] for n in range(4)])
    for quad in quads(50):
        check_corners(quad)
