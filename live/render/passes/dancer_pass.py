"""The dancers, lit while they are drawn (with multisampling)."""

import moderngl

from live.render.dancers.dancer_batch import Crowd
from live.render.gl_release import release_all
from live.render.quality import Quality
from live.render.shader import WORN, program, set_uniform


class DancerPass:
    """Draws near and far dancers into the bound target, with depth."""

    def __init__(self, ctx: moderngl.Context, quality: Quality, *, worn: bool = False) -> None:
        self._ctx, self.quality = ctx, quality
        files = "dancer_vertex.glsl", "dancer_fragment.glsl"
        self._program = program(ctx, *files, (("SOFT", 1),))
        self._worn = program(ctx, *files, (("SOFT", 1), *WORN)) if worn else None

    def draw(self, crowd: Crowd, floor_map: moderngl.Texture) -> None:
        """Draw all dancers of this moment, the near ones first (they hide others)."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        floor_map.use(1)
        for linked in filter(None, (self._program, self._worn)):
            set_uniform(linked, "floor_map", 1)
        crowd.draw(self._program, self.quality.near_level, "near", worn=self._worn)
        crowd.draw(self._program, self.quality.far_level, "far", worn=self._worn)

    def release(self) -> None:
        """Free the programs."""
        release_all(*filter(None, (self._program, self._worn)))
