"""Render passes for the stage: cached backdrop (floor, wall, haze), with shadows, elements and reflections over it.

The backdrop is computed once for a camera, light and size.
"""

from collections.abc import Mapping
from typing import Final

import moderngl

from live.base.parameter import WORLD_NAMES
from live.render.shader import compile_program, release_all, set_uniform
from live.render.uniforms import WALL_DISTANCE

_FLOOR_VARIANTS: Final = (
    (0, 0, 0, 0), (0, 0, 0, 1), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 1, 1), (1, 1, 1, 1),
)  # fmt: skip
"""What programs of the floor have: the border of another stage, gobos and patterns, water, spots and beams. The first
that has all that is seen is taken."""

LONG_STILL: Final = 24
"""After so many frames without a change it is no longer expected that light or camera go on moving."""


class StagePass:
    """Fills all pixels of the target that no dancer covers; above the floor with a cheaper program."""

    def __init__(self, ctx: moderngl.Context, *, hdr: bool) -> None:
        """`hdr`: output compressed light, for later tone mapping; otherwise display values."""
        self._ctx = ctx
        variants = [(1, *floor) for floor in _FLOOR_VARIANTS] + [(0, 0, 0, 0, lamps) for lamps in (0, 1)]
        names = "FLOOR", "EDGE", "PATTERNS", "WATER", "BEAMS"
        self._programs = [
            compile_program(
                ctx, "full_vertex.glsl", "stage_fragment.glsl",
                (("HDR", int(hdr)), *zip(names, variant, strict=True)),
            )
            for variant in variants
        ]  # fmt: skip
        self._triangles = [ctx.vertex_array(linked, []) for linked in self._programs]

    def draw(
        self,
        target: moderngl.Framebuffer,
        floor_rows: int,
        backdrop: moderngl.Texture,
        floor_map: moderngl.Texture,
        mirror: moderngl.Texture,
        *,
        lamps: bool = False,
        beams: bool = False,
        resized: bool = True,
        patterned: bool = False,
        water: bool = False,
    ) -> None:
        """Draw at the far plane, after the dancers; the floor is visible only in the lowest `floor_rows` rows.

        `lamps`: with the pools of spots; `beams`: with their light before it; `resized`: the stage size may differ from
        the scene's; `patterned`: with gobos and patterns; `water`: with waves.
        """
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.depth_func = "<="
        width, height = target.size
        for unit, texture in enumerate((backdrop, floor_map, mirror), start=1):
            texture.use(unit)
        regions = ((0, 0, width, floor_rows), (0, floor_rows, width, height - floor_rows))
        seen = resized, patterned, water, lamps or beams
        floor = next(
            index
            for index, has in enumerate(_FLOOR_VARIANTS)
            if all(one <= other for one, other in zip(seen, has, strict=True))
        )
        for which, region in ((floor, regions[0]), (len(_FLOOR_VARIANTS) + beams, regions[1])):
            linked, triangle = self._programs[which], self._triangles[which]
            if region[3] <= 0:
                continue
            for unit, name in enumerate(("backdrop", "floor_map", "mirror"), start=1):
                set_uniform(linked, name, unit)
            set_uniform(linked, "beams", int(beams))
            target.scissor = region
            triangle.render(moderngl.TRIANGLES, vertices=3)
        target.scissor = (0, 0, width, height)
        self._ctx.depth_func = "<"

    def release(self) -> None:
        """Free everything."""
        release_all(*self._triangles, *self._programs)


class BackdropPass:
    """Fills `texture` with square roots of light; alpha: the share of it that a shadow on the floor removes.

    Each world has a program of its own; while worlds fade into each other the shares of all are added.

    While light or camera move, each frame needs a new backdrop. With software rendering (`coarse`) it is then drawn at
    half the size and enlarged, until they stop; if they move again and again, until they have stopped for a while.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], *, coarse: bool) -> None:
        self._ctx, self._divisor = ctx, 2 if coarse else 1
        self._still = self._patience = LONG_STILL
        self._programs = {
            name: compile_program(ctx, "full_vertex.glsl", f"{name}_fragment.glsl", (("WALL_BEHIND", WALL_DISTANCE),))
            for name in WORLD_NAMES
        }
        self._triangles = {name: ctx.vertex_array(linked, []) for name, linked in self._programs.items()}
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self.texture = self._ctx.texture(size, 4, dtype="f2")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.texture.repeat_x = self.texture.repeat_y = False  # waves look beyond its edges
        self._full_size, self._full_size_target = self.texture, self._ctx.framebuffer([self.texture])
        small = (max(size[0] // self._divisor, 1), max(size[1] // self._divisor, 1))
        self._small = self._ctx.texture(small, 4, dtype="f2")
        self._small.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._small.repeat_x = self._small.repeat_y = False
        self._small_target = self._ctx.framebuffer([self._small])
        self._is_cached = False

    def draw(self, worlds: Mapping[str, float], *, moving: bool) -> None:
        """Fill `texture` unless it holds what is due, with the share of each world; `moving`: light or camera have
        changed since the last frame."""
        self._count(moving=moving)
        coarse = self._divisor > 1 and self._still < self._patience
        if self._is_cached and (coarse or self.texture is self._full_size):
            return
        self.texture = self._small if coarse else self._full_size
        (self._small_target if coarse else self._full_size_target).use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        for name, share in worlds.items():
            if share <= 0.0:
                continue
            set_uniform(self._programs[name], "share", share)
            self._triangles[name].render(moderngl.TRIANGLES, vertices=3)
            self._ctx.enable(moderngl.BLEND)  # the first one fills, the others are added
            self._ctx.blend_func = moderngl.ONE, moderngl.ONE
        self._ctx.disable(moderngl.BLEND)
        self._is_cached = True

    def _count(self, *, moving: bool) -> None:
        if moving:
            self._patience = 1 if self._still >= LONG_STILL else LONG_STILL
        self._still = 0 if moving else self._still + 1

    def follow(self, *, moving: bool) -> None:
        """Count a frame that is not drawn; `moving` as for `draw`."""
        self._count(moving=moving)
        self._is_cached = False

    def begin_anew(self) -> None:
        """Forget all frames."""
        self._still = self._patience = LONG_STILL
        self.texture, self._is_cached = self._full_size, False

    def invalidate(self) -> None:
        """Invalidate the cache, after light or camera have changed."""
        self._is_cached = False

    def resize(self, size: tuple[int, int]) -> None:
        """Set the size of the picture [pixels]; also for a new scene. Invalidates the cache."""
        self._release_targets()
        self._make(size)

    def _release_targets(self) -> None:
        release_all(self._full_size_target, self._full_size, self._small_target, self._small)

    def release(self) -> None:
        """Free everything."""
        self._release_targets()
        release_all(*self._triangles.values(), *self._programs.values())
