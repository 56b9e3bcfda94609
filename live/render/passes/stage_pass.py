"""The stage behind the dancers: the kept backdrop with shadows, elements and mirror images."""

from typing import Final

import moderngl

from live.render.gl_release import release_all
from live.render.shader import program, set_uniform

_WALL: Final = 3
"""The program for what is above the floor."""


class StagePass:
    """Fills every pixel of the bound target that no dancer covers; above the floor a cheaper program does."""

    def __init__(self, ctx: moderngl.Context, *, hdr: bool) -> None:
        """`hdr`: into compressed light, to be developed later; otherwise as it is shown."""
        self._ctx = ctx
        self._programs = [
            program(
                ctx, "full_vertex.glsl", "stage_fragment.glsl",
                (("HDR", int(hdr)), ("FLOOR", floor), ("POOLS", pools), ("EDGE", edge)),
            )
            for floor, edge, pools in ((1, 0, 0), (1, 1, 0), (1, 1, 1), (0, 0, 0))
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
        pools: bool = False,
        resized: bool = True,
    ) -> None:
        """Draw at the far plane, after the dancers; below `floor_rows` (from the bottom) the floor may be seen.

        `pools`: with the pools of spots and beams on it; `resized`: the stage may be of another size than the scene's.
        """
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.depth_func = "<="
        width, height = target.size
        for unit, texture in enumerate((backdrop, floor_map, mirror), start=1):
            texture.use(unit)
        regions = ((0, 0, width, floor_rows), (0, floor_rows, width, height - floor_rows))
        floor = 2 if pools else int(resized)
        for which, region in ((floor, regions[0]), (_WALL, regions[1])):
            linked, triangle = self._programs[which], self._triangles[which]
            if region[3] <= 0:
                continue
            for unit, name in enumerate(("backdrop", "floor_map", "mirror"), start=1):
                set_uniform(linked, name, unit)
            target.scissor = region
            triangle.render(moderngl.TRIANGLES, vertices=3)
        target.scissor = (0, 0, width, height)
        self._ctx.depth_func = "<"

    def release(self) -> None:
        """Free everything."""
        release_all(*self._triangles, *self._programs)
