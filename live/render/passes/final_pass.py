"""The end of a picture in half floats: the glow that was gathered last, the film curve, vignette, sRGB, dither."""

import moderngl

from live.render.gl_release import release_all
from live.render.shader import program, set_uniform


class FinalPass:
    """Draws compressed light as it is shown: 8 bits, sRGB."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._programs = [
            program(ctx, "full_vertex.glsl", "finish_fragment.glsl", (("GLOW", glow),)) for glow in (0, 1)
        ]
        self._triangles = [ctx.vertex_array(linked, []) for linked in self._programs]

    def draw(
        self,
        source: moderngl.Texture,
        target: moderngl.Framebuffer,
        glow: moderngl.Texture | None = None,
        strength: float = 0.0,
    ) -> None:
        """Draw `source` onto `target`, with so much of a `glow` if there is one."""
        linked = self._programs[glow is not None]
        target.use()
        source.use(1)
        set_uniform(linked, "light", 1)
        if glow is not None:
            glow.use(2)
            set_uniform(linked, "glow", 2)
            set_uniform(linked, "strength", strength)
        self._triangles[glow is not None].render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._triangles, *self._programs)
