"""Render pass for elements as light on the floor: pools around points, lines and regions, streams, dashes (T105-T110).

One instance per element draws pools and regions (each program skips the other's); one instance per line segment draws
patterns along lines. Elements without a place (wander, flock, follow, pursue, evade) give no light.
"""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    DRAWN,
    FLOW,
    PARTICIPANT,
    PATH,
    PHONE_LIGHT,
    RADIAL,
    REPULSOR,
    SPREADER,
    UNIFORM,
    VORTEX,
)
from live.base.stage_snapshot import ELEMENT_CAPACITY, ELEMENT_CORNERS, LIGHT_CAPACITY, StageView
from live.render.shader import CORNERS_BINDING, compile_program, release_all, set_uniform

_KINDS: Final = (
    ("ATTRACTOR", ATTRACTOR),
    ("REPULSOR", REPULSOR),
    ("SPREADER", SPREADER),
    ("CROSSING", CROSSING),
    ("FLOW", FLOW),
    ("PATH", PATH),
    ("VOICE", PARTICIPANT),
    ("PHONE", PHONE_LIGHT),
    ("UNIFORM", UNIFORM),
    ("RADIAL", RADIAL),
    ("VORTEX", VORTEX),
    ("DRAWN", DRAWN),
    ("CORNERS", ELEMENT_CORNERS),
)
_BEAT_PERIOD: Final = 64.0
"""Period [beats] of all motion along floor lines: small numbers keep float32 exact."""
_COLUMNS: Final = 8
_PIECE_COLUMNS: Final = 12


