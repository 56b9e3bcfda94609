"""Small copies of the projected picture."""

import moderngl
import numpy as np
import pytest

from live.render.headless import OffscreenTarget
from live.render.outputs.projection import PictureSampler, fitted_size


@pytest.mark.parametrize(
    ("size", "small"),
    [((1920, 1080), (384, 216)), ((1280, 800), (346, 216)), ((3000, 300), (384, 38)), ((9, 4000), (1, 216))],
)
def test_copy_has_the_proportions_of_the_picture(size: tuple[int, int], small: tuple[int, int]) -> None:
    assert fitted_size(*size) == small


@pytest.mark.gl
def test_copy_comes_a_frame_later_the_top_row_first_and_follows_the_size(gl_context: moderngl.Context) -> None:
    sampler = PictureSampler(gl_context, (960, 540))
    assert sampler.take() is None
    for size in ((960, 540), (400, 400)):
        texture = gl_context.texture(size, 4)
        drawn = gl_context.framebuffer([texture])
        drawn.clear(0.0, 0.0, 1.0, 1.0)
        upper = (0, size[1] // 2, size[0], size[1] - size[1] // 2)  # OpenGL's first row is the lowest
        drawn.clear(1.0, 0.0, 0.0, 1.0, viewport=upper)
        sampler.start(drawn)
        picture = sampler.take()
        assert picture is not None
        assert picture.shape == (*fitted_size(*size)[::-1], 3)
        height = len(picture)
        np.testing.assert_array_equal(
            picture[: height // 2 - 1], np.broadcast_to((255, 0, 0), (height // 2 - 1, picture.shape[1], 3))
        )
        np.testing.assert_array_equal(picture[height // 2 + 1 :, :, 2], 255)
        assert sampler.take() is None
        drawn.release()
        texture.release()
    sampler.release()


@pytest.mark.gl
def test_target_without_a_texture_is_left_out(gl_context: moderngl.Context) -> None:
    sampler = PictureSampler(gl_context, (40, 40))
    target = OffscreenTarget(gl_context, (40, 40))
    sampler.start(target.framebuffer)
    target.release()
    sampler.release()
