"""Picture pass of paper: washes of watercolour, hatching in the shade, lines of ink, the grain of the sheet."""

from typing import Final

import moderngl
import numpy as np

from live.render.camera import FAR, NEAR
from live.render.pass_context import Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader, release_all

_MARGIN: Final = 0.012
"""How far lines reach beyond the dancers [heights of the picture]."""
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

    def active(self, moment: Moment) -> bool:
        """Whether paper is seen."""
        return moment.uniforms.worlds["paper"] > 0.0

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` as a drawing."""
        assert surfaces is not None
        drawn = float(np.floor(moment.view.beat * _STROKES_PER_BEAT) % 64.0)
        x, y, width, height = moment.rectangle
        whole = (0, 0, *source.size)
        border = round(_MARGIN * source.height)
        left, low = max(x - border, 0), max(y - border, 0)
        part = left, low, min(x + width + border, source.width) - left, min(y + height + border, source.height) - low
        parts = (whole,) if not width or not height else (whole, part)
        for program, where in zip(self._programs, parts, strict=False):
            if len(parts) > 1 and program is self._programs[0] and part == whole:
                continue
            target.scissor = where
            program.set("stroke", (0.618034 * drawn % 1.0, 0.754878 * drawn % 1.0))
            program.draw(target, light=source, depth=surfaces.depth, shape=surfaces.shape, who=surfaces.identity)
        target.scissor = whole

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]: nothing depends on it."""

    def release(self) -> None:
        """Free the program."""
        release_all(*self._programs)
