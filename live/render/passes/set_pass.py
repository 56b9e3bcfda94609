"""Render passes for the set: obstacles and walls on the floor map, and solid props.

On the floor map, obstacles and walls are dark shapes with a rim of light, and real dancers are soft rings. Props
(boxes, cylinders, steps) are lit like dancers, occlude them and cast shadows.
"""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32
from live.base.set_geometry import SetItem, item_triangles
from live.base.stage_snapshot import SET_CAPACITY, StageView
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform

_WALL_THICKNESS: Final = 0.05
"""Half the drawn thickness of a wall [m]."""


class SetPass:
    """Draws the set over the bound floor map, whose texels are `texel` [m] wide."""

    def __init__(self, ctx: moderngl.Context, texel: float) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "set_vertex.glsl", "set_fragment.glsl")
        self.set_texel(texel)
        self._staging = np.zeros((2 * SET_CAPACITY, 6), np.float32)
        self._buffer = ctx.buffer(reserve=self._staging.nbytes, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f 2f/i", "in_ends", "in_form")])

    def set_texel(self, texel: float) -> None:
        """Set the width of the map's texels [m]."""
        set_uniform(self._program, "texel", texel)

    def draw(self, view: StageView) -> None:
        """Draw the present obstacles and walls; costs nothing if there are none."""
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


AMBIENT_HEIGHT = 0.5
"""Height [m] below which ambient light is reduced."""
_ITEM_BYTES: Final = 65_536
"""Length of the buffer of props at first; it grows."""


class ItemPass(ScenePass):
    """Draws the props of a scene; does nothing without any."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._buffer = ctx.buffer(reserve=_ITEM_BYTES, dynamic=True)
        self._surface = compile_program(ctx, "item_vertex.glsl", "item_surface_fragment.glsl")
        self._lit = compile_program(ctx, "item_vertex.glsl", "item_fragment.glsl")
        self._cast = compile_program(
            ctx, "item_shadow_vertex.glsl", "shadow_fragment.glsl", (("SOFT", 0), ("STYLED", 0))
        )
        names = ("in_position", "in_normal", "in_colour")
        self._arrays = [
            ctx.vertex_array(linked, [(self._buffer, "3f 3f 4f", *names)]) for linked in (self._surface, self._lit)
        ]
        self._shadow = ctx.vertex_array(self._cast, [(self._buffer, "3f 28x", "in_position")])
        self.set_items(making.scene.items)

    def set_items(self, items: tuple[SetItem, ...]) -> None:
        """Draw these props from now on."""
        data = build_vertices(items)
        self._count = len(data)
        self.box = np.array([data[:, :3].min(axis=0), data[:, :3].max(axis=0)], np.float64) if len(data) else None
        if data.nbytes > self._buffer.size:
            self._buffer.orphan(data.nbytes)
        if len(data):
            self._buffer.write(data)

    def active(self, moment: Moment) -> bool:
        """Whether there are props."""
        return self._count > 0

    def draw_shadows(self) -> None:
        """Draw the shadows of the props into the bound layers of the floor map."""
        if self._count:
            self._shadow.render(moderngl.TRIANGLES, vertices=self._count)

    def draw_surfaces(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._arrays[0].render(moderngl.TRIANGLES, vertices=self._count)

    def draw_lit(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        moment.floor.use(1)
        set_uniform(self._lit, "floor_map", 1)
        self._arrays[1].render(moderngl.TRIANGLES, vertices=self._count)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._arrays, self._shadow, self._buffer, self._surface, self._lit, self._cast)


def build_vertices(items: tuple[SetItem, ...]) -> Float32:
    """Return position, normal, square root of the colour and ambient openness of all vertices, shape (V, 10)."""
    return np.ascontiguousarray(np.concatenate([np.zeros((0, 10), np.float32), *map(_item_vertices, items)]))


def _item_vertices(item: SetItem) -> Float32:
    corners, normals = (part.reshape(-1, 3) for part in item_triangles(item))
    colour = np.tile(np.sqrt(item.colour), (len(corners), 1))
    openness = np.clip(0.55 + 0.45 * corners[:, 1:2] / AMBIENT_HEIGHT, 0.0, 1.0)
    return np.concatenate([corners, normals, colour, openness], axis=1).astype(np.float32)
