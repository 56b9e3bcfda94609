"""Pictures: the show's last picture, and the one that is being drawn; who fails while drawing leaves the last one."""

import math
from collections.abc import Sequence
from typing import Final

import moderngl

from live.render.gl_release import release_all
from live.render.outputs.output import WHOLE, Output

LARGEST: Final = 8192
"""Longest side of the picture [pixels]."""


class Pictures:
    """Two pictures of one size, drawn to in turn; GL objects are made here and in `resize`."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self.ctx = ctx
        self._last = 0
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self.size = size
        """Width and height [pixels]."""
        self._textures = [self.ctx.texture(size, 4) for _ in range(2)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._framebuffers = [self.ctx.framebuffer([texture]) for texture in self._textures]
        for framebuffer in self._framebuffers:
            framebuffer.clear(0.0, 0.0, 0.0, 1.0)

    @property
    def next(self) -> moderngl.Framebuffer:
        """What the next picture is drawn into."""
        return self._framebuffers[1 - self._last]

    def take(self) -> None:
        """What was drawn into `next` is good: it is the last picture now."""
        self._last = 1 - self._last

    @property
    def last(self) -> moderngl.Framebuffer:
        """The last picture that was drawn to its end."""
        return self._framebuffers[self._last]

    @property
    def texture(self) -> moderngl.Texture:
        """That picture as a texture."""
        return self._textures[self._last]

    def resize(self, size: tuple[int, int]) -> None:
        """New size [pixels]; both pictures are black then."""
        self.release()
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._framebuffers, *self._textures)


def picture_size(outputs: Sequence[Output], windows: Sequence[tuple[int, int]]) -> tuple[int, int]:
    """The size [pixels] at which no output shows less than its own pixels; `windows`: the size of each one's window."""
    most = [1.0, 1.0]
    for output, (width, height) in zip(outputs, windows, strict=True):
        upright = (width, height) if output.rotation in (0, 180) else (height, width)
        for axis in range(2):
            most[axis] = max(most[axis], upright[axis] / output.crop[2 + axis])
    if len(outputs) == 1 and outputs[0].crop == WHOLE:
        return round(most[0]), round(most[1])
    share = min(1.0, LARGEST / max(most))
    return math.ceil(most[0] * share - 1e-6), math.ceil(most[1] * share - 1e-6)
