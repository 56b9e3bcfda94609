"""Picture pass of paper: washes of watercolour, hatching in the shade, lines of ink, the grain of the sheet."""

from typing import Final

import moderngl
import numpy as np

from live.render.camera import FAR, NEAR
from live.render.pass_context import Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader

_STROKES_PER_BEAT: Final = 2.0
"""How often lines are drawn anew: those of a drawing on film are never quite the same."""


class PaperPass:
    """Turns the picture into a drawing by the share of the world; first of all picture passes."""

    needs_surfaces = True

    def __init__(self, making: PassSetup) -> None:
        self._full = FullscreenShader(making.ctx, "sheet_fragment.glsl", (("NEAR", NEAR), ("FAR", FAR)))

    def active(self, moment: Moment) -> bool:
        """Whether paper is seen."""
        return moment.uniforms.worlds["paper"] > 0.0

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` as a drawing."""
        assert surfaces is not None
        drawn = float(np.floor(moment.view.beat * _STROKES_PER_BEAT) % 64.0)
        self._full.set("stroke", (0.618034 * drawn % 1.0, 0.754878 * drawn % 1.0))
        self._full.draw(target, light=source, depth=surfaces.depth, shape=surfaces.shape, who=surfaces.identity)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]: nothing depends on it."""

    def release(self) -> None:
        """Free the program."""
        self._full.release()