class ElementPass:
    """Adds the elements' light to the bound floor map, whose texels are `texel` [m] wide."""

    def __init__(self, ctx: moderngl.Context, texel: float) -> None:
        self._ctx = ctx
        self._pools = compile_program(ctx, "element_vertex.glsl", "element_fragment.glsl", _KINDS)
        self._regions = compile_program(ctx, "element_region_vertex.glsl", "element_region_fragment.glsl", _KINDS)
        self._lines = compile_program(ctx, "element_line_vertex.glsl", "element_line_fragment.glsl", _KINDS)
        self.set_texel(texel)
        self._staging = np.zeros((ELEMENT_CAPACITY + LIGHT_CAPACITY, _COLUMNS), np.float32)
        self._pieces = np.zeros((ELEMENT_CORNERS, _PIECE_COLUMNS), np.float32)
        self._corners = np.zeros((ELEMENT_CORNERS, 4), np.float32)
        self._element_buffer = ctx.buffer(reserve=self._staging.nbytes, dynamic=True)
        self._piece_buffer = ctx.buffer(reserve=self._pieces.nbytes, dynamic=True)
        self._corner_buffer = ctx.buffer(reserve=self._corners.nbytes, dynamic=True)
        inputs = [(self._element_buffer, "4f 4f/i", "in_element", "in_form")]
        self._pool_array = ctx.vertex_array(self._pools, inputs)
        self._region_array = ctx.vertex_array(self._regions, inputs)
        self._line_array = ctx.vertex_array(
            self._lines, [(self._piece_buffer, "4f 4f 4f/i", "in_piece", "in_element", "in_form")]
        )

    def set_texel(self, texel: float) -> None:
        """Set the width of the map's texels [m]."""
        for linked in (self._pools, self._regions, self._lines):
            set_uniform(linked, "texel", texel)

    def draw(self, view: StageView) -> None:
        """Draw the elements of this frame; costs nothing if there are none."""
        count = min(max(view.element_count, 0), ELEMENT_CAPACITY)
        lights = min(max(view.light_count, 0), LIGHT_CAPACITY)
        if not count and not lights:
            return
        beat = view.beat % _BEAT_PERIOD
        for linked in (self._pools, self._regions, self._lines):
            set_uniform(linked, "beat", beat)
        self._stage(view, count)
        self._stage_lights(view, count, lights)
        pieces = self._stage_pieces(view, count)
        ctx = self._ctx
        ctx.enable(moderngl.BLEND)
        if pieces:  # segments overlap where a line bends: use the brighter one
            self._piece_buffer.write(self._pieces[:pieces])
            ctx.blend_equation = moderngl.MAX, moderngl.MAX
            self._line_array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=pieces)
            ctx.blend_equation = moderngl.FUNC_ADD, moderngl.FUNC_ADD
        # screen blending: overlapping lights never exceed white
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_COLOR
        self._pool_array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count + lights)
        if self._has_regions(view, count):
            self._corner_buffer.bind_to_uniform_block(CORNERS_BINDING)
            self._region_array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        ctx.disable(moderngl.BLEND)

    def _stage(self, view: StageView, count: int) -> None:
        staging = self._staging[:count]
        staging[:, :2] = view.element_position[:count]
        staging[:, 2] = view.element_kind[:count]
        np.clip(view.element_level[:count], 0.0, 1.0, out=staging[:, 3])
        staging[:, 4] = view.element_radius[:count]
        staging[:, 5] = view.element_first[:count]
        staging[:, 6] = view.element_corners[:count]
        staging[:, 7] = np.where(view.element_strength[:count] < 0.0, -1.0, 1.0) * (1 + view.element_flow[:count])
        self._element_buffer.write(staging)

    def _stage_lights(self, view: StageView, first: int, count: int) -> None:
        """Stage the lights of the audience's phones, after the elements."""
        if not count:
            return
        staging = self._staging[first : first + count]
        staging[:] = 0.0
        staging[:, :2] = view.light[:count, :2]
        staging[:, 2] = PHONE_LIGHT
        staging[:, 3], staging[:, 5], staging[:, 7] = (
            view.light[:count, 3],
            view.light[:count, 2],
            view.light[:count, 4],
        )
        self._element_buffer.write(staging, offset=first * staging.strides[0])

    def _has_regions(self, view: StageView, count: int) -> bool:
        if not count:
            return False
        corners = view.element_corners[:count]
        used = min(int((view.element_first[:count] + corners).max()), ELEMENT_CORNERS)
        if used > 1 and (corners > 1).any():
            staged = self._corners[:used]
            staged[:, :2] = view.element_corner[:used]
            square = (np.diff(staged[:, :2], axis=0) ** 2).sum(1)
            staged[1:, 2] = np.cumsum(np.sqrt(square))
            staged[:-1, 3] = 1.0 / np.maximum(square, 1e-9)
            self._corner_buffer.write(staged)
            return True
        return bool((view.element_radius[:count] > 0.0).any())

    def _stage_pieces(self, view: StageView, count: int) -> int:
        """Fill `_pieces` with the segments of lines that have motion along them; return their number."""
        used = 0
        for index in np.flatnonzero(view.element_corners[:count] > 1):
            kind, flow = int(view.element_kind[index]), int(view.element_flow[index])
            if kind not in (CROSSING, PATH, FLOW) or (kind == FLOW and flow != UNIFORM):
                continue
            first, corners = int(view.element_first[index]), int(view.element_corners[index])
            line: npt.NDArray[np.float32] = view.element_corner[first : first + corners]
            if kind != PATH:  # the two points only give its direction
                line = line[:2]
            if len(line) < 2 or used + len(line) - 1 > len(self._pieces):
                continue
            pieces = self._pieces[used : used + len(line) - 1]
            pieces[:, :2], pieces[:, 2:4] = line[:-1], line[1:]
            pieces[:, 4], pieces[:, 5] = kind, self._staging[index, 3]
            pieces[:, 6], pieces[:, 7] = view.element_radius[index], self._staging[index, 7]
            lengths = np.hypot(pieces[:, 2] - pieces[:, 0], pieces[:, 3] - pieces[:, 1])
            along = np.cumsum(lengths)
            pieces[:, 8], pieces[:, 9] = along - lengths, along[-1]
            pieces[:, 10] = np.array_equal(line[0], line[-1])
            used += len(pieces)
        return used

    def release(self) -> None:
        """Free everything."""
        release_all(self._pool_array, self._region_array, self._line_array)
        release_all(self._element_buffer, self._piece_buffer, self._corner_buffer)
        release_all(self._pools, self._regions, self._lines)
