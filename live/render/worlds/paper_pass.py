"""Picture pass of paper: washes of watercolour, hatching in the shade, lines of ink, the grain of the sheet."""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.render.camera import FAR, NEAR
from live.render.pass_context import Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader, release_all
from live.render.worlds.world_textures import NOISE_SIZE

_MARGIN: Final = 0.012
"""How far lines reach beyond the dancers [heights of the picture]."""
_REACH: Final = 12.0 / 720.0
"""How far strokes lie off what they draw: the hand's unrest, a wash's border, a line [heights of the picture]."""
_PERIODS: Final = 460.0, 620.0
"""Pixels after which the noise repeats, at the usual height: that of the sheet, and that of the hand."""
_REFERENCE_HEIGHT: Final = 720.0
_STROKES_PER_BEAT: Final = 2.0
"""How often lines are drawn anew: those of a drawing on film are never quite the same."""


class PaperPass:
    """Turns the picture into a drawing by the share of the world; first of all picture passes."""

    needs_surfaces = True

    def __init__(self, making: PassSetup) -> None:
        taps = 4 if making.quality.samples == 0 else 8
        constants = ("NEAR", NEAR), ("FAR", FAR), ("TAPS", taps)
        self._programs = [
            FullscreenShader(making.ctx, "sheet_fragment.glsl", (*constants, ("BODIES", bodies))) for bodies in (0, 1)
        ]
        self._levels, self._height = (0.0, 0.0), 0.0

    @staticmethod
    def reach(height: float, row: Float64) -> float:
        """Return how far from a pixel it looks, with these parameters, in a picture of this height [pixels]."""
        return _REACH * height

    def active(self, moment: Moment) -> bool:
        """Whether paper is seen."""
        return moment.uniforms.worlds["paper"] > 0.0

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` as a drawing."""
        assert surfaces is not None
        self._set_height(moment.uniforms.height)
        drawn = float(np.floor(moment.view.beat * _STROKES_PER_BEAT) % 64.0)
        x, y, width, height = moment.rectangle
        whole = (0, 0, *source.size)
        border = round(_MARGIN * moment.uniforms.height)
        left, low = max(x - border, 0), max(y - border, 0)
        part = left, low, min(x + width + border, source.width) - left, min(y + height + border, source.height) - low
        if not width or not height:
            part = 0, 0, 0, 0
        for program, regions in zip(self._programs, (_around(part, source.size), (part,)), strict=True):
            program.set("levels", self._levels)
            program.set("fading", int(moment.uniforms.worlds["paper"] < 1.0))
            program.set("stroke", (0.618034 * drawn % 1.0, 0.754878 * drawn % 1.0))
            for where in regions:
                if where[2] > 0 and where[3] > 0:
                    target.scissor = where
                    program.draw(
                        target, light=source, depth=surfaces.depth, shape=surfaces.shape, who=surfaces.identity
                    )
        target.scissor = whole

    def _set_height(self, height: float) -> None:
        """Choose the copies of the noise for a whole picture of this height [pixels]."""
        if height != self._height:
            texels = np.array(_PERIODS) * height / _REFERENCE_HEIGHT / NOISE_SIZE  # pixels of the picture for each
            self._height, self._levels = height, tuple(np.maximum(-np.log2(texels), 0.0).tolist())

    def resize(self, size: tuple[int, int]) -> None:
        """Nothing here has a size."""

    def release(self) -> None:
        """Free the program."""
        release_all(*self._programs)


def _around(part: tuple[int, int, int, int], size: tuple[int, int]) -> tuple[tuple[int, int, int, int], ...]:
    """Return the rectangles (x, y, width, height) of a picture that a part of it leaves; some may be empty."""
    x, y, width, height = part
    right, top = x + width, y + height
    return (0, 0, size[0], y), (0, top, size[0], size[1] - top), (0, y, x, height), (right, y, size[0] - right, height)
