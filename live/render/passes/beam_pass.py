"""Render pass for light beams in haze: cones of the lamps above the stage and of the follow spots."""

from typing import Final

import moderngl

from live.base.parameter import SPOT_COUNT
from live.base.picture_parameters import BY_ADDRESS
from live.render.pass_context import HDR, Moment, PassSetup, ScenePass
from live.render.shader import SHARED_TEXTURES, compile_program, release_all, set_uniform

_DIVISOR: Final = 4
"""Light in haze is soft: it is drawn at 1/n of the picture's size and enlarged."""
_FRONT_SHARE: Final = 0.45
"""Mean share of a beam's light in front of a dancer: the dancer hides the rest."""
_LAMP_ROWS: Final = (
    BY_ADDRESS["/dance/light/beams"].first,
    *(BY_ADDRESS[f"/dance/spot/{number}"].first for number in range(1, SPOT_COUNT + 1)),
)


class BeamPass(ScenePass):
    """Draws the beams; costs nothing while all are dark.

    Their light lies before dancers and stage. If nothing else is drawn over these, the stage adds it itself (`within`),
    and so do dancers whose pixels are shaded once; that is far cheaper in software than blending it over the picture.
    """

    def __init__(self, making: PassSetup) -> None:
        self.within = False
        """Whether the stage adds the light of this frame."""
        self._blends = making.quality.samples > 0
        self._ctx = making.ctx
        self._beams = compile_program(making.ctx, "full_vertex.glsl", "beam_fragment.glsl")
        self._composite = compile_program(making.ctx, "full_vertex.glsl", "beam_over_fragment.glsl")
        self._triangles = [making.ctx.vertex_array(linked, []) for linked in (self._beams, self._composite)]
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        small = (max(size[0] // _DIVISOR, 1), max(size[1] // _DIVISOR, 1))
        self._light = self._ctx.texture(small, 4, dtype=HDR)
        self._light.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._light.repeat_x = self._light.repeat_y = False
        self._target = self._ctx.framebuffer([self._light])

    def active(self, moment: Moment) -> bool:
        """Whether any beam is lit."""
        return any(moment.parameter(place) > 0.0 for place in _LAMP_ROWS)

    def light_active(self, moment: Moment) -> bool:
        """Whether the light is blended over the picture: called only while `active`."""
        return self._blends or not self.within

    def prepare(self, moment: Moment) -> None:
        """Integrate the light of all beams along each view ray."""
        self._target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._triangles[0].render(moderngl.TRIANGLES, vertices=3)
        self._light.use(SHARED_TEXTURES["beam_map"])

    def draw_light(self, moment: Moment) -> None:
        """Add the light to the picture: all of it where the stage is visible, a part in front of dancers."""
        ctx = self._ctx
        self._light.use(1)
        set_uniform(self._composite, "beams", 1)
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_COLOR
        if not self.within:
            self._blend("<=", 1.0)
        target = ctx.fbo
        target.scissor = moment.rectangle
        self._blend(">", _FRONT_SHARE)
        target.scissor = (0, 0, *target.size)
        ctx.depth_func = "<"
        ctx.disable(moderngl.BLEND)

    def _blend(self, test: str, share: float) -> None:
        self._ctx.depth_func = test
        set_uniform(self._composite, "share", share)
        self._triangles[1].render(moderngl.TRIANGLES, vertices=3)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        release_all(self._target, self._light)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self._light, *self._triangles, self._beams, self._composite)
