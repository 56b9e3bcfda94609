"""X-ray: a skeleton that glows in a body of glass."""

from typing import Any

import moderngl

from live.render.dancers.dancer_batch import Crowd
from live.render.dancers.xray_skeleton import bone_vertices
from live.render.gl_release import release_all
from live.render.pass_context import Making
from live.render.shader import program


class XrayPass:
    """Draws over the bound target, which must not write depth."""

    def __init__(self, making: Making) -> None:
        ctx = self._ctx = making.ctx
        constants = (("SOFT", 0),)
        self._glass = program(ctx, "styled_vertex.glsl", "glass_fragment.glsl", constants)
        self._bone = program(ctx, "bone_vertex.glsl", "bone_fragment.glsl", constants)
        self._bones = ctx.buffer(bone_vertices().tobytes())

    def draw(self, crowd: Crowd) -> None:
        """Draw all dancers who are looked through."""
        self._ctx.enable(moderngl.CULL_FACE)
        crowd.draw(self._glass, crowd.quality.ghost_level, "xray")
        self._ctx.disable(moderngl.CULL_FACE)
        crowd.draw_other(self._bone, "xray", self._vertices, moderngl.TRIANGLES)

    def _vertices(self, body: str) -> tuple[Any, ...]:
        return self._bones, "4f 4f 4f", "in_begin", "in_end", "in_bone"

    def release(self) -> None:
        """Free everything."""
        release_all(self._bones, self._glass, self._bone)
