"""The operator's guides: strokes over the picture that show what the show intends, not what the audience should see."""

from typing import Final

import moderngl

from live.base.stage_snapshot import GUIDE_CAPACITY, StageView
from live.render.gl_release import release_all
from live.render.shader import program, set_uniform

_PER_HEIGHT: Final = 540
"""Strokes of this breadth would fill the picture's height."""


class GuidePass:
    """Draws `guide_count` strokes over what the target shows, dancers included; nothing, at no cost, where none are."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = program(ctx, "guide_vertex.glsl", "guide_fragment.glsl")
        self._buffer = ctx.buffer(reserve=GUIDE_CAPACITY * 40, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "3f 3f 4f/i", "in_begin", "in_end", "in_colour")])

    def draw(self, view: StageView, target: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Draw the view's guides over what `target` shows, of `size` [pixels]."""
        if view.guide_count <= 0:
            return
        count = min(view.guide_count, GUIDE_CAPACITY)
        self._buffer.write(view.guide[:count])
        set_uniform(self._program, "breadth", max(0.5, 0.5 * size[1] / _PER_HEIGHT))
        target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        self._ctx.disable(moderngl.BLEND)

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._program)
