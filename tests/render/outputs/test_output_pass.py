"""Tests of the output pass: corners within a pixel, exact pixels without a warp, and edge blending."""

import numpy as np
import pytest
from PIL import Image

from live.base.errors import PersonError
from live.render.outputs.output import FULL_WINDOW, Output, SoftEdge
from live.render.outputs.test_card import BAND_HEIGHT, MODULE_SIZE, QUIET_ZONE, join_card
from live.render.outputs.warp import homography, map_points, regular_mesh
from tests.render.outputs.conftest import SIZE
from tests.render.outputs.test_corner_pin import quads

WIDTH, HEIGHT = SIZE


def white(size=SIZE, value=255):
    return np.full((size[1], size[0], 3), value, np.uint8)


def test_plain_output_shows_unchanged_picture(throw, noise):
    np.testing.assert_array_equal(throw(noise, Output()), noise)


@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (4, 3), (5, 5), (9, 6)])
def test_regular_mesh_changes_no_pixel(throw, noise, columns, rows):
    np.testing.assert_array_equal(throw(noise, Output(mesh=regular_mesh(columns, rows))), noise)


@pytest.mark.long
def test_picture_corners_land_within_one_pixel(throw):
    """Each border of the quadrangle is found by a line fit to the light on either side of it."""
    for quad in quads(24, seed=11):
        seen = throw(white(), Output(corners=tuple(quad)))[..., 0] / 255.0
        wanted = np.array(quad) * SIZE
        found = _find_corners(seen, wanted)
        assert np.abs(found - wanted).max() < 1.0


def _find_corners(seen, near):
    """The corners (4, 2) [pixels] of the one bright quadrangle, from straight lines fitted to its four borders."""
    lines = []
    for a, b in zip(near, np.roll(near, -1, axis=0), strict=True):
        across = np.array([(b - a)[1], -(b - a)[0]]) / np.linalg.norm(b - a)
        points = []
        for share in np.linspace(0.15, 0.85, 15):
            reach = np.arange(-6.0, 6.0, 0.25)
            at = a + share * (b - a) + reach[:, None] * across
            light = _light_at(seen, at)
            points.append(a + share * (b - a) + across * (light.sum() * 0.25 - 6.0))  # inside is on the low side
        middle = np.mean(points, axis=0)
        lines.append((middle, np.linalg.svd(points - middle)[2][0]))
    corners = []
    for (p, d), (q, e) in zip([lines[-1], *lines[:-1]], lines, strict=True):
        s = np.linalg.solve(np.stack([d, -e], axis=1), q - p)[0]
        corners.append(p + s * d)
    return np.array(corners)


def _light_at(seen, at):
    """Bilinear light at positions (n, 2) [pixels]."""
    x, y = np.clip(at[:, 0] - 0.5, 0, WIDTH - 1.001), np.clip(at[:, 1] - 0.5, 0, HEIGHT - 1.001)
    i, j = x.astype(int), y.astype(int)
    u, v = x - i, y - j
    return (
        seen[j, i] * (1 - u) * (1 - v)
        + seen[j, i + 1] * u * (1 - v)
        + seen[j + 1, i] * (1 - u) * v
        + seen[j + 1, i + 1] * u * v
    )


def test_interior_pixels_follow_projective_map(throw):
    """The colour ramp encodes the source position in every pixel."""
    ramp = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    ramp[..., 0] = np.linspace(0, 255, WIDTH).round()
    ramp[..., 1] = np.linspace(0, 255, HEIGHT).round()[:, None]
    for quad in quads(6, seed=4):
        seen = throw(ramp, Output(corners=tuple(quad))).astype(float)
        inside = np.stack(np.meshgrid(np.linspace(0.1, 0.9, 9), np.linspace(0.1, 0.9, 7)), axis=-1)
        pixel = (map_points(homography(quad), inside) * SIZE).astype(int)
        centre = (pixel + 0.5) / SIZE
        back = map_points(np.linalg.inv(homography(quad)), centre)
        got = seen[pixel[..., 1], pixel[..., 0], :2] / 255.0
        assert np.abs(got - back).max() < 1.5 / 180


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_rotation_and_mirror_match_numpy(throw, turns, mirror):
    square = np.random.default_rng(1).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    expected = np.rot90(square[:, ::-1] if mirror else square, -turns)  # clockwise
    seen = throw(square, Output(rotation=90 * turns, mirror=mirror), (64, 64)).astype(int)
    assert np.abs(seen - expected)[1:-1, 1:-1].max() <= 1  # the border is smoothed


def test_crop_is_exact_to_pixel(throw, noise):
    part = throw(noise, Output(crop=(0.25, 0.5, 0.5, 0.5)), (160, 90))
    np.testing.assert_array_equal(part, noise[90:, 80:240])


