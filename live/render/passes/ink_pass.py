"""Render pass for ink lines at silhouettes, occlusion edges and creases of dancers, over the picture or on paper."""

from typing import Final

import moderngl

from live.base.arrays import Float64
from live.base.picture_parameters import BY_ADDRESS
from live.render.camera import FAR, NEAR
from live.render.pass_context import Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader

_ROOT: Final = "/dance/pass/ink"
_AMOUNT: Final = BY_ADDRESS[_ROOT].first
_WIDTH: Final = BY_ADDRESS[f"{_ROOT}/width"].first
_PAPER: Final = BY_ADDRESS[f"{_ROOT}/paper"].first
_COLOUR: Final = BY_ADDRESS[f"{_ROOT}/colour"].row_slice
_PAPER_COLOUR: Final = BY_ADDRESS[f"{_ROOT}/paper/colour"].row_slice
_REFERENCE_HEIGHT: Final = 720.0
"""Line widths are in pixels at this picture height; they scale with the height."""


class InkPass:
    """Draws lines where dancer, depth or normal differ between neighbouring pixels."""

    needs_surfaces = True

    def __init__(self, making: PassSetup) -> None:
        self._full = FullscreenShader(making.ctx, "ink_fragment.glsl", (("NEAR", NEAR), ("FAR", FAR)))

    @staticmethod
    def reach(height: float, row: Float64) -> float:
        """Return how far from a pixel it looks, with these parameters, in a picture of this height [pixels]."""
        return BY_ADDRESS[f"{_ROOT}/width"].high * height / _REFERENCE_HEIGHT + 1.0

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        return moment.parameter(_AMOUNT) > 0.0

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with lines of ink."""
        assert surfaces is not None
        full, row = self._full, moment.uniforms.row
        full.set("amount", moment.parameter(_AMOUNT))
        full.set("width", max(moment.parameter(_WIDTH) * moment.uniforms.height / _REFERENCE_HEIGHT, 0.6))
        full.set("paper", moment.parameter(_PAPER))
        full.set("ink", tuple(row[_COLOUR].tolist()))
        full.set("paper_colour", tuple(row[_PAPER_COLOUR].tolist()))
        full.draw(target, light=source, depth=surfaces.depth, shape=surfaces.shape, who=surfaces.identity)

    def resize(self, size: tuple[int, int]) -> None:
        """Nothing here has a size."""

    def release(self) -> None:
        """Free the program."""
        self._full.release()
