"""The dancers' mirror images in the dull floor, small and soft."""

import moderngl

from live.render.body import COARSE
from live.render.crowd import Crowd
from live.render.release import release_all
from live.render.shader import program


class MirrorPass:
    """Result: `texture`, the light that the floor throws back, over the whole picture."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], divisor: int) -> None:
        self._ctx, self._divisor = ctx, divisor
        self._program = program(ctx, "mirror_vertex.glsl", "mirror_fragment.glsl", (("SOFT", 0),))
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        small = (max(size[0] // self._divisor, 1), max(size[1] // self._divisor, 1))
        self.texture = self._ctx.texture(small, 4)
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x = self.texture.repeat_y = False
        self._depth = self._ctx.depth_renderbuffer(small)
        self._target = self._ctx.framebuffer([self.texture], self._depth)

    def draw(self, crowd: Crowd) -> None:
        """Fill `texture` for this moment."""
        self._target.use()
        self._target.clear()
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.front_face = "cw"  # mirrored
        crowd.draw(self._program, COARSE)
        self._ctx.front_face = "ccw"

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_target()
        self._make(size)

    def _release_target(self) -> None:
        release_all(self._target, self.texture, self._depth)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        self._program.release()
