"""Render pass for frames with straight (not premultiplied) alpha.

The scene, drawn on a transparent ground, is divided by its coverage before post-processing and tone mapping (Porter
and Duff 1984, section 3), so that edges are not darkened. Additive light (ghosts, ribbons, glow) gets the alpha with
which it looks the same over black.
"""

import moderngl

from live.render.pass_context import HDR
from live.render.shader import FullscreenShader, release_all


class AlphaPass:
    """`store_coverage` the surfaces, `straighten` the scene, draw its picture into `target`, then `draw` it with its
    alpha."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._ctx = ctx
        self._straight = FullscreenShader(ctx, "matte_straight_fragment.glsl")
        self._final = FullscreenShader(ctx, "matte_fragment.glsl")
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        ctx = self._ctx
        self._coverage, self._light = (ctx.texture(size, 4, dtype=HDR) for _ in range(2))
        self._picture = ctx.texture(size, 4)
        for texture in (self._coverage, self._light, self._picture):
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._coverage_target, self._light_target, self.target = (
            ctx.framebuffer([texture]) for texture in (self._coverage, self._light, self._picture)
        )

    def store_coverage(self, drawn: moderngl.Framebuffer) -> None:
        """Store the drawn surfaces with their coverage; later drawing does not change it."""
        self._ctx.copy_framebuffer(self._coverage_target, drawn)
        drawn.use()

    def straighten(self, scene: moderngl.Texture) -> moderngl.Texture:
        """Return the scene (compressed light) with straight alpha: full colour also at partly covered pixels."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._scene = scene
        self._straight.draw(self._light_target, kept=self._coverage, scene=scene)
        return self._light

    def draw(self, target: moderngl.Framebuffer, brightness: float) -> None:
        """Draw `self.target` onto `target` with alpha; a blackout (`brightness` 0) also fades the alpha."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._final.set("brightness", min(max(brightness, 0.0), 1.0))
        self._final.draw(target, kept=self._coverage, scene=self._scene, picture_drawn=self._picture)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_targets()
        self._make(size)

    def _release_targets(self) -> None:
        release_all(self._coverage_target, self._light_target, self.target, self._coverage, self._light, self._picture)

    def release(self) -> None:
        """Free everything."""
        self._release_targets()
        release_all(self._straight, self._final)
