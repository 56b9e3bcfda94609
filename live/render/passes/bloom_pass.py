"""Bloom: a glow around bright areas, extracted at a quarter of the size, blurred and added."""

from typing import Final

import moderngl

from live.base.arrays import Float64
from live.base.picture_parameters import BY_ADDRESS
from live.render.pass_context import HDR, Moment, PassSetup, Surfaces
from live.render.shader import compile_program, release_all, set_uniform

_DIVISOR: Final = 4
_TEXELS: Final = 10
"""How far the glow spreads, in texels of its picture (`spread_fragment.glsl`)."""
_AMOUNT: Final = BY_ADDRESS["/dance/pass/bloom"].first
STRENGTH: Final = 0.22
"""Factor of the glow at amount 1."""


class BloomPass:
    """`compute_glow` computes the glow; `draw` adds it. As the last pass it is added by tone mapping, which saves a
    pass."""

    needs_surfaces = False

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._bright = compile_program(ctx, "full_vertex.glsl", "bright_fragment.glsl")
        self._spread = compile_program(ctx, "full_vertex.glsl", "spread_fragment.glsl", (("TEXELS", _TEXELS),))
        self._add = compile_program(ctx, "full_vertex.glsl", "bloom_fragment.glsl")
        self._triangles = [ctx.vertex_array(linked, []) for linked in (self._bright, self._spread, self._add)]
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        self._small = small = (max(size[0] // _DIVISOR, 1), max(size[1] // _DIVISOR, 1))
        self._glows = [self._ctx.texture(small, 4, dtype=HDR) for _ in range(2)]
        for texture in self._glows:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._targets = [self._ctx.framebuffer([glow]) for glow in self._glows]

    @staticmethod
    def reach(height: float, row: Float64) -> float:
        """Return how far from a pixel it looks, with these parameters, in a picture of this height [pixels]."""
        return float(_DIVISOR * (_TEXELS + 2))

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        return moment.parameter(_AMOUNT) > 0.0

    def strength(self, moment: Moment) -> float:
        """Return the factor of the glow."""
        return STRENGTH * moment.parameter(_AMOUNT)

    def compute_glow(self, source: moderngl.Texture) -> moderngl.Texture:
        """Return the glow of `source`, linear light at a quarter of its size."""
        self._draw_step(self._targets[0], self._bright, 0, source)
        for read, into, stride in ((0, 1, (1.0 / self._small[0], 0.0)), (1, 0, (0.0, 1.0 / self._small[1]))):
            set_uniform(self._spread, "stride", stride)
            self._draw_step(self._targets[into], self._spread, 1, self._glows[read])
        return self._glows[0]

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with its glow."""
        self.compute_glow(source).use(2)
        set_uniform(self._add, "glow", 2)
        set_uniform(self._add, "strength", self.strength(moment))
        self._draw_step(target, self._add, 2, source)

    def _draw_step(
        self, target: moderngl.Framebuffer, linked: moderngl.Program, triangle: int, source: moderngl.Texture
    ) -> None:
        target.use()
        source.use(1)
        set_uniform(linked, "light", 1)
        self._triangles[triangle].render(moderngl.TRIANGLES, vertices=3)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        release_all(*self._targets, *self._glows)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._glows, *self._triangles, self._bright, self._spread, self._add)
