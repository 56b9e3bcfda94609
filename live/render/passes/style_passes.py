"""All that the groups' styles ask for beside plain lit bodies; where they ask for nothing, nothing is done."""

import moderngl

from live.render.gl_release import release_all
from live.render.pass_context import Making, Moment, ScenePass
from live.render.passes.ghost_pass import GhostPass
from live.render.passes.particle_pass import ParticlePass
from live.render.passes.ribbon_pass import RibbonPass
from live.render.passes.styled_pass import StyledPass
from live.render.passes.xray_pass import XrayPass

_LIGHT = ("trails", "ribbons", "xray", "particles")


class StylePasses(ScenePass):
    """Bodies in styles are drawn with the other dancers; ghosts, ribbons, x-rays and particles over the stage."""

    def __init__(self, making: Making) -> None:
        self._ctx, self._many = making.ctx, making.quality.samples > 0
        self._styled = StyledPass(making.ctx, worn=bool(making.scene.characters))
        self._ghosts, self._ribbons = GhostPass(making), RibbonPass(making)
        self._particles, self._xray = ParticlePass(making), XrayPass(making)

    def active(self, moment: Moment) -> bool:
        """Whether any group is drawn otherwise than as plain lit bodies."""
        if moment.crowd.styles.any:
            return True
        self._ghosts.history.forget()
        self._ribbons.history.forget()
        return False

    def prepare(self, moment: Moment) -> None:
        """What leaves a trace is followed while any group shows it."""
        styles = moment.crowd.styles
        for each, name in ((self._ribbons, "ribbons"), (self._ghosts, "trails")):
            if styles.masks[name].any():
                each.follow(moment.crowd, moment.view)
            else:
                each.history.forget()

    def surfaces(self, moment: Moment) -> None:
        """Where bodies in styles are, and how deep."""
        if _bodies(moment):
            self._styled.draw(moment.crowd, moment.floor, surface=True)

    def lit(self, moment: Moment) -> None:
        """Bodies in styles, in a multisampled picture."""
        if _bodies(moment):
            self._styled.draw(moment.crowd, moment.floor)

    def over_active(self, moment: Moment) -> bool:
        """Where the processor draws, bodies in styles are lit here, too: their depth is known already."""
        return _light(moment) or (_bodies(moment) and not self._many)

    def over(self, moment: Moment) -> None:
        """Draw what is left of bodies in styles, then light over the stage, the softest first."""
        ctx, crowd = self._ctx, moment.crowd
        target = ctx.fbo
        target.depth_mask = False
        if _bodies(moment) and not self._many:
            self._styled.draw(crowd, moment.floor)
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        ctx.disable(moderngl.CULL_FACE)
        ctx.depth_func = "<="
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        if crowd.count("trails"):
            self._ghosts.draw(crowd)
        if crowd.count("ribbons"):
            self._ribbons.draw(crowd)
        if crowd.count("xray"):
            self._xray.draw(crowd)
        if crowd.count("particles"):
            self._particles.draw(crowd, moment.view)
        ctx.depth_func = "<"
        ctx.disable(moderngl.BLEND | moderngl.DEPTH_TEST)
        target.depth_mask = self._many

    def release(self) -> None:
        """Free everything."""
        release_all(self._styled, self._ghosts, self._ribbons, self._particles, self._xray)


def _bodies(moment: Moment) -> bool:
    return moment.crowd.count("bodies near") + moment.crowd.count("bodies far") > 0


def _light(moment: Moment) -> bool:
    return any(moment.crowd.count(name) for name in _LIGHT)
