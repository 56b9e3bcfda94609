"""Render passes for the dancers: forward shading with multisampling, or deferred shading where fill rate is scarce."""

from typing import Final

import moderngl

from live.render.adaptive_quality import Quality
from live.render.camera import FAR, NEAR
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.group_styles import NEARNESS
from live.render.pass_context import HDR, Surfaces
from live.render.shader import HEAD, WORN, compile_program, release_all, set_uniform
from live.render.uniforms import FrameUniforms

LIGHT_VARIANTS: Final = ((0, 0), (1, 0), (0, 1), (1, 1))
"""What the programs that light dancers have beside the usual light: lamps from the sides and behind, and what moves in
the light (gobos, what water throws up)."""


def light_variant(frame: FrameUniforms) -> int:
    """Return the index of the variant for a frame."""
    return LIGHT_VARIANTS.index((int(frame.side_lamps_lit), int(frame.light_moves)))


def _light_constants(variant: tuple[int, int]) -> tuple[tuple[str, int], ...]:
    return tuple(zip(("BESIDE", "MOVING"), variant, strict=True))


class DancerPass:
    """Forward pass: draws and lights near and far dancers into the bound target, with depth."""

    def __init__(self, ctx: moderngl.Context, quality: Quality, *, characters: bool = False) -> None:
        self._ctx, self.quality = ctx, quality
        files = "dancer_vertex.glsl", "dancer_fragment.glsl"
        lights = [(("SOFT", 1), *_light_constants(variant)) for variant in LIGHT_VARIANTS]
        self._programs = [compile_program(ctx, *files, light) for light in lights]
        self._head_programs = [compile_program(ctx, *files, (*light, *HEAD)) for light in lights]
        self._character_programs = [compile_program(ctx, *files, (*light, *WORN)) for light in lights if characters]

    def draw(self, crowd: DancerBatch, floor_map: moderngl.Texture, light: int) -> None:
        """Draw all dancers of this frame, the near ones first (they hide others); `light`: see `LIGHT_VARIANTS`."""
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        floor_map.use(1)
        program, head = self._programs[light], self._head_programs[light]
        worn = self._character_programs[light] if self._character_programs else None
        for linked in filter(None, (program, head, worn)):
            set_uniform(linked, "floor_map", 1)
        for where in NEARNESS:
            crowd.draw(program, self.quality.level_of(where), where, character_program=worn, head_program=head)

    def release(self) -> None:
        """Free the programs."""
        release_all(*self._programs, *self._head_programs, *self._character_programs)


