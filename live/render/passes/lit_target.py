"""What a multisampled scene is drawn into, lit at once; its samples are averaged before the picture passes."""

import moderngl

from live.render.gl_release import release_all
from live.render.pass_context import HDR


class LitTarget:
    """`framebuffer`: half floats, multisampled, with depth; `resolve` gives them as a texture."""

    def __init__(self, ctx: moderngl.Context, samples: int, size: tuple[int, int]) -> None:
        self._ctx, self._samples = ctx, samples
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        ctx = self._ctx
        self._many = ctx.renderbuffer(size, 4, samples=self._samples, dtype=HDR)
        self._depth = ctx.depth_renderbuffer(size, samples=self._samples)
        self.framebuffer = ctx.framebuffer([self._many], self._depth)
        self._flat = ctx.texture(size, 4, dtype=HDR)
        self._flat.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._flat.repeat_x = self._flat.repeat_y = False
        self._flat_target = ctx.framebuffer([self._flat])

    def begin(self) -> moderngl.Framebuffer:
        """Bind it, empty."""
        self.framebuffer.use()
        self.framebuffer.clear()
        return self.framebuffer

    def resolve(self) -> moderngl.Texture:
        """The samples of each pixel averaged: compressed light."""
        self._ctx.copy_framebuffer(self._flat_target, self.framebuffer)
        return self._flat

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self.release()
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(self.framebuffer, self._many, self._depth, self._flat_target, self._flat)
