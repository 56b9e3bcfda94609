"""Pictures with alpha: how much of each pixel is covered, kept apart from its colour.

A picture that is laid over another one by its alpha must hold the colour of what covers the pixel, not that colour
already darkened along its edges ("straight" alpha). So the scene, drawn on nothing, is divided by its cover before
the picture passes and the film curve (Porter and Duff 1984, section 3); light in the air (ghosts, ribbons, glow) gets
the alpha with which it looks the same over black.
"""

import moderngl

from live.render.gl_release import release_all
from live.render.pass_context import HDR
from live.render.shader import Full


class MattePass:
    """`keep` the surfaces, `straighten` the scene, draw its picture into `target`, then `draw` it with its alpha."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._ctx = ctx
        self._straight = Full(ctx, "matte_straight_fragment.glsl")
        self._end = Full(ctx, "matte_fragment.glsl")
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        ctx = self._ctx
        self._kept, self._light = (ctx.texture(size, 4, dtype=HDR) for _ in range(2))
        self._shown = ctx.texture(size, 4)
        for texture in (self._kept, self._light, self._shown):
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._kept_target, self._light_target, self.target = (
            ctx.framebuffer([texture]) for texture in (self._kept, self._light, self._shown)
        )

    def keep(self, drawn: moderngl.Framebuffer) -> None:
        """Keep the surfaces that were drawn; what comes over them leaves the cover as it is."""
        self._ctx.copy_framebuffer(self._kept_target, drawn)
        drawn.use()

    def straighten(self, scene: moderngl.Texture) -> moderngl.Texture:
        """The scene, compressed light, with the full colour of what covers a pixel, however little of it."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._scene = scene
        self._straight.draw(self._light_target, kept=self._kept, scene=scene)
        return self._light

    def draw(self, target: moderngl.Framebuffer, brightness: float) -> None:
        """Draw the picture in `self.target` onto `target` with its alpha, which a blackout takes along."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._end.set("brightness", min(max(brightness, 0.0), 1.0))
        self._end.draw(target, kept=self._kept, scene=self._scene, picture_drawn=self._shown)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_targets()
        self._make(size)

    def _release_targets(self) -> None:
        release_all(self._kept_target, self._light_target, self.target, self._kept, self._light, self._shown)

    def release(self) -> None:
        """Free everything."""
        self._release_targets()
        release_all(self._straight, self._end)