class GBufferPass:
    """Deferred pass: `draw` fills the G-buffer and the depth texture; `shade` lights them into the bound target.

    The target of `shade` must have `depth` attached too: its depth test selects the pixels that show a dancer. Test
    and shader both only read the depth, so there is no feedback loop.
    """

    def __init__(
        self, ctx: moderngl.Context, quality: Quality, size: tuple[int, int], *, characters: bool = False
    ) -> None:
        self._ctx, self.quality = ctx, quality
        self._surface, self._id_program = (
            compile_program(ctx, "dancer_vertex.glsl", "gbuffer_fragment.glsl", (("SOFT", 0), ("WHO", who)))
            for who in (0, 1)
        )
        self._head_programs = [
            compile_program(ctx, "dancer_vertex.glsl", "gbuffer_fragment.glsl", (("SOFT", 0), ("WHO", who), *HEAD))
            for who in (0, 1)
        ]
        self._character_programs = [
            compile_program(ctx, "dancer_vertex.glsl", "gbuffer_fragment.glsl", (("SOFT", 0), ("WHO", who), *WORN))
            for who in (0, 1)
            if characters
        ]
        self._shades = [
            compile_program(
                ctx, "full_vertex.glsl", "shade_fragment.glsl",
                (("NEAR", NEAR), ("FAR", FAR), ("HDR", hdr), *_light_constants(variant)),
            )
            for hdr in (0, 1)
            for variant in LIGHT_VARIANTS
        ]  # fmt: skip
        self._triangles = [ctx.vertex_array(shade, []) for shade in self._shades]
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._coverage, self._shape = self._ctx.texture(size, 4), self._ctx.texture(size, 4)
        self.depth = self._ctx.depth_texture(size)
        self.depth.compare_func = ""
        self._ids = self._ctx.texture(size, 4)
        for texture in (self._coverage, self._shape, self.depth, self._ids):
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            texture.repeat_x = texture.repeat_y = False
        self._target = self._ctx.framebuffer([self._coverage, self._shape], self.depth)
        self._id_target = self._ctx.framebuffer([self._coverage, self._shape, self._ids], self.depth)
        self.surfaces = Surfaces(self.depth, self._shape, self._ids)

    def draw(self, crowd: DancerBatch, *, with_ids: bool = False) -> None:
        """Draw the surfaces of all dancers, the near ones first (they hide others); `with_ids`: with their numbers."""
        target, linked = (self._id_target, self._id_program) if with_ids else (self._target, self._surface)
        target.use()
        target.clear()
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        worn = self._character_programs[with_ids] if self._character_programs else None
        head = self._head_programs[with_ids]
        for where in NEARNESS:
            crowd.draw(linked, self.quality.level_of(where), where, character_program=worn, head_program=head)

    def shade(self, floor_map: moderngl.Texture, light: int, *, hdr: bool = False, beams: bool = False) -> None:
        """Light the surfaces into the bound target, which must not write depth; `hdr`: as compressed light; `light`:
        see `LIGHT_VARIANTS`; `beams`: with their light before them."""
        which = len(LIGHT_VARIANTS) * hdr + light
        linked = self._shades[which]
        self._ctx.enable(moderngl.DEPTH_TEST)
        self._ctx.depth_func = ">"
        textures = {"cover": self._coverage, "shape": self._shape, "depth": self.depth, "floor_map": floor_map}
        for unit, (name, texture) in enumerate(textures.items(), start=1):
            texture.use(unit)
            set_uniform(linked, name, unit)
        set_uniform(linked, "beams", int(beams))
        self._triangles[which].render(moderngl.TRIANGLES, vertices=3)
        self._ctx.depth_func = "<"

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._release_target()
        self._make(size)

    def _release_target(self) -> None:
        release_all(self._target, self._id_target, self._coverage, self._shape, self._ids, self.depth)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        release_all(*self._triangles, self._surface, self._id_program)
        release_all(*self._head_programs, *self._character_programs, *self._shades)


class MultisampleTarget:
    """Multisampled target for a forward-shaded scene: half floats with depth; `resolve` returns a texture."""

    def __init__(self, ctx: moderngl.Context, samples: int, size: tuple[int, int]) -> None:
        self._ctx, self._samples = ctx, samples
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        ctx = self._ctx
        self._samples_buffer = ctx.renderbuffer(size, 4, samples=self._samples, dtype=HDR)
        self._depth = ctx.depth_renderbuffer(size, samples=self._samples)
        self.framebuffer = ctx.framebuffer([self._samples_buffer], self._depth)
        self._resolved = ctx.texture(size, 4, dtype=HDR)
        self._resolved.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._resolved.repeat_x = self._resolved.repeat_y = False
        self._resolved_target = ctx.framebuffer([self._resolved])

    def begin(self) -> moderngl.Framebuffer:
        """Bind and clear the target."""
        self.framebuffer.use()
        self.framebuffer.clear()
        return self.framebuffer

    def resolve(self) -> moderngl.Texture:
        """Average the samples of each pixel; return the texture (compressed light)."""
        self._ctx.copy_framebuffer(self._resolved_target, self.framebuffer)
        return self._resolved

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self.release()
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(self.framebuffer, self._samples_buffer, self._depth, self._resolved_target, self._resolved)