@pytest.mark.parametrize(("gamma", "black"), [(2.2, 0.0), (1.8, 0.0), (2.4, 0.0)])
def test_two_blended_projectors_give_even_light(throw, gamma, black):
    """Light = signal ** gamma of each; the sum is that of one projector alone within 2 %."""
    shared, overlap = 0.55, 0.1
    breadth = overlap / shared
    for value in (255, 190, 128):
        picture = white((640, 90), value)
        left = Output(crop=(0.0, 0.0, shared, 1.0), edge=SoftEdge(right=breadth, gamma=gamma, black=black))
        right = Output(crop=(1.0 - shared, 0.0, shared, 1.0), edge=SoftEdge(left=breadth, gamma=gamma, black=black))
        wide = (352, 90)
        wall = np.zeros(640)
        wall[:352] += (throw(picture, left, wide)[45, :, 1] / 255.0) ** gamma
        wall[288:] += (throw(picture, right, wide)[45, :, 1] / 255.0) ** gamma
        expected = (value / 255.0) ** gamma
        assert np.abs(wall / expected - 1.0).max() < 0.02


def test_black_level_is_raised_outside_overlap(throw):
    """Two projectors leak light where they overlap; the part of one alone is raised to that level."""
    leak, gamma = 0.02, 2.2
    edge = SoftEdge(right=0.25, gamma=gamma, black=leak)
    seen = throw(white(value=0), Output(edge=edge))[90, :, 0] / 255.0
    own = leak + (1.0 - leak) * seen**gamma
    alone, shared = own[: WIDTH // 2], own[int(0.76 * WIDTH) :]
    assert np.abs(alone - 2.0 * shared.mean()).max() < 0.002
    assert np.all(seen[int(0.76 * WIDTH) :] == 0.0)


def test_mask_hides_exact_window_pixels(throw, noise, tmp_path):
    """In window pixels, independent of the corners."""
    hidden = np.random.default_rng(9).integers(0, 2, (HEIGHT, WIDTH), dtype=np.uint8) * 255
    Image.fromarray(hidden).save(tmp_path / "mask.png")
    seen = throw(noise, Output(mask=tmp_path / "mask.png"))
    assert np.all(seen[hidden == 0] == 0)
    assert np.abs(seen[hidden == 255].astype(int) - noise[hidden == 255]).max() <= 1
    bent = Output(corners=((0.1, 0.1), (0.9, 0.0), (1.0, 1.0), (0.0, 0.9)), mask=tmp_path / "mask.png")
    assert np.all(throw(white(), bent)[hidden == 0] == 0)


def test_brightness_scales_light_and_gamma_scales_signal(throw):
    half = throw(white(), Output(brightness=0.5))[90, 160, 0] / 255.0
    assert half**2.2 == pytest.approx(0.5, abs=0.01)
    dark = throw(white(value=128), Output(gamma=1.5))[90, 160, 0]
    assert dark == pytest.approx(255 * (128 / 255) ** 1.5, abs=1)
    limited = throw(white(), Output(), light_share=0.25)[90, 160, 0] / 255.0
    assert limited**2.2 == pytest.approx(0.25, abs=0.01)


def test_warped_border_is_antialiased_and_outside_is_dark(throw):
    seen = throw(white(), Output(corners=((0.2, 0.2), (0.8, 0.25), (0.8, 0.8), (0.2, 0.75))))[..., 0]
    assert np.all(seen[:30] == 0)
    assert np.all(seen[70:110, 90:230] == 255)
    between = (seen > 0) & (seen < 255)
    assert 150 < between.sum() < 800  # the half pixel inside the two slanting borders, 192 columns each


@pytest.mark.parametrize("content", [b"no picture", b"\x89PNG\r\n\x1a\n" + b"\0" * 40, b""])
def test_unreadable_mask_is_refused_by_name(throw, tmp_path, content):
    with pytest.raises(PersonError, match=r"mask .*nothing\.png: there is no such file"):
        throw(white(), Output(mask=tmp_path / "nothing.png"))
    (tmp_path / "broken.png").write_bytes(content)
    with pytest.raises(PersonError, match=r"broken\.png: cannot be read as an image"):
        throw(white(), Output(mask=tmp_path / "broken.png"))


def test_default_corners_are_plain():
    assert Output(corners=FULL_WINDOW).is_plain


def test_projected_code_matches_matrix_over_dimmed_picture(throw):
    """The centre of each module is dark or light as in the code matrix."""
    segno = pytest.importorskip("segno")
    matrix = [
        [bool(dark) for dark in row] for row in segno.make("http://192.168.1.50:8020/#NOUm8cCZf5qC", error="m").matrix
    ]
    sheet = join_card(["".join("01"[dark] for dark in row) for row in matrix], "http://192.168.1.50:8020")
    seen = throw(white(), Output(), card="qr", sheet=sheet, size=(960, 540))[..., 0] / 255.0
    scale = 0.9 * min(540 / sheet.shape[0], 960 / sheet.shape[1])
    left = 480 - 0.5 * scale * sheet.shape[1]
    top = 270 - 0.5 * scale * sheet.shape[0]
    for row, line in enumerate(matrix):
        for column, dark in enumerate(line):
            x = left + scale * MODULE_SIZE * (QUIET_ZONE + column + 0.5)
            y = top + scale * (BAND_HEIGHT + MODULE_SIZE * (2 + row + 0.5))
            assert (seen[int(y), int(x)] < 0.45) == dark, (row, column)
    assert 0.2 < seen[270, 3] < 0.5  # the picture, in little light
