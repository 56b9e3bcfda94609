"""The overlay's graph of the last frames: a bar for each, from frame to frame; what was late stands out."""

import moderngl
import numpy as np
import numpy.typing as npt

from live.render.frame_times import SHOWN
from live.render.gl_release import release_all
from live.render.shader import program, set_uniform


class GraphPass:
    """Draws nothing, at no cost, where there is nothing to show."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = program(ctx, "graph_vertex.glsl", "graph_fragment.glsl", (("FRAMES", SHOWN),))
        self._buffer = ctx.buffer(reserve=(SHOWN + 3) * 4, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "1f/i", "in_time")])
        self._values: npt.NDArray[np.float32] = np.zeros(SHOWN + 3, np.float32)
        self.times = self._values[3:]
        """Milliseconds from frame to frame, oldest first: fill the first `count`."""
        self.count = 0
        self.period = 0.0
        """What a frame should take [ms]; 0: there is no graph."""

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
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=SHOWN + 3)
        self._ctx.disable(moderngl.BLEND)

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._program)
