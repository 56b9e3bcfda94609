"""Bodies drawn in a style, in the place of plain ones: lit, flat, dissolving, with ink along their contours."""

import moderngl

from live.render.dancers.dancer_batch import Crowd
from live.render.gl_release import release_all
from live.render.shader import WORN, program, set_uniform


class StyledPass:
    """Draws opaque surfaces into the bound target: lit, or (`surface`) as the surfaces that other passes read."""

    def __init__(self, ctx: moderngl.Context, *, worn: bool = False) -> None:
        self._ctx = ctx
        self._programs = [
            (
                program(ctx, "styled_vertex.glsl", "styled_fragment.glsl", (("SOFT", 1), ("SURFACE", surface))),
                program(ctx, "contour_vertex.glsl", "contour_fragment.glsl", (("SOFT", 1), ("SURFACE", surface))),
            )
            for surface in (0, 1)
        ]
        self._worn = [
            program(ctx, "styled_vertex.glsl", "styled_fragment.glsl", (("SOFT", 1), ("SURFACE", surface), *WORN))
            for surface in (0, 1)
            if worn
        ]

    def draw(self, crowd: Crowd, floor_map: moderngl.Texture, *, surface: bool = False) -> None:
        """Draw all bodies that are not plain."""
        ctx, quality = self._ctx, crowd.quality
        body, ink = self._programs[surface]
        ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        ctx.depth_func = "<="
        floor_map.use(1)
        worn = self._worn[surface] if self._worn else None
        for linked in filter(None, (body, worn)):
            set_uniform(linked, "floor_map", 1)
        for where, level in (("near", quality.near_level), ("far", quality.far_level)):
            crowd.draw(body, level, f"bodies {where}", worn=worn)
        ctx.front_face = "cw"  # the insides of the swollen body
        for where, level in (("near", quality.near_level), ("far", quality.far_level)):
            crowd.draw(ink, level, f"ink {where}")
        ctx.front_face = "ccw"
        ctx.depth_func = "<"

    def release(self) -> None:
        """Free the programs."""
        release_all(*(one for both in self._programs for one in both), *self._worn)
