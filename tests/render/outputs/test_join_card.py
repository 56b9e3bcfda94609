"""The QR code for the audience, read by a barcode reader from a simulated photograph of the projected picture."""

import numpy as np
import pytest
from PIL import Image, ImageFilter

from live.render.outputs.output import Output
from live.render.outputs.test_card import join_card
from tests.fixtures.mostly_long import mostly_long

LINK = "http://192.168.1.50:8020/#NOUm8cCZf5qC"
PICTURE, PHOTO = (1920, 1080), (1920, 1080)
LENS = 1500.0
"""Focal length of a phone's camera [pixels of PHOTO]: 65 degrees from left to right."""


@mostly_long(
    ("width", "degrees"),
    [(1200, 0), (1200, 70), (600, 60), (400, 45), (300, 30), (220, 0)],
    quick=[4],
    ids=lambda value: str(value),
)
def test_code_is_readable_from_distance_and_from_side(throw, width, degrees):
    """`width`: width of the picture in a frontal photograph [pixels]: a screen of 5 m is 220 wide from 34 m."""
    segno, zxing = pytest.importorskip("segno"), pytest.importorskip("zxingcpp")
    rows = ["".join("1" if dark else "0" for dark in row) for row in segno.make(LINK, error="m", micro=False).matrix]
    dance = np.full((PICTURE[1], PICTURE[0], 3), 90, np.uint8)
    seen = throw(dance, Output(), card="qr", sheet=join_card(rows, "http://192.168.1.50:8020"), size=PICTURE)
    found = zxing.read_barcodes(photograph(seen, width, np.radians(degrees)))
    assert [one.text for one in found] == [LINK]


def photograph(seen, width, angle):
    """A photograph of the projected picture, turned by `angle` [rad]: blurred, pale, with noise, (H, W) uint8."""
    grey = Image.fromarray(seen).convert("L").filter(ImageFilter.GaussianBlur(0.5 * PICTURE[0] / width))
    high, far = PICTURE[1] / PICTURE[0], LENS / width
    corners = []
    for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
        depth = far + x * np.sin(angle)
        corners.append((LENS * x * np.cos(angle) / depth, LENS * y * high / depth))
    here = np.array(corners) + 0.5 * np.array(PHOTO)
    there = np.array([(0, 0), (PICTURE[0], 0), PICTURE, (0, PICTURE[1])], np.float64)
    photo = grey.transform(PHOTO, Image.Transform.PERSPECTIVE, projection(here, there), Image.Resampling.BICUBIC)
    soft = np.asarray(photo.filter(ImageFilter.GaussianBlur(0.8)), np.float64)
    noise = np.random.default_rng(1).normal(0.0, 6.0, soft.shape)
    return np.clip(60.0 + 0.45 * soft + noise, 0, 255).astype(np.uint8)


def projection(here, there):
    """The eight coefficients that map points of the photograph to points of the picture, in the order of PIL."""
    rows, right = [], []
    for (x, y), (u, v) in zip(here, there, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        right += [u, v]
    return np.linalg.solve(np.array(rows), np.array(right))
