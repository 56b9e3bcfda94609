"""The frame passed to films and other programs: the whole picture, with the flash limit applied."""

import moderngl
import numpy as np

from live.render.outputs.projection import OutputFrame
from live.render.outputs.screen import FrameBuffers
from tests.render.test_renderer import read


def test_limited_light_applies_to_output_frame(gl_context: moderngl.Context) -> None:
    pictures, shown = FrameBuffers(gl_context, (32, 18)), OutputFrame(gl_context, (32, 18))
    for size in ((32, 18), (20, 30)):
        pictures.resize(size)
        pictures.next.clear(0.8, 0.4, 0.2, 1.0)
        pictures.swap()
        assert shown.render(pictures, 1.0) is pictures.last
        whole, half = read(pictures.last), read(shown.render(pictures, 0.5))
        assert half.shape == whole.shape == (size[1], size[0], 3)
        # half of the light is less than half of the signal's steps away, in the same hue
        assert (half < whole).all()
        assert (np.diff(half[..., ::-1].astype(int), axis=2) > 0).all()
        assert half.std(axis=(0, 1)).max() == 0.0
    for thing in (shown, pictures):
        thing.release()
