"""Render pass for the plan view, as in the thesis (T022).

Dancers are circles with a triangle for their facing, with fading paths behind them. The plan lies on the floor over the
whole picture, for any camera; it includes the light of elements on the floor.
"""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.base.picture_parameters import PLAN
from live.base.stage_snapshot import StageView
from live.render.pass_context import NO_MEMORY, Memory, Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform

HISTORY: Final = 64
"""Stored places of each dancer."""
PER_BEAT: Final = 8.0
"""Stored places per beat: with `KEPT`, the paths of the last two measures."""
MAX_SEGMENTS: Final = 60_000
"""Maximum number of path segments; paths are shorter for very many dancers."""
NOWHERE: Final = 1e9
_ABSENT: Final = np.array([NOWHERE, NOWHERE], np.float32)


class PlanPass(ScenePass):
    """Draws the plan view. Costs nothing while it is off; paths are recorded from when it is switched on."""

    def __init__(self, making: PassSetup) -> None:
        self._ctx = ctx = making.ctx
        self._count = count = max(making.scene.dancer_count, 1)
        self._ground = compile_program(ctx, "full_vertex.glsl", "plan_ground_fragment.glsl")
        self._path_program = compile_program(ctx, "plan_way_vertex.glsl", "plan_way_fragment.glsl")
        self._marks = compile_program(ctx, "plan_mark_vertex.glsl", "plan_mark_fragment.glsl")
        self._triangle = ctx.vertex_array(self._ground, [])
        self._strip = ctx.vertex_array(self._path_program, [])
        self._allocate(count)
        self._last_sample, self._sample_count, self._newest_row = -1, 0, 0

    def _allocate(self, count: int) -> None:
        """Allocate buffers for `count` dancers."""
        self._count, self._history = count, max(2, min(HISTORY, MAX_SEGMENTS // count))
        self._places = self._ctx.texture((count, self._history), 2, dtype="f4")
        self._places.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._mark = np.zeros((count, 8), np.float32)
        self._row = np.zeros((count, 2), np.float32)
        self._buffer = self._ctx.buffer(reserve=self._mark.nbytes, dynamic=True)
        self._array = self._ctx.vertex_array(self._marks, [(self._buffer, "4f 4f/i", "in_place", "in_colour")])
        self._colours = self._ctx.texture((count, 1), 4, dtype="f4")
        self._colours.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._tint = np.ones((count, 4), np.float32)

    @staticmethod
    def memory(row: Float64) -> Memory:
        """Return how long the paths are in a picture with these parameters."""
        return Memory(beats=(HISTORY + 1) / PER_BEAT) if row[PLAN] > 0.0 else NO_MEMORY

    def active(self, moment: Moment) -> bool:
        """Whether the plan is on."""
        return moment.parameter(PLAN) > 0.0

    def light_active(self, moment: Moment) -> bool:
        """The same as `active`: called only then."""
        return True

    def prepare(self, moment: Moment) -> None:
        """Record the places of this frame."""
        view = moment.view
        if len(view.joint_position) > self._count:
            self._release_data()
            self._allocate(len(view.joint_position))
            self._sample_count = 0
        self._read_dancers(view, moment.uniforms.group_colours)
        eighth = int(np.floor(view.beat * PER_BEAT))
        if moment.cut or eighth < self._last_sample:
            self._sample_count = 0
        if eighth != self._last_sample or not self._sample_count:
            self._newest_row = (self._newest_row + 1) % self._history
            self._sample_count = min(self._sample_count + 1, self._history - 1)
            self._last_sample = eighth
        self._places.write(self._row, viewport=(0, self._newest_row, self._count, 1))

    follow = prepare

    def _read_dancers(self, view: StageView, colours: Float64) -> None:
        """Read place, facing and colour of all dancers."""
        count = len(view.joint_position)
        self._row[:] = NOWHERE
        self._row[:count] = view.joint_position[:, 0, [0, 2]]
        self._row[:count][~view.present] = _ABSENT
        w, x, y, z = view.joint_rotation[:, 0].T
        self._mark[:, :2] = self._row
        self._mark[:count, 2] = 2.0 * (x * z + w * y)
        self._mark[:count, 3] = 1.0 - 2.0 * (x * x + y * y)
        self._tint[:count, :3] = colours[view.group]
        self._mark[:, 4:] = self._tint

    def draw_light(self, moment: Moment) -> None:
        """Draw ground, paths, dancers."""
        ctx, amount = self._ctx, moment.parameter(PLAN)
        ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        ctx.enable(moderngl.BLEND)
        ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        for linked in (self._ground, self._path_program, self._marks):
            set_uniform(linked, "amount", amount)
        moment.floor.use(1)
        set_uniform(self._ground, "floor_map", 1)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._colours.write(self._tint)
        self._places.use(1)
        self._colours.use(2)
        for name, value in (("places", 1), ("colours", 2), ("newest", self._newest_row), ("count", self._count)):
            set_uniform(self._path_program, name, value)
        set_uniform(self._path_program, "kept", self._history)
        if self._sample_count > 1:
            self._strip.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=(self._sample_count - 1) * self._count)
        self._buffer.write(self._mark)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._count)
        ctx.disable(moderngl.BLEND)

    def _release_data(self) -> None:
        release_all(self._array, self._buffer, self._places, self._colours)

    def release(self) -> None:
        """Free everything."""
        self._release_data()
        release_all(self._triangle, self._strip, self._ground, self._path_program, self._marks)
