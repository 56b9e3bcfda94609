"""Darker corners, where the vignette is not the last of the passes: otherwise the film curve takes it along."""

import moderngl

from live.base.picture import VIGNETTE
from live.render.full import Full
from live.render.pass_context import Making, Moment, Surfaces
from live.render.uniforms import VIGNETTING


class VignettePass:
    """Takes light from the corners."""

    needs_surfaces = False

    def __init__(self, making: Making) -> None:
        self._full = Full(making.ctx, "vignette_fragment.glsl")

    def active(self, moment: Moment) -> bool:
        """While its amount is not 0."""
        return moment.amount(VIGNETTE) > 0.0

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with darker corners."""
        self._full.set("strength", VIGNETTING * moment.amount(VIGNETTE))
        self._full.draw(target, light=source)

    def resize(self, size: tuple[int, int]) -> None:
        """Nothing here has a size."""

    def release(self) -> None:
        """Free the program."""
        self._full.release()
