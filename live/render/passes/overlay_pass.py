"""Render passes of the operator's overlay: text panel, guide strokes and frame time graph."""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import GUIDE_CAPACITY, StageView
from live.render.lettering.glyph_atlas import GlyphAtlas, bake_atlas
from live.render.shader import compile_program, release_all, set_uniform
from live.render.timing.frame_stats import GRAPH_FRAMES

_MAX_LETTERS: Final = 1024
"""Maximum number of letters."""
_LINES_PER_HEIGHT: Final = 42
"""Number of text lines that fill the picture's height."""


class OverlayPass:
    """Draws lines of text on a dark panel in the upper left corner; layout only when the text changes."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "overlay_vertex.glsl", "overlay_fragment.glsl")
        self._buffer = ctx.buffer(reserve=(_MAX_LETTERS + 1) * 16, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f/i", "in_letter")])
        self._lettering: GlyphAtlas | None = None
        self._atlas: moderngl.Texture | None = None
        self._height = 0
        self._lines: tuple[str, ...] = ()
        self._count = 0

    def draw(self, lines: tuple[str, ...], target: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Draw `lines` over the content of `target`; does nothing if there are none."""
        if not lines:
            return
        height = max(12, round(size[1] / _LINES_PER_HEIGHT))
        if height != self._height:
            self._make_atlas(height)
        if lines != self._lines:
            self._lay_out(lines)
        assert self._atlas is not None
        target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._atlas.use(1)
        set_uniform(self._program, "atlas", 1)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._count)
        self._ctx.disable(moderngl.BLEND)

    def _make_atlas(self, height: int) -> None:
        self._height, self._lines = height, ()
        self._lettering = bake_atlas(height)
        picture = self._lettering.coverage
        if self._atlas is not None:
            self._atlas.release()
        self._atlas = self._ctx.texture((picture.shape[1], picture.shape[0]), 1, picture.tobytes(), alignment=1)
        self._atlas.filter = (moderngl.NEAREST, moderngl.NEAREST)
        set_uniform(self._program, "cell", self._lettering.cell)

    def _lay_out(self, lines: tuple[str, ...]) -> None:
        assert self._lettering is not None
        edge = 0.8 * self._height
        inset = 0.6 * self._height
        letters = self._lettering.lay_out(lines, (round(edge + inset), round(edge + inset)), _MAX_LETTERS)
        wide = max(self._lettering.width(line) for line in lines) + 2 * inset
        tall = len(lines) * self._lettering.cell[1] + 2 * inset
        set_uniform(self._program, "panel", (edge, edge, wide, tall))
        data = np.concatenate([np.zeros((1, 4), np.float32), letters])  # the first one is the panel
        self._buffer.write(np.ascontiguousarray(data, np.float32))
        self._count, self._lines = len(data), lines

    def release(self) -> None:
        """Free everything."""
        if self._atlas is not None:
            self._atlas.release()
        release_all(self._array, self._buffer, self._program)


_STROKES_PER_HEIGHT: Final = 540
"""Number of stroke widths that fill the picture's height."""


class GuidePass:
    """Draws the operator's guides: strokes over the picture that show plans. Costs nothing while there are none."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "guide_vertex.glsl", "guide_fragment.glsl")
        self._buffer = ctx.buffer(reserve=GUIDE_CAPACITY * 40, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "3f 3f 4f/i", "in_begin", "in_end", "in_colour")])

    def draw(self, view: StageView, target: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Draw the view's guides over the content of `target`, whose size is `size` [pixels]."""
        if view.guide_count <= 0:
            return
        count = min(view.guide_count, GUIDE_CAPACITY)
        self._buffer.write(view.guide[:count])
        set_uniform(self._program, "breadth", max(0.5, 0.5 * size[1] / _STROKES_PER_HEIGHT))
        target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        self._ctx.disable(moderngl.BLEND)

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._program)


class FrameTimeGraphPass:
    """Draws a bar graph of the last frame intervals; late frames stand out. Costs nothing while it is off."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "graph_vertex.glsl", "graph_fragment.glsl", (("FRAMES", GRAPH_FRAMES),))
        self._buffer = ctx.buffer(reserve=(GRAPH_FRAMES + 3) * 4, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "1f/i", "in_time")])
        self._values: npt.NDArray[np.float32] = np.zeros(GRAPH_FRAMES + 3, np.float32)
        self.times = self._values[3:]
        """Frame intervals [ms], oldest first; the caller fills the first `count`."""
        self.count = 0
        self.period = 0.0
        """Intended frame interval [ms]; 0: no graph."""

    def draw(self, target: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Draw the graph in the lower left corner of `target`."""
        if self.period <= 0.0 or self.count == 0:
            return
        target.use()
        self._values[3 + self.count :] = 0.0
        self._buffer.write(self._values)
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        edge = max(8.0, size[1] / 42.0)
        set_uniform(self._program, "panel", (edge, edge, 0.28 * size[0], 0.11 * size[1]))
        set_uniform(self._program, "period", self.period)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=GRAPH_FRAMES + 3)
        self._ctx.disable(moderngl.BLEND)

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._program)
