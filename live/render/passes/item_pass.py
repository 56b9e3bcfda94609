"""Items of the set: boxes, cylinders, steps; lit like dancers, hiding them, with shadows on the floor."""

import moderngl
import numpy as np

from live.base.set_geometry import Item, triangles_of
from live.render.gl_release import release_all
from live.render.pass_context import Making, Moment, ScenePass
from live.render.shader import program, set_uniform

NEAR_FLOOR = 0.5
"""So high [m] above the floor, light from everywhere is dimmer at its foot."""


class ItemPass(ScenePass):
    """Draws the items of a scene; without any it does nothing."""

    def __init__(self, making: Making) -> None:
        ctx = self._ctx = making.ctx
        data = vertices_of(making.scene.items)
        self._count = len(data)
        if not self._count:
            return
        self._buffer = ctx.buffer(data.tobytes())
        self._surface = program(ctx, "item_vertex.glsl", "item_surface_fragment.glsl")
        self._lit = program(ctx, "item_vertex.glsl", "item_fragment.glsl")
        self._cast = program(ctx, "item_shadow_vertex.glsl", "shadow_fragment.glsl", (("SOFT", 0), ("STYLED", 0)))
        names = ("in_position", "in_normal", "in_colour")
        self._arrays = [
            ctx.vertex_array(linked, [(self._buffer, "3f 3f 4f", *names)]) for linked in (self._surface, self._lit)
        ]
        self._shadow = ctx.vertex_array(self._cast, [(self._buffer, "3f 28x", "in_position")])

    def active(self, moment: Moment) -> bool:
        """While there is any."""
        return self._count > 0

    def cast(self) -> None:
        """Draw the items' shadows into the floor's layers, which are bound."""
        if self._count:
            self._shadow.render(moderngl.TRIANGLES, vertices=self._count)

    def surfaces(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._arrays[0].render(moderngl.TRIANGLES, vertices=self._count)

    def lit(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        moment.floor.use(1)
        set_uniform(self._lit, "floor_map", 1)
        self._arrays[1].render(moderngl.TRIANGLES, vertices=self._count)

    def release(self) -> None:
        """Free everything."""
        if self._count:
            release_all(*self._arrays, self._shadow, self._buffer, self._surface, self._lit, self._cast)


def vertices_of(items: tuple[Item, ...]) -> "np.ndarray[tuple[int, int], np.dtype[np.float32]]":
    """Place, normal, square root of the colour and openness of all corners, shape (V, 10)."""
    rows = [np.zeros((0, 10), np.float32)]
    for item in items:
        corners, normals = (part.reshape(-1, 3) for part in triangles_of(item))
        colour = np.tile(np.sqrt(item.colour), (len(corners), 1))
        openness = np.clip(0.55 + 0.45 * corners[:, 1:2] / NEAR_FLOOR, 0.0, 1.0)
        rows.append(np.concatenate([corners, normals, colour, openness], axis=1).astype(np.float32))
    return np.ascontiguousarray(np.concatenate(rows))
