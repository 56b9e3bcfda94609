"""Render pass for garments that move by themselves: skirts, sleeves, ribbons and long hair, in both tiers and all
styles of bodies."""

import moderngl

from live.render.dancers.garment_meshes import GarmentMeshes
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform

_NEAR_AND_FAR = ("near", "far")


class GarmentPass(ScenePass):
    """Draws the garments of a view wherever their dancers' bodies are drawn; does nothing without any."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._multisampled = making.quality.samples > 0
        self._meshes = GarmentMeshes(ctx, fine=self._multisampled)
        self._has_styles = False
        fine = ("FINE", int(self._multisampled))

        def program(vertex: str, fragment: str, **constants: int) -> moderngl.Program:
            return compile_program(ctx, vertex, fragment, (("GARMENT", 1), fine, *constants.items()))

        self._surface = [
            program("garment_vertex.glsl", "gbuffer_fragment.glsl", SOFT=0, STYLED=0, WHO=who) for who in (0, 1)
        ]
        self._lit = program("garment_vertex.glsl", "dancer_fragment.glsl", SOFT=1, STYLED=0)
        self._styled = [
            program("garment_vertex.glsl", "styled_fragment.glsl", SOFT=1, STYLED=1, SURFACE=surface)
            for surface in (0, 1)
        ]
        self._ink = [
            program("garment_contour_vertex.glsl", "contour_fragment.glsl", SOFT=1, SURFACE=surface)
            for surface in (0, 1)
        ]
        self._shadow, self._mirror = (
            [
                program(f"garment_{kind}_vertex.glsl", f"{kind}_fragment.glsl", SOFT=0, STYLED=styled)
                for styled in (0, 1)
            ]
            for kind in ("shadow", "mirror")
        )

    def active(self, moment: Moment) -> bool:
        """Whether anybody wears a garment; uploads this frame's."""
        self._meshes.update(moment.view, moment.batch)
        self.box = self._meshes.box
        self._has_styles = moment.batch.styles.has_effects
        return self._meshes.any

    def light_active(self, moment: Moment) -> bool:
        """Whether styled garments are lit after the stage: as styled bodies without multisampling."""
        return self._has_styles and not self._multisampled and bool(moment.batch.styles.masks["bodies"].any())

    def draw_shadows(self) -> None:
        """Draw the shadows of garments into the bound layers of the floor map."""
        self._meshes.draw(self._shadow[self._has_styles], "shadow")

    def draw_mirrored(self) -> None:
        """Draw the garments as the floor mirrors them."""
        self._ctx.disable(moderngl.CULL_FACE)
        self._meshes.draw(self._mirror[self._has_styles], "mirror")

    def draw_surfaces(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.disable(moderngl.CULL_FACE)
        for where in _NEAR_AND_FAR:
            self._meshes.draw(self._surface[1], where)
        if self._has_styles:
            self._draw_styled(1)

    def draw_lit(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.disable(moderngl.CULL_FACE)
        moment.floor.use(1)
        set_uniform(self._lit, "floor_map", 1)
        for where in _NEAR_AND_FAR:
            self._meshes.draw(self._lit, where)
        if self._has_styles:
            self._draw_styled(0, moment)

    def draw_light(self, moment: Moment) -> None:
        """Light styled garments whose surfaces have been drawn."""
        target = self._ctx.fbo
        target.depth_mask = False
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.disable(moderngl.CULL_FACE | moderngl.BLEND)
        self._draw_styled(0, moment)
        target.depth_mask = True

    def _draw_styled(self, surface: int, moment: Moment | None = None) -> None:
        self._ctx.depth_func = "<="
        body, ink = self._styled[surface], self._ink[surface]
        if moment is not None:
            moment.floor.use(1)
            set_uniform(body, "floor_map", 1)
        for where in _NEAR_AND_FAR:
            self._meshes.draw(body, f"styled {where}")
        for side in (1.0, -1.0):
            set_uniform(ink, "side", side)
            for where in _NEAR_AND_FAR:
                self._meshes.draw(ink, f"ink {where}")
        self._ctx.depth_func = "<"

    def release(self) -> None:
        """Free everything."""
        release_all(*self._surface, self._lit, *self._styled, *self._ink, *self._shadow, *self._mirror, self._meshes)
