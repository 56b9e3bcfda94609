"""The handle pass: points that can be moved, and a few lines of help, over an output that is being bent."""

from collections.abc import Sequence
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.render.gl_release import release_all
from live.render.lettering import letter
from live.render.outputs.output import Point
from live.render.shader import program, set_uniform

_LIMIT: Final = 1600
"""Points and letters at most."""
_LETTERS: Final = 1024
_PER_HEIGHT: Final = 38
"""Lines of text that would fill the window."""
_RADIUS: Final = 0.022
"""Of a point's mark, as a share of the window's height."""

Float32 = npt.NDArray[np.float32]


class HandlePass:
    """Belongs to the context of the output's window; letters are baked for its height."""

    def __init__(self, ctx: moderngl.Context, height: int) -> None:
        self._ctx = ctx
        self._program = program(ctx, "handle_vertex.glsl", "handle_fragment.glsl")
        self._buffer = ctx.buffer(reserve=_LIMIT * 32, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f 4f/i", "in_box", "in_what")])
        self._height = max(12, round(height / _PER_HEIGHT))
        self._lettering = letter(self._height)
        baked = self._lettering.picture
        self._atlas = ctx.texture((baked.shape[1], baked.shape[0]), 1, baked.tobytes(), alignment=1)
        self._atlas.filter = (moderngl.NEAREST, moderngl.NEAREST)
        set_uniform(self._program, "atlas", 1)

    def draw(self, points: Sequence[Point], chosen: int, lines: tuple[str, ...], target: moderngl.Framebuffer) -> None:
        """Draw marks at `points` [shares of the window], one of them chosen, and lines of text, over the target."""
        size = target.viewport[2:]
        marks = np.concatenate([self._panel(lines, size), self._points(points, chosen, size)])[:_LIMIT]
        self._buffer.write(np.ascontiguousarray(marks, np.float32))
        set_uniform(self._program, "window_size", size)
        target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._atlas.use(1)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=len(marks))
        self._ctx.disable(moderngl.BLEND)

    def _points(self, points: Sequence[Point], chosen: int, size: tuple[int, int]) -> Float32:
        radius = _RADIUS * size[1]
        marks = np.zeros((len(points), 8), np.float32)
        place = np.array(points, np.float32).reshape(-1, 2) * size
        inside = np.clip(place, 0.7 * radius, np.array(size) - 0.7 * radius)  # a corner beside the window stays in hand
        marks[:, 0:2], marks[:, 2:4] = inside - radius, 2.0 * radius
        marks[:, 6] = 2.0
        if 0 <= chosen < len(marks):
            marks[chosen, 7] = 1.0
        return marks

    def _panel(self, lines: tuple[str, ...], size: tuple[int, int]) -> Float32:
        """A panel with lines of text in the lower part of the window."""
        if not lines:
            return np.zeros((0, 8), np.float32)
        cell, inset = self._lettering.cell, 0.6 * self._height
        wide = max(self._lettering.width(line) for line in lines) + 2.0 * inset
        tall = len(lines) * cell[1] + 2.0 * inset
        x, y = round(0.5 * (size[0] - wide)), round(0.68 * size[1])
        letters = self._lettering.lay_out(lines, (round(x + inset), round(y + inset)), _LETTERS)
        marks = np.zeros((len(letters) + 1, 8), np.float32)
        marks[0, :4] = x, y, wide, tall
        marks[1:, 0:2], marks[1:, 2:4] = letters[:, 0:2], cell
        marks[1:, 4:6], marks[1:, 6] = letters[:, 2:4], 1.0
        return marks

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._atlas, self._program)
