"""Render passes for the dancers: forward shading with multisampling, or deferred shading where fill rate is scarce."""

import moderngl

from live.render.adaptive_quality import Quality
from live.render.camera import FAR, NEAR
from live.render.dancers.dancer_batch import Crowd
from live.render.gl_release import release_all
from live.render.pass_context import HDR, Surfaces
from live.render.shader import WORN, program, set_uniform


class DancerPass:
    """Forward pass: draws and lights near and far dancers into the bound target, with depth."""

    def __init__(self, ctx: moderngl.Context, quality: Quality, *, worn: bool = False) -> None:
        self._ctx, self.quality = ctx, quality
        files = "dancer_vertex.glsl", "dancer_fragment.glsl"
        self._program = program(ctx, *files, (("SOFT", 1),))
        self._worn = program(ctx, *files, (("SOFT", 1), *WORN)) if worn else None

    def draw(self, crowd: Crowd, floor_map: moderngl.Texture) -> None:
        """Draw all dancers of this frame, the near ones first (they hide others)."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        floor_map.use(1)
        for linked in filter(None, (self._program, self._worn)):
            set_uniform(linked, "floor_map", 1)
        crowd.draw(self._program, self.quality.near_level, "near", worn=self._worn)
        crowd.draw(self._program, self.quality.far_level, "far", worn=self._worn)

    def release(self) -> None:
        """Free the programs."""
        release_all(*filter(None, (self._program, self._worn)))


class SurfacePass:
    """Deferred pass: `draw` fills the G-buffer and the depth texture; `shade` lights them into the bound target.

    The target of `shade` must have `depth` attached too: its depth test selects the pixels that show a dancer. Test
    and shader both only read the depth, so there is no feedback loop.
    """

    def __init__(self, ctx: moderngl.Context, quality: Quality, size: tuple[int, int], *, worn: bool = False) -> None:
        self._ctx, self.quality = ctx, quality
        self._surface, self._named = (
            program(ctx, "dancer_vertex.glsl", "gbuffer_fragment.glsl", (("SOFT", 0), ("WHO", who))) for who in (0, 1)
        )
        self._worn = [
            program(ctx, "dancer_vertex.glsl", "gbuffer_fragment.glsl", (("SOFT", 0), ("WHO", who), *WORN))
            for who in (0, 1)
            if worn
        ]
        self._shades = [
            program(
                ctx, "full_vertex.glsl", "shade_fragment.glsl",
                (("NEAR", NEAR), ("FAR", FAR), ("HDR", hdr), ("BESIDE", beside)),
            )
            for hdr in (0, 1)
            for beside in (0, 1)
        ]  # fmt: skip
        self._triangles = [ctx.vertex_array(shade, []) for shade in self._shades]
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._cover, self._shape = self._ctx.texture(size, 4), self._ctx.texture(size, 4)
        self.depth = self._ctx.depth_texture(size)
        self.depth.compare_func = ""
        self._who = self._ctx.texture(size, 4)
        for texture in (self._cover, self._shape, self.depth, self._who):
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            texture.repeat_x = texture.repeat_y = False
        self._target = self._ctx.framebuffer([self._cover, self._shape], self.depth)
        self._named_target = self._ctx.framebuffer([self._cover, self._shape, self._who], self.depth)
        self.surfaces = Surfaces(self.depth, self._shape, self._who)

    def draw(self, crowd: Crowd, *, named: bool = False) -> None:
        """Draw the surfaces of all dancers, the near ones first (they hide others); `named`: with their numbers."""
        target, linked = (self._named_target, self._named) if named else (self._target, self._surface)
        target.use()
        target.clear()
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        worn = self._worn[named] if self._worn else None
        crowd.draw(linked, self.quality.near_level, "near", worn=worn)
        crowd.draw(linked, self.quality.far_level, "far", worn=worn)

    def shade(self, floor_map: moderngl.Texture, *, hdr: bool = False, beside: bool = True) -> None:
        """Light the surfaces into the bound target, which must not write depth; `hdr`: as compressed light; `beside`:
        with the additional lamps, which are off in the default light."""
        which = 2 * hdr + beside
        linked = self._shades[which]
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.depth_func = ">"
        textures = {"cover": self._cover, "shape": self._shape, "depth": self.depth, "floor_map": floor_map}
        for unit, (name, texture) in enumerate(textures.items(), start=1):
            texture.use(unit)
            set_uniform(linked, name, unit)
        self._triangles[which].render(moderngl.TRIANGLES, vertices=3)
        self._ctx.depth_func = "<"

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_target()
        self._make(size)

    def _release_target(self) -> None:
        release_all(self._target, self._named_target, self._cover, self._shape, self._who, self.depth)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        release_all(*self._triangles, self._surface, self._named, *self._worn, *self._shades)


class LitTarget:
    """Multisampled target for a forward-shaded scene: half floats with depth; `resolve` returns a texture."""

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
        """Bind and clear the target."""
        self.framebuffer.use()
        self.framebuffer.clear()
        return self.framebuffer

    def resolve(self) -> moderngl.Texture:
        """Average the samples of each pixel; return the texture (compressed light)."""
        self._ctx.copy_framebuffer(self._flat_target, self.framebuffer)
        return self._flat

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self.release()
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(self.framebuffer, self._many, self._depth, self._flat_target, self._flat)
