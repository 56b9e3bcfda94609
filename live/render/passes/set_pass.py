"""The set on the floor: obstacles and walls as dark shapes with a rim of light, real dancers as a soft ring."""

from typing import Final

import moderngl
import numpy as np

from live.base.stage_snapshot import SET_CAPACITY, StageView
from live.render.gl_release import release_all
from live.render.shader import program, set_uniform

_WALL_THICKNESS: Final = 0.05
"""Half of what a wall is drawn thick [m]."""


class SetPass:
    """`draw` lays the set over the bound floor map, whose texels are `texel` [m] wide."""

    def __init__(self, ctx: moderngl.Context, texel: float) -> None:
        self._ctx = ctx
        self._program = program(ctx, "set_vertex.glsl", "set_fragment.glsl")
        self.fit(texel)
        self._staging = np.zeros((2 * SET_CAPACITY, 6), np.float32)
        self._buffer = ctx.buffer(reserve=self._staging.nbytes, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f 2f/i", "in_ends", "in_form")])

    def fit(self, texel: float) -> None:
        """The map has texels so wide [m] from now on."""
        set_uniform(self._program, "texel", texel)

    def draw(self, view: StageView) -> None:
        """Draw what stands on the stage now; nothing, at no cost, if it is empty."""
        walls = min(max(view.wall_count, 0), SET_CAPACITY)
        obstacles = min(max(view.obstacle_count, 0), SET_CAPACITY)
        count = walls + obstacles
        if not count:
            return
        wall, obstacle = self._staging[:walls], self._staging[walls:count]
        wall[:, :4] = view.wall[:walls]
        wall[:, 4:] = _WALL_THICKNESS, 1.0
        obstacle[:, :2] = obstacle[:, 2:4] = view.obstacle[:obstacles, :2]
        obstacle[:, 4:] = view.obstacle[:obstacles, 2:]
        self._buffer.write(self._staging[:count])
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        self._ctx.disable(moderngl.BLEND)

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._program)
