"""The picture of a first start: words above a bar that grows."""

import numpy as np
import pytest

from live.render.window.start_window import BRIGHT, DARK, LEFT, start_picture


@pytest.mark.parametrize("share", [-1.0, 0.0, 0.25, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1200), (640, 640)])
def test_the_bar_shows_the_share(size: tuple[int, int], share: float) -> None:
    picture = start_picture(size, "Dança", "compiling: 3 of 200", share)
    assert picture.shape == (size[1], size[0])
    row = picture[size[1] // 2 + 2]
    bright, whole = np.count_nonzero(row == BRIGHT), np.count_nonzero((row == BRIGHT) | (row == DARK))
    assert whole == pytest.approx(size[0] * (1.0 - 2.0 * LEFT), abs=2)
    assert bright / whole == pytest.approx(min(max(share, 0.0), 1.0), abs=0.01)


def test_a_tiny_window_and_an_endless_title_are_no_error() -> None:
    assert start_picture((1, 1), "x" * 5000, "", 0.5).size
