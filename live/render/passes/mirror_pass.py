"""The dancers' mirror images in the dull floor, small and soft."""

from typing import Final

import moderngl

from live.render.body.body_mesh import COARSE
from live.render.dancers.dancer_batch import Crowd
from live.render.gl_release import release_all
from live.render.shader import WORN, program, set_uniform

_BEYOND: Final = 4
"""Rows above the floor's that it reads, too."""


class MirrorPass:
    """Result: `texture`, square roots of the light that the floor throws back, over the whole picture."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], divisor: int, *, worn: bool = False) -> None:
        self._ctx, self._divisor = ctx, divisor
        self._programs = [
            program(ctx, "mirror_vertex.glsl", "mirror_fragment.glsl", (("SOFT", 0), ("STYLED", styled)))
            for styled in (0, 1)
        ]
        self._worn = [
            program(ctx, "mirror_vertex.glsl", "mirror_fragment.glsl", (("SOFT", 0), ("STYLED", styled), *WORN))
            for styled in (0, 1)
            if worn
        ]
        self._gloss = program(ctx, "full_vertex.glsl", "gloss_fragment.glsl")
        self._triangle = ctx.vertex_array(self._gloss, [])
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        small = (max(size[0] // self._divisor, 1), max(size[1] // self._divisor, 1))
        self._drawn, self.texture = self._ctx.texture(small, 4), self._ctx.texture(small, 4)
        for texture in (self._drawn, self.texture):
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._depth = self._ctx.depth_renderbuffer(small)
        self._target = self._ctx.framebuffer([self._drawn], self._depth)
        self._result = self._ctx.framebuffer([self.texture])
        self._dark = False

    def draw(self, crowd: Crowd, *, seen: bool = True, rows: int | None = None) -> None:
        """Fill `texture` for this moment: with the dancers' images, or `seen` is false and it is dark.

        The floor is seen in so many `rows` of the picture from below; None: in all.
        """
        if not seen:
            if not self._dark:
                self._result.scissor = (0, 0, *self.texture.size)
                self._result.clear()
            self._dark = True
            return
        self._dark = False
        width, height = self.texture.size
        height = height if rows is None else min(-(-rows // self._divisor) + _BEYOND, height)
        self._target.scissor = self._result.scissor = (0, 0, width, height)
        self._target.use()
        self._target.clear()
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.front_face = "cw"  # mirrored
        styled = crowd.styles.any
        crowd.draw(self._programs[styled], COARSE, "mirrored", worn=self._worn[styled] if self._worn else None)
        self._ctx.front_face = "ccw"
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._result.use()
        self._drawn.use(1)
        set_uniform(self._gloss, "drawn", 1)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_target()
        self._make(size)

    def _release_target(self) -> None:
        release_all(self._target, self._result, self._drawn, self.texture, self._depth)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        release_all(self._triangle, *self._programs, *self._worn, self._gloss)
