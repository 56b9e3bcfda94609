"""Small copies of the projected picture, read back without waiting for the graphics card."""

from typing import Final

import moderngl

from live.render.headless import FrameReader, Picture
from live.render.outputs.output import Output
from live.render.outputs.output_pass import OutputPass
from live.render.shader import release_all

WIDTH: Final = 384
HEIGHT: Final = 216
"""Largest size of a copy [pixels]; it has the proportions of the picture."""


def fitted_size(width: int, height: int) -> tuple[int, int]:
    """Return the size of a copy of a picture of this size [pixels]: within `WIDTH` x `HEIGHT`, at least one pixel."""
    scale = min(WIDTH / width, HEIGHT / height)
    return max(1, round(width * scale)), max(1, round(height * scale))


class PictureSampler:
    """Copies a picture when asked, and gives the copy a frame later.

    Thread: the one of the OpenGL context. GL objects are created here, and anew for a picture of another size.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        """`size`: width and height of the picture [pixels]."""
        self._ctx = ctx
        self._pass = OutputPass(ctx, Output())
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._size = size
        small = fitted_size(*size)
        self._texture = self._ctx.texture(small, 4)
        self._target = self._ctx.framebuffer([self._texture])
        self._reader = FrameReader(self._ctx, small)
        self._waits = False

    def start(self, framebuffer: moderngl.Framebuffer) -> None:
        """Begin to copy the picture that was drawn into a framebuffer with one texture."""
        texture = framebuffer.color_attachments[0]
        if not isinstance(texture, moderngl.Texture):
            return
        if texture.size != self._size:
            self._release_target()
            self._make(texture.size)
        self._pass.draw(texture, self._target)
        self._reader.push(self._target)
        self._waits = True

    def take(self) -> Picture | None:
        """Return the copy that was begun in an earlier frame: RGB, uint8, shape (height, width, 3), the top row first;
        None without one. It is a view, valid until the next call."""
        if not self._waits:
            return None
        self._waits = False
        return self._reader.flush()

    def _release_target(self) -> None:
        self._reader.release()
        release_all(self._target, self._texture)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        self._pass.release()
