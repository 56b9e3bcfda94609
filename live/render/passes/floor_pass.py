"""Render passes for the floor: a map of shadows, elements and set seen from above, and blurred reflections.

Shadows are the dancers projected along the key light, in three layers by height above the floor. Higher layers are
blurred wider, so shadows of feet are sharp and those of arms soft.
"""

from collections.abc import Callable, Sequence
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32, Float64
from live.base.stage_snapshot import StageView
from live.render.adaptive_quality import Quality
from live.render.body.body_mesh import COARSE
from live.render.dancers.dancer_batch import DancerBatch
from live.render.passes.element_pass import ElementPass
from live.render.passes.set_pass import SetPass
from live.render.shader import WORN, compile_program, release_all, set_uniform

_TAPS: Final = 5
_BLUR_RADII: Final = (0.6, 1.3, 2.6)
"""Blur radius of the three layers in texels of a map of 256."""


class FloorPass:
    """Fills `texture`, which covers the stage and a margin; RGB: light to add, alpha: light to remove."""

    def __init__(self, ctx: moderngl.Context, quality: Quality, floor_size: tuple[float, float]) -> None:
        self._ctx = ctx
        self.casters: list[Callable[[], None]] = []
        """Other shadow casters: each draws into the bound layers."""
        self._shadow_programs = [
            compile_program(ctx, "shadow_vertex.glsl", "shadow_fragment.glsl", (("SOFT", 0), ("STYLED", styled)))
            for styled in (0, 1)
        ]
        self._taps = taps = round(_TAPS * max(quality.floor_map / 256, 1.0))
        self._blurs = [
            compile_program(ctx, "full_vertex.glsl", "blur_fragment.glsl", (("TAPS", taps), ("LAST", last)))
            for last in (0, 1)
        ]
        self._triangles = [ctx.vertex_array(blur, []) for blur in self._blurs]
        self._floor_size, self._long_side = floor_size, quality.floor_map
        texel = max(floor_size) / quality.floor_map
        self._pools = compile_program(ctx, "full_vertex.glsl", "pool_fragment.glsl")
        self._pool_triangle = ctx.vertex_array(self._pools, [])
        self._elements = ElementPass(ctx, texel)
        self._set = SetPass(ctx, texel)
        self._framebuffers: dict[int, list[moderngl.Framebuffer]] = {}
        self._maps: dict[int, tuple[moderngl.Texture, ...]] = {}
        self.select_resolution(quality.floor_map)

    def set_floor_size(self, floor_size: tuple[float, float]) -> None:
        """Cover another floor, width by depth [m]; `texture` is another one from now on."""
        known = tuple(self._maps)
        self._release_maps()
        self._floor_size = floor_size
        for long_side in known:
            self._maps[long_side] = self._make(long_side)
        self.select_resolution(self._long_side)

    def select_resolution(self, long_side: int) -> None:
        """Select a map with `long_side` texels along its longer side; each size is created once."""
        self._long_side = long_side
        if long_side not in self._maps:
            self._maps[long_side] = self._make(long_side)
        self._layers, self._half_blurred, self.texture = textures = self._maps[long_side]
        self._targets = self._framebuffers[long_side]
        width, depth = textures[-1].size
        for blur, stride in zip(self._blurs, ((1.0 / width, 0.0), (0.0, 1.0 / depth)), strict=True):
            set_uniform(blur, "layers", 1)
            set_uniform(blur, "stride", stride)
            set_uniform(blur, "weights", _weights(self._taps, long_side / 256))
        self._elements.set_texel(max(self._floor_size) / long_side)
        self._set.set_texel(max(self._floor_size) / long_side)

    def _make(self, long_side: int) -> tuple[moderngl.Texture, ...]:
        scale = long_side / max(self._floor_size)
        width, depth = (max(round(side * scale), 8) for side in self._floor_size)
        sizes = (((2 * width, 2 * depth), "f1"), ((width, depth), "f1"), ((width, depth), "f2"))
        textures = tuple(self._texture(size, kind) for size, kind in sizes)
        self._framebuffers[long_side] = [self._ctx.framebuffer([texture]) for texture in textures]
        return textures

    def _texture(self, size: tuple[int, int], kind: str) -> moderngl.Texture:
        texture = self._ctx.texture(size, 4, dtype=kind)
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def draw(
        self,
        crowd: DancerBatch,
        view: StageView,
        light: Float32,
        boxes: Sequence[Float64] = (),
        *,
        shadows: bool = True,
        beams: bool = False,
    ) -> None:
        """Fill `texture` for this frame, with the dancers' `shadows` or without, and with the pools of `beams`.

        `light` (3,): direction towards the key light; `boxes`: around the other casters, shape (2, 3) each.
        """
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        if shadows:
            self._draw_shadows(crowd, self._shadow_rectangle(crowd, light, boxes))
        else:
            self._targets[-1].use()
            self._targets[-1].clear()
        if beams:
            self._ctx.enable(moderngl.BLEND)
            self._ctx.blend_func = moderngl.ONE, moderngl.ONE
            self._pool_triangle.render(moderngl.TRIANGLES, vertices=3)
            self._ctx.disable(moderngl.BLEND)
        self._elements.draw(view)
        self._set.draw(view)

    def _shadow_rectangle(
        self, crowd: DancerBatch, light: Float32, boxes: Sequence[Float64]
    ) -> tuple[int, int, int, int]:
        """Return the texels (x, y, width, height) that blurred shadows may reach; elsewhere is nothing to blur."""
        low, high = crowd.casting_box()
        for box in boxes:
            low, high = np.minimum(low, box[0]), np.maximum(high, box[1])
        if low[0] > high[0]:
            return 0, 0, 0, 0
        size = np.array(self.texture.size)
        way = -light[[0, 2]].astype(np.float64) / float(light[1]) * max(float(high[1]), 0.0)
        ends = np.array([low[[0, 2]] + np.minimum(way, 0.0), high[[0, 2]] + np.maximum(way, 0.0)])
        texel = (ends / self._floor_size + 0.5) * size
        start = np.clip(np.floor(texel[0]) - self._taps - 1, 0, size).astype(int)
        stop = np.clip(np.ceil(texel[1]) + self._taps + 1, start, size).astype(int)
        return int(start[0]), int(start[1]), int(stop[0] - start[0]), int(stop[1] - start[1])

    def _draw_shadows(self, crowd: DancerBatch, where: tuple[int, int, int, int]) -> None:
        ctx = self._ctx
        self._targets[0].use()
        self._targets[0].clear()
        ctx.enable(moderngl.BLEND)
        ctx.blend_equation = moderngl.MAX, moderngl.MAX
        crowd.draw(self._shadow_programs[crowd.styles.has_effects], COARSE)
        for cast in self.casters:
            cast()
        ctx.blend_equation = moderngl.FUNC_ADD, moderngl.FUNC_ADD
        ctx.disable(moderngl.BLEND)
        for source, target, triangle in zip(
            (self._layers, self._half_blurred), self._targets[1:], self._triangles, strict=True
        ):
            target.use()
            target.clear()
            if where[2] and where[3]:
                target.scissor = where
                source.use(1)
                triangle.render(moderngl.TRIANGLES, vertices=3)
                target.scissor = (0, 0, *target.size)

    def _release_maps(self) -> None:
        for long_side, textures in self._maps.items():
            release_all(*self._framebuffers[long_side], *textures)
        self._maps.clear()
        self._framebuffers.clear()

    def release(self) -> None:
        """Free everything."""
        self._release_maps()
        release_all(*self._triangles, self._pool_triangle, self._pools)
        release_all(self._elements, self._set, *self._shadow_programs, *self._blurs)


