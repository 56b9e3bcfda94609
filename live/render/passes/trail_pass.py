"""Render passes for trails (frame feedback that fades in beats) and for ribbons of hands and feet."""

import math
from typing import Any, Final

import moderngl
import numpy as np

from live.base.arrays import Float32, Float64
from live.base.picture_parameters import BY_ADDRESS
from live.base.stage_snapshot import StageView
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.motion_trails import LIMBS, LimbHistory
from live.render.pass_context import HDR, NO_MEMORY, Memory, Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader, compile_program, release_all, set_uniform

_ROOT: Final = "/dance/pass/trails"
_AMOUNT: Final = BY_ADDRESS[_ROOT].first
_BEATS: Final = BY_ADDRESS[f"{_ROOT}/beats"].first
_ZOOM: Final = BY_ADDRESS[f"{_ROOT}/zoom"].first
_COLOUR: Final = BY_ADDRESS[f"{_ROOT}/colour"].row_slice


_INITIAL_BRIGHTNESS: Final = 0.55
"""Initial brightness of a trail: below the dancer's, so that the dancer stands out."""


class TrailsPass:
    """Feedback of the previous frame; independent of the frame rate. A smaller amount shortens the trails."""

    needs_surfaces = False

    def __init__(self, making: PassSetup) -> None:
        self._ctx = making.ctx
        self._full, self._feedback = (
            FullscreenShader(making.ctx, "trails_fragment.glsl", (("SHOWN", shown),)) for shown in (1, 0)
        )
        self._has_last = False
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        self._textures = [self._ctx.texture(size, 4, dtype=HDR) for _ in range(2)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]
        self._index = 0
        self._has_last = False

    @staticmethod
    def memory(row: Float64) -> Memory:
        """Return what trails keep of earlier pictures in one with these parameters."""
        amount = float(row[_AMOUNT])
        return Memory(half_life=_half_life(float(row[_BEATS]), amount)) if amount > 0.0 else NO_MEMORY

    @staticmethod
    def reach(height: float, row: Float64) -> float:
        """Return how far from a pixel it looks, with these parameters [pixels]: trails that grow come from far away."""
        return math.inf if row[_ZOOM] and row[_AMOUNT] > 0.0 else 0.0

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        here = moment.parameter(_AMOUNT) > 0.0
        if not here:
            self._has_last = False  # the stored frame is outdated when trails are switched on again
        return here

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` and the faded previous frame."""
        half = _half_life(moment.parameter(_BEATS), moment.parameter(_AMOUNT))
        there = self._has_last and not moment.cut
        # the colour parameter is the colour of faded white after one half-life
        tint = [min(max(value, 1e-3), 1.0) ** (moment.beats / half) for value in moment.uniforms.row[_COLOUR].tolist()]
        last, turn = self._textures[self._index], 1 - self._index
        for full, into, strength in (
            (self._feedback, self._targets[turn], 1.0),
            (self._full, target, _INITIAL_BRIGHTNESS),
        ):
            full.set("left", strength * 0.5 ** (moment.beats / half) if there else 0.0)
            full.set("shrink", 2.0 ** (-moment.parameter(_ZOOM) * moment.beats))
            full.set("tint", tuple(tint))
            full.draw(into, light=source, last=last)
        self._index, self._has_last = turn, True

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]; the trails are cleared."""
        release_all(*self._targets, *self._textures)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._full, self._feedback)


def _half_life(beats: float, amount: float) -> float:
    """Return after how many beats a trail is half as bright."""
    return max(beats * amount, 1e-3)


_LIMBS_UNIT: Final = 2


class RibbonPass:
    """Draws ribbons over the bound target, which must not write depth; call `record` each frame while there are any."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._program = compile_program(ctx, "ribbon_vertex.glsl", "ribbon_fragment.glsl", (("SOFT", 0),))
        self._pieces = making.quality.ribbon_pieces
        self._strip = ctx.buffer(_build_strip(self._pieces).tobytes())
        self.history = LimbHistory(ctx, max(making.scene.dancer_count, 1))

    def record(self, crowd: DancerBatch, view: StageView) -> None:
        """Record the places of hands and feet in this frame."""
        self.history.update(view, crowd.capacity)

    def draw(self, crowd: DancerBatch) -> None:
        """Draw all ribbons, as long as the quality level allows."""
        pieces = min(crowd.quality.ribbon_pieces, self._pieces)
        set_uniform(self._program, "drawn_back", float(_length_share(pieces / self._pieces)))
        history = self.history
        set_uniform(self._program, "ring", history.ring)
        set_uniform(self._program, "known", history.valid_count)
        set_uniform(self._program, "limbs_layout", (history.columns, history.blocks))
        set_uniform(self._program, "limbs", _LIMBS_UNIT)
        history.texture.use(_LIMBS_UNIT)
        vertices = pieces * LIMBS * len(_CORNERS)
        crowd.draw_geometry(self._program, "ribbons", self._vertices, moderngl.TRIANGLES, vertices)

    def _vertices(self, body: str) -> tuple[Any, ...]:
        return self._strip, "4f", "in_strip"

    def release(self) -> None:
        """Free everything."""
        release_all(self._strip, self._program, self.history)


_CORNERS: Final = ((0, -1.0), (1, -1.0), (1, 1.0), (0, -1.0), (1, 1.0), (0, 1.0))


def _length_share(share: Any) -> Any:
    """Map a share of a ribbon's pieces to a share of its length: pieces are finer at the new end."""
    return share**1.25


def _build_strip(pieces: int) -> Float32:
    """Return two triangles for each piece of each limb's ribbon, the newest first: age (0 to 1), side, limb."""
    back = _length_share(np.arange(pieces + 1) / pieces)
    rows = [
        (back[piece + which], side, limb, 0.0)
        for piece in range(pieces)
        for limb in range(LIMBS)
        for which, side in _CORNERS
    ]
    return np.array(rows, np.float32)
