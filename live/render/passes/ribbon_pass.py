"""Ribbons that hands and feet draw through the last beats."""

from typing import Any, Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import StageView
from live.render.dancers.dancer_batch import Crowd
from live.render.dancers.limb_history import LIMBS, LimbHistory
from live.render.gl_release import release_all
from live.render.pass_context import Making
from live.render.shader import program, set_uniform

Float32 = npt.NDArray[np.float32]

_LIMBS_UNIT: Final = 2


class RibbonPass:
    """Draws over the bound target, which must not write depth; `follow` once a picture while there are ribbons."""

    def __init__(self, making: Making) -> None:
        ctx = self._ctx = making.ctx
        self._program = program(ctx, "ribbon_vertex.glsl", "ribbon_fragment.glsl", (("SOFT", 0),))
        self._pieces = making.quality.ribbon_pieces
        self._strip = ctx.buffer(_strip(self._pieces).tobytes())
        self.history = LimbHistory(ctx, max(making.scene.dancer_count, 1))

    def follow(self, crowd: Crowd, view: StageView) -> None:
        """Take where limbs are in this picture."""
        self.history.update(view, crowd.capacity)

    def draw(self, crowd: Crowd) -> None:
        """Draw the ribbons of all dancers who have any, as far back as quality allows."""
        pieces = min(crowd.quality.ribbon_pieces, self._pieces)
        set_uniform(self._program, "drawn_back", float(_back(pieces / self._pieces)))
        history = self.history
        set_uniform(self._program, "ring", history.ring)
        set_uniform(self._program, "known", history.valid)
        set_uniform(self._program, "limbs_layout", (history.columns, history.blocks))
        set_uniform(self._program, "limbs", _LIMBS_UNIT)
        history.texture.use(_LIMBS_UNIT)
        vertices = pieces * LIMBS * len(_CORNERS)
        crowd.draw_other(self._program, "ribbons", self._vertices, moderngl.TRIANGLES, vertices)

    def _vertices(self, body: str) -> tuple[Any, ...]:
        return self._strip, "4f", "in_strip"

    def release(self) -> None:
        """Free everything."""
        release_all(self._strip, self._program, self.history)


_CORNERS: Final = ((0, -1.0), (1, -1.0), (1, 1.0), (0, -1.0), (1, 1.0), (0, 1.0))


def _back(share: Any) -> Any:
    """How far back of its length a ribbon is after a share of its pieces: they are finer where it is fresh."""
    return share**1.25


def _strip(pieces: int) -> Float32:
    """Two triangles for each piece of each limb's ribbon, the freshest first: how far back (0 to 1), side, limb."""
    back = _back(np.arange(pieces + 1) / pieces)
    rows = [
        (back[piece + which], side, limb, 0.0)
        for piece in range(pieces)
        for limb in range(LIMBS)
        for which, side in _CORNERS
    ]
    return np.array(rows, np.float32)
