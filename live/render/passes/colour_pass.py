"""Render passes for colour: colour grade, vignette, and the final conversion for display."""

from typing import Final

import moderngl
import numpy as np

from live.base.picture_parameters import BY_ADDRESS, VIGNETTE
from live.render.pass_context import Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader, compile_program, release_all, set_uniform
from live.render.uniforms import VIGNETTE_STRENGTH


class FinalPass:
    """Converts compressed light for display: bloom, tone mapping, vignette, sRGB, dither, 8 bits."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._programs = [
            compile_program(ctx, "full_vertex.glsl", "finish_fragment.glsl", (("GLOW", glow),)) for glow in (0, 1)
        ]
        self._triangles = [ctx.vertex_array(linked, []) for linked in self._programs]

    def draw(
        self,
        source: moderngl.Texture,
        target: moderngl.Framebuffer,
        glow: moderngl.Texture | None = None,
        strength: float = 0.0,
    ) -> None:
        """Draw `source` onto `target`, plus `strength` times the `glow` if there is one."""
        linked = self._programs[glow is not None]
        target.use()
        source.use(1)
        set_uniform(linked, "light", 1)
        if glow is not None:
            glow.use(2)
            set_uniform(linked, "glow", 2)
            set_uniform(linked, "strength", strength)
        self._triangles[glow is not None].render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._triangles, *self._programs)


_ROOT: Final = "/dance/pass/grade"
_AMOUNT: Final = BY_ADDRESS[_ROOT].first
_COLOURS: Final = {name: BY_ADDRESS[f"{_ROOT}/{name}"] for name in ("lift", "gamma", "gain")}
_NUMBERS: Final = {name: BY_ADDRESS[f"{_ROOT}/{name}"] for name in ("contrast", "temperature")}
_ROWS: Final = np.concatenate([np.arange(p.first, p.first + p.size) for p in (*_COLOURS.values(), *_NUMBERS.values())])
_NEUTRAL: Final = np.concatenate([p.start for p in (*_COLOURS.values(), *_NUMBERS.values())])


class GradePass:
    """Colour grade: lift, gamma and gain of each colour, contrast and temperature. Neutral values cost nothing."""

    needs_surfaces = False

    def __init__(self, making: PassSetup) -> None:
        self._full = FullscreenShader(making.ctx, "grade_fragment.glsl")

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0 and any value is not neutral."""
        return moment.parameter(_AMOUNT) > 0.0 and not np.array_equal(moment.uniforms.row[_ROWS], _NEUTRAL)

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with the grade."""
        full, row = self._full, moment.uniforms.row
        full.set("amount", moment.parameter(_AMOUNT))
        for name, known in _COLOURS.items():
            full.set(name, tuple(row[known.row_slice].tolist()))
        for name, known in _NUMBERS.items():
            full.set(name, float(row[known.first]))
        full.draw(target, light=source)

    def resize(self, size: tuple[int, int]) -> None:
        """Nothing here has a size."""

    def release(self) -> None:
        """Free the program."""
        self._full.release()


class VignettePass:
    """Darkens the corners. Used if other passes follow; as the last pass the vignette is part of `FinalPass`."""

    needs_surfaces = False

    def __init__(self, making: PassSetup) -> None:
        self._full = FullscreenShader(making.ctx, "vignette_fragment.glsl")

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        return moment.parameter(VIGNETTE) > 0.0

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with darker corners."""
        self._full.set("strength", VIGNETTE_STRENGTH * moment.parameter(VIGNETTE))
        self._full.draw(target, light=source)

    def resize(self, size: tuple[int, int]) -> None:
        """Nothing here has a size."""

    def release(self) -> None:
        """Free the program."""
        self._full.release()
