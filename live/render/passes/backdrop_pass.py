"""Floor, back wall and light in the haze: computed once for a camera and size, then kept."""

import moderngl

from live.render.frame import WALL_BEHIND
from live.render.release import release_all
from live.render.shader import program


class BackdropPass:
    """Result: `texture`, linear light; its alpha says how much of it a shadow on the floor takes away."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._ctx = ctx
        self._program = program(ctx, "full_vertex.glsl", "backdrop_fragment.glsl", (("WALL_BEHIND", WALL_BEHIND),))
        self._triangle = ctx.vertex_array(self._program, [])
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self.texture = self._ctx.texture(size, 4, dtype="f2")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._target = self._ctx.framebuffer([self.texture])
        self._kept = False

    def draw(self) -> None:
        """Fill `texture` if it is not yet kept."""
        if self._kept:
            return
        self._target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._kept = True

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels], or a new scene: what was kept is forgotten."""
        self._target.release()
        self.texture.release()
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self.texture, self._triangle, self._program)
