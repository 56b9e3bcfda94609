"""Post-process antialiasing of the dancers' edges, used where there is no multisampling."""

import moderngl

from live.render.pass_context import HDR
from live.render.shader import compile_program, release_all, set_uniform


class AntialiasPass:
    """Owns the target that the scene is drawn into, which shares the dancers' depth, and smooths edges in it."""

    def __init__(
        self, ctx: moderngl.Context, depth: moderngl.Texture, size: tuple[int, int], *, hdr: bool = False
    ) -> None:
        """`hdr`: the target holds compressed light in half floats; otherwise display values in 8 bits."""
        self._ctx, self._kind = ctx, HDR if hdr else "f1"
        self._program = compile_program(ctx, "full_vertex.glsl", "smooth_fragment.glsl", (("HDR", int(hdr)),))
        self._triangle = ctx.vertex_array(self._program, [])
        self.sharpness = 0.0
        """Strength of sharpening, for a picture that will be enlarged."""
        self._make(depth, size)

    def _make(self, depth: moderngl.Texture, size: tuple[int, int]) -> None:
        self._drawn, self._smoothed = (self._ctx.texture(size, 4, dtype=self._kind) for _ in range(2))
        for texture in (self._drawn, self._smoothed):
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self.target = self._ctx.framebuffer([self._drawn], depth)
        self._result = self._ctx.framebuffer([self._smoothed], depth)
        self.target.depth_mask = self._result.depth_mask = False
        self._from, self._to = self._ctx.framebuffer([self._drawn]), self._ctx.framebuffer([self._smoothed])

    def draw(self, target: moderngl.Framebuffer, region: tuple[int, int, int, int]) -> None:
        """Copy `self.target` to `target`, with the dancers' edges smoothed."""
        self.smooth(region)
        self._ctx.copy_framebuffer(target, self._to)

    def smooth(self, region: tuple[int, int, int, int]) -> moderngl.Texture:
        """Return the content of `self.target` with the dancers' edges smoothed.

        `region`: rectangle (x, y, width, height) that contains all dancers.
        """
        self._ctx.copy_framebuffer(self._to, self._from)  # without the shared depth
        self._result.use()
        self._result.scissor = region
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.depth_func = ">"
        self._drawn.use(1)
        set_uniform(self._program, "drawn", 1)
        set_uniform(self._program, "crisp", self.sharpness)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._ctx.depth_func = "<"
        self._result.scissor = (0, 0, *self._smoothed.size)  # the scissor also applies to copies
        return self._smoothed

    def resize(self, depth: moderngl.Texture, size: tuple[int, int]) -> None:
        """New size of the picture [pixels] and the depth that goes with it."""
        self._release_targets()
        self._make(depth, size)

    def _release_targets(self) -> None:
        release_all(self.target, self._result, self._from, self._to, self._drawn, self._smoothed)

    def release(self) -> None:
        """Free everything."""
        self._release_targets()
        self._triangle.release()
        self._program.release()
