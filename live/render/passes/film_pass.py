"""The last step of a multisampled picture: samples averaged, a glow around what is bright, the film curve."""

from typing import Final

import moderngl

from live.render.release import release_all
from live.render.shader import program, set_uniform

_GLOW_DIVISOR: Final = 4


class FilmPass:
    """Owns the target that the scene is drawn into: half floats, multisampled, with depth."""

    def __init__(self, ctx: moderngl.Context, samples: int, size: tuple[int, int]) -> None:
        self._ctx, self._samples = ctx, samples
        self._bright = program(ctx, "full_vertex.glsl", "bright_fragment.glsl")
        self._spread = program(ctx, "full_vertex.glsl", "spread_fragment.glsl")
        self._finish = program(ctx, "full_vertex.glsl", "finish_fragment.glsl")
        self._triangles = [ctx.vertex_array(linked, []) for linked in (self._bright, self._spread, self._finish)]
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        ctx = self._ctx
        self._many = ctx.renderbuffer(size, 4, samples=self._samples, dtype="f2")
        self._depth = ctx.depth_renderbuffer(size, samples=self._samples)
        self.target = ctx.framebuffer([self._many], self._depth)
        self._flat = ctx.texture(size, 4, dtype="f2")
        small = (max(size[0] // _GLOW_DIVISOR, 1), max(size[1] // _GLOW_DIVISOR, 1))
        self._glows = [ctx.texture(small, 4, dtype="f2") for _ in range(2)]
        for texture in (self._flat, *self._glows):
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._flat_target = ctx.framebuffer([self._flat])
        self._glow_targets = [ctx.framebuffer([glow]) for glow in self._glows]
        self._small = small

    def draw(self, target: moderngl.Framebuffer) -> None:
        """Develop what was drawn into `self.target` onto `target`."""
        ctx = self._ctx
        ctx.copy_framebuffer(self._flat_target, self.target)
        ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._step(self._glow_targets[0], self._bright, 0, self._flat)
        for source, into, stride in ((0, 1, (1.0 / self._small[0], 0.0)), (1, 0, (0.0, 1.0 / self._small[1]))):
            set_uniform(self._spread, "stride", stride)
            self._step(self._glow_targets[into], self._spread, 1, self._glows[source])
        self._glows[0].use(2)
        set_uniform(self._finish, "glow", 2)
        self._step(target, self._finish, 2, self._flat)

    def _step(
        self, target: moderngl.Framebuffer, linked: moderngl.Program, triangle: int, source: moderngl.Texture
    ) -> None:
        target.use()
        source.use(1)
        set_uniform(linked, "light", 1)
        self._triangles[triangle].render(moderngl.TRIANGLES, vertices=3)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_targets()
        self._make(size)

    def _release_targets(self) -> None:
        release_all(self.target, self._many, self._depth, self._flat_target, self._flat)
        release_all(*self._glow_targets, *self._glows)

    def release(self) -> None:
        """Free everything."""
        self._release_targets()
        release_all(*self._triangles, self._bright, self._spread, self._finish)
