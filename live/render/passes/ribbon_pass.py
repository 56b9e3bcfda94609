"""Ribbons that hands and feet draw through the last beats."""

from typing import Any, Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_view import StageView
from live.render.crowd import Crowd
from live.render.limb_history import LIMBS, LimbHistory
from live.render.moment import Making
from live.render.release import release_all
from live.render.shader import program, set_uniform

Float32 = npt.NDArray[np.float32]

_LIMBS_UNIT: Final = 2


class RibbonPass:
    """Draws over the bound target, which must not write depth; `follow` once a picture while there are ribbons."""

    def __init__(self, making: Making) -> None:
        ctx = self._ctx = making.ctx
        self._program = program(ctx, "ribbon_vertex.glsl", "ribbon_fragment.glsl", (("SOFT", 0),))
        self._strip = ctx.buffer(_strip(making.quality.ribbon_pieces).tobytes())
        self.history = LimbHistory(ctx, max(making.scene.dancer_count, 1))

    def follow(self, crowd: Crowd, view: StageView) -> None:
        """Take where limbs are in this picture."""
        self.history.update(view, crowd.capacity)

    def draw(self, crowd: Crowd) -> None:
        """Draw the ribbons of all dancers who have any."""
        history = self.history
        set_uniform(self._program, "ring", history.ring)
        set_uniform(self._program, "known", history.valid)
        set_uniform(self._program, "limbs_layout", (history.columns, history.blocks))
        set_uniform(self._program, "limbs", _LIMBS_UNIT)
        history.texture.use(_LIMBS_UNIT)
        crowd.draw_other(self._program, "ribbons", self._vertices, moderngl.TRIANGLES)

    def _vertices(self, body: str) -> tuple[Any, ...]:
        return self._strip, "4f", "in_strip"

    def release(self) -> None:
        """Free everything."""
        release_all(self._strip, self._program, self.history)


def _strip(pieces: int) -> Float32:
    """Two triangles for each piece of each limb's ribbon: how far back (0 to 1), side, limb."""
    back = (np.arange(pieces + 1) / pieces) ** 1.25  # finer where it is fresh
    corners = ((0, -1.0), (1, -1.0), (1, 1.0), (0, -1.0), (1, 1.0), (0, 1.0))
    rows = [
        (back[piece + which], side, limb, 0.0)
        for limb in range(LIMBS)
        for piece in range(pieces)
        for which, side in corners
    ]
    return np.array(rows, np.float32)
