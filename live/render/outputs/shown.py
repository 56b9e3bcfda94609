"""Shown: the whole picture as the projectors show it together, for who takes it elsewhere: films, other programs.

It is not cropped, bent, blended or masked, and no test card is in it; but its light is held back where theirs is.
"""

import moderngl

from live.render.gl_release import release_all
from live.render.outputs.output import Output
from live.render.outputs.output_pass import OutputPass
from live.render.outputs.pictures import Pictures


class Shown:
    """Costs nothing while nothing flashes; GL objects are made here, and when the picture has another size."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._ctx = ctx
        self._pass = OutputPass(ctx, Output())
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._texture = self._ctx.texture(size, 4)
        self._target = self._ctx.framebuffer([self._texture])

    def of(self, pictures: Pictures, left: float) -> moderngl.Framebuffer:
        """The last picture with so much of its light left."""
        if left >= 1.0:
            return pictures.last
        if self._texture.size != pictures.size:
            release_all(self._target, self._texture)
            self._make(pictures.size)
        self._pass.draw(pictures.texture, self._target, left=left)
        return self._target

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self._texture, self._pass)
