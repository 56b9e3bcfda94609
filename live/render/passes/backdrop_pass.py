"""Floor, back wall and light in the haze: computed once for a camera, light and size, then kept."""

import moderngl

from live.render.gl_release import release_all
from live.render.shader import program
from live.render.uniforms import WALL_BEHIND


class BackdropPass:
    """Result: `texture`, linear light; its alpha says how much of it a shadow on the floor takes away.

    While light or camera move, each frame needs another one: where the processor draws (`coarse`) that is drawn at
    half the size, smoothly stretched, until they stand.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], *, coarse: bool) -> None:
        self._ctx, self._divisor = ctx, 2 if coarse else 1
        self._program = program(ctx, "full_vertex.glsl", "backdrop_fragment.glsl", (("WALL_BEHIND", WALL_BEHIND),))
        self._triangle = ctx.vertex_array(self._program, [])
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self.texture = self._ctx.texture(size, 4, dtype="f2")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._fine, self._fine_target = self.texture, self._ctx.framebuffer([self.texture])
        small = (max(size[0] // self._divisor, 1), max(size[1] // self._divisor, 1))
        self._small = self._ctx.texture(small, 4, dtype="f2")
        self._small.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._small.repeat_x = self._small.repeat_y = False
        self._small_target = self._ctx.framebuffer([self._small])
        self._kept = False

    def draw(self, *, moving: bool) -> None:
        """Fill `texture` if it is not kept; `moving`: light or camera are others than in the frame before."""
        if self._kept:
            return
        coarse = moving and self._divisor > 1
        self.texture = self._small if coarse else self._fine
        (self._small_target if coarse else self._fine_target).use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._kept = not coarse

    def forget(self) -> None:
        """Light or camera are others: what was kept is of no use any more."""
        self._kept = False

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels], or a new scene: what was kept is forgotten."""
        self._release_targets()
        self._make(size)

    def _release_targets(self) -> None:
        release_all(self._fine_target, self._fine, self._small_target, self._small)

    def release(self) -> None:
        """Free everything."""
        self._release_targets()
        release_all(self._triangle, self._program)
