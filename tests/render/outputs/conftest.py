"""Fixtures: a picture, and outputs drawn from it without a screen."""

from collections.abc import Callable, Iterator

import moderngl
import numpy as np
import pytest

from live.render.headless import OffscreenTarget
from live.render.outputs.output import Output
from live.render.outputs.output_pass import OutputPass

SIZE = (320, 180)

Throw = Callable[..., np.ndarray]


@pytest.fixture
def throw(gl_context: moderngl.Context) -> Iterator[Throw]:
    """Draws a picture (H, W, 3) through an output into a window of a size; returns what is shown, (h, w, 3) uint8."""
    held: list[OffscreenTarget | moderngl.Texture | OutputPass] = []

    def draw(picture: np.ndarray, output: Output, size: tuple[int, int] = SIZE, **options) -> np.ndarray:
        opaque = np.dstack([picture, np.full(picture.shape[:2], 255, np.uint8)])
        texture = gl_context.texture((picture.shape[1], picture.shape[0]), 4, opaque[::-1].tobytes())
        texture.repeat_x = texture.repeat_y = False
        target = OffscreenTarget(gl_context, size)
        one = OutputPass(gl_context, output, options.pop("number", 0), "320 x 180")
        if (sheet := options.pop("sheet", None)) is not None:
            one.set_join_card(sheet)
        one.draw(texture, target.framebuffer, **options)
        held.extend((texture, target, one))
        return target.read().copy()

    yield draw
    for thing in held:
        thing.release()


@pytest.fixture(scope="session")
def noise() -> np.ndarray:
    """A picture of independent random pixels, (180, 320, 3)."""
    return np.random.default_rng(5).integers(0, 256, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
