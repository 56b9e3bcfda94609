"""Render pass for a user's fragment shader, `passes/NAME.glsl` in the patch's folder."""

import re
from functools import cache
from typing import Final

import moderngl

from live.base.custom_pass import NUMBERS_PER_PASS, CustomShader
from live.base.picture_parameters import CUSTOM_PASS_SLICE
from live.render.custom_pass import compile_pass
from live.render.pass_context import HDR, Moment, PassSetup, Surfaces
from live.render.shader import release_all, set_uniform

_READS_SURFACES: Final = re.compile(r"\b(depth|normal|dancer)\s*\(")
_READS_LAST: Final = re.compile(r"\blast\s*\(")
_LOOKS: Final = re.compile(r"\b(?:light|last|depth|normal|dancer)\s*\(\s*([^()]*)")
_MOVES: Final = re.compile(
    r"\bat\b\s*(?:\.\s*\w+|\[[^\]]*\])?\s*(?:[-+*/]?=(?!=)|\+\+|--)|(?:\+\+|--)\s*at\b|#|\b(?:in)?out\b|\bown_\w+_\b"
)
_COMMENT: Final = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_BEAT_PERIOD: Final = 4096.0


def reads_last_picture(own: CustomShader) -> bool:
    """Whether a shader reads its own last picture, so that it may remember all before."""
    return _READS_LAST.search(own.source) is not None


@cache
def reads_elsewhere(own: CustomShader) -> bool:
    """Return whether a shader may look at other places than that of its own pixel: unless all that it looks at is `at`,
    which is named once and never changed."""
    text = _COMMENT.sub(" ", own.source)
    others = any(place.strip() != "at" for place in _LOOKS.findall(text))
    return others or _MOVES.search(text) is not None or len(re.findall(r"\bvec2\s+at\b", text)) > 1


class CustomPass:
    """Draws with the last source that compiled; `replace_source` replaces it."""

    def __init__(self, making: PassSetup, own: CustomShader, slot: int) -> None:
        """`slot`: index of its parameters in the picture's row. Raises PersonError if it does not compile."""
        self._ctx, self._first = making.ctx, CUSTOM_PASS_SLICE.start + slot * NUMBERS_PER_PASS
        self._size = making.size
        self._program = compile_pass(making.ctx, own)
        self._triangle = making.ctx.vertex_array(self._program, [])
        self._read_source(own)
        self._make(making.size)

    def _read_source(self, own: CustomShader) -> None:
        self.definition = own
        self.needs_surfaces = _READS_SURFACES.search(own.source) is not None
        self._needs_last = reads_last_picture(own)

    def _make(self, size: tuple[int, int]) -> None:
        self._size = size
        self._last = self._ctx.texture(size if self._needs_last else (1, 1), 4, dtype=HDR)
        self._last.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._last.repeat_x = self._last.repeat_y = False
        self._last_target = self._ctx.framebuffer([self._last])
        self._last_target.clear()
        self._has_last = False

    def replace_source(self, own: CustomShader) -> None:
        """Replace the source. Raises PersonError if it does not compile; the old one then stays in use."""
        program = compile_pass(self._ctx, own)
        release_all(self._triangle, self._program)
        self._program, self._triangle = program, self._ctx.vertex_array(program, [])
        self._read_source(own)
        self.resize(self._size)

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        used = moment.parameter(self._first) > 0.0
        self._has_last &= used  # the stored picture is outdated when the pass is switched on again
        return used

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` through the shader."""
        linked, view, first, part = self._program, moment.view, self._first, moment.uniforms.part
        target.use()
        textures = {"own_light_": source, "own_last_": self._last if self._has_last and not moment.cut else source}
        if surfaces is not None:
            textures |= {"own_depth_": surfaces.depth, "own_shape_": surfaces.shape, "own_who_": surfaces.identity}
        for unit, (name, texture) in enumerate(textures.items(), start=1):
            texture.use(unit)
            set_uniform(linked, name, unit)
        values = {
            "amount": moment.parameter(first), "beat": view.beat % _BEAT_PERIOD, "phase": view.phase,
            "measure": view.measure + 1.0, "tempo": view.tempo, "energy": getattr(view, "energy", 0.0),
            "time": view.time, "size": part.whole,
            "own_part_": (*part.share, part.left / part.whole[0], part.bottom / part.whole[1]),
        }  # fmt: skip
        for name, value in values.items():
            set_uniform(linked, name, value)
        for index, known in enumerate(self.definition.parameters, start=1):
            set_uniform(linked, known.name, moment.parameter(first + index))
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        if self._needs_last:
            self._ctx.copy_framebuffer(self._last_target, target)
            self._has_last = True

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        release_all(self._last_target, self._last)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(self._last_target, self._last, self._triangle, self._program)