def _weights(taps: int, scale: float) -> list[tuple[float, ...]]:
    """Return the blur weights by distance in texels for the three layers, shape (taps + 1, 3); both sides sum to 1."""
    steps = np.arange(taps + 1)[:, None]
    weights = np.exp(-0.5 * (steps / (scale * np.array(_BLUR_RADII))) ** 2)
    weights /= 2.0 * weights.sum(axis=0) - weights[0]
    return [tuple(row) for row in weights.tolist()]


_EXTRA_ROWS: Final = 4
"""Additional rows above the floor that the blur reads."""


class ReflectionPass:
    """Fills `texture` with the blurred reflections of the dancers in the floor, as square roots of light."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], divisor: int, *, characters: bool = False) -> None:
        self._ctx, self._divisor = ctx, divisor
        self.mirrored: list[Callable[[], None]] = []
        """What else is mirrored: each draws into the bound target."""
        self._programs = [
            compile_program(ctx, "mirror_vertex.glsl", "mirror_fragment.glsl", (("SOFT", 0), ("STYLED", styled)))
            for styled in (0, 1)
        ]
        self._character_programs = [
            compile_program(ctx, "mirror_vertex.glsl", "mirror_fragment.glsl", (("SOFT", 0), ("STYLED", styled), *WORN))
            for styled in (0, 1)
            if characters
        ]
        self._blur = compile_program(ctx, "full_vertex.glsl", "gloss_fragment.glsl")
        self._triangle = ctx.vertex_array(self._blur, [])
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        small = (max(size[0] // self._divisor, 1), max(size[1] // self._divisor, 1))
        self._drawn, self.texture = self._ctx.texture(small, 4), self._ctx.texture(small, 4)
        for texture in (self._drawn, self.texture):
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._depth = self._ctx.depth_renderbuffer(small)
        self._target = self._ctx.framebuffer([self._drawn], self._depth)
        self._result = self._ctx.framebuffer([self.texture])
        self._is_black = False

    def draw(self, crowd: DancerBatch, *, visible: bool = True, rows: int | None = None) -> None:
        """Fill `texture` for this frame: with the dancers' reflections, or black if `visible` is false.

        `rows`: rows of the picture, from below, in which the floor is visible; None: all.
        """
        if not visible:
            if not self._is_black:
                self._result.scissor = (0, 0, *self.texture.size)
                self._result.clear()
            self._is_black = True
            return
        self._is_black = False
        width, height = self.texture.size
        height = height if rows is None else min(-(-rows // self._divisor) + _EXTRA_ROWS, height)
        self._target.scissor = self._result.scissor = (0, 0, width, height)
        self._target.use()
        self._target.clear()
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.front_face = "cw"  # mirrored
        styled = crowd.styles.has_effects
        crowd.draw(
            self._programs[styled],
            COARSE,
            "mirrored",
            character_program=self._character_programs[styled] if self._character_programs else None,
        )
        for draw in self.mirrored:
            draw()
        self._ctx.front_face = "ccw"
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._result.use()
        self._drawn.use(1)
        set_uniform(self._blur, "drawn", 1)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_target()
        self._make(size)

    def _release_target(self) -> None:
        release_all(self._target, self._result, self._drawn, self.texture, self._depth)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        release_all(self._triangle, *self._programs, *self._character_programs, self._blur)
