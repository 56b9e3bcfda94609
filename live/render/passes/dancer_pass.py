"""The dancers, lit while they are drawn (with multisampling)."""

import moderngl

from live.render.crowd import Crowd
from live.render.quality import Quality
from live.render.shader import program, set_uniform


class DancerPass:
    """Draws near and far dancers into the bound target, with depth."""

    def __init__(self, ctx: moderngl.Context, quality: Quality) -> None:
        self._ctx, self.quality = ctx, quality
        self._program = program(ctx, "dancer_vertex.glsl", "dancer_fragment.glsl", (("SOFT", 1),))

    def draw(self, crowd: Crowd, floor_map: moderngl.Texture) -> None:
        """Draw all dancers of this moment, the near ones first (they hide others)."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        floor_map.use(1)
        set_uniform(self._program, "floor_map", 1)
        crowd.draw(self._program, self.quality.near_level, "near")
        crowd.draw(self._program, self.quality.far_level, "far")

    def release(self) -> None:
        """Free the program."""
        self._program.release()
