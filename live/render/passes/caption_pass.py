"""Render pass of the audience's caption: the choices of a vote with their shares, or the winner's name.

It is part of the picture, so that all projectors, films and streams show it, and it keeps out of the dance's way: low
in the middle, on a small panel.
"""

from typing import Final

import moderngl
import numpy as np

from live.base.stage_snapshot import StageView
from live.render.lettering.glyph_atlas import GlyphAtlas, bake_atlas
from live.render.shader import compile_program, release_all, set_uniform

_TEXTS_PER_HEIGHT: Final = 19
"""Number of lines as high as a winner's name that fill the picture's height."""
_SMALL: Final = 0.68
"""Size of the lines of a vote, as a share of that of a winner's name."""
_MIN_HEIGHT: Final = 14
_SAFE: Final = 0.07
"""Distance from the lower edge, as a share of the height: within what every projector surely shows."""
_MAX_LETTERS: Final = 512
_MAX_TEXT: Final = 40
"""Longest text [letters]; a longer one ends in dots."""
_MIN_BAR: Final = 9.0
"""Shortest bar of a share of 1, in heights of a letter."""
_PANEL, _LETTER, _TRACK, _BAR = 0.0, 1.0, 2.0, 3.0


class CaptionPass:
    """Draws the view's caption; lays it out only when it changes. Costs nothing while there is none."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        """`size`: width and height of the picture [pixels]."""
        self._ctx = ctx
        self._program = compile_program(ctx, "caption_vertex.glsl", "caption_fragment.glsl")
        self._buffer = ctx.buffer(reserve=(_MAX_LETTERS + 64) * 28, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f 3f/i", "in_box", "in_what")])
        self._atlas: moderngl.Texture | None = None
        self.resize(size)

    def resize(self, size: tuple[int, int]) -> None:
        """Set the size of the picture [pixels]; letters are drawn anew, which takes some frames."""
        self._size, self._count = size, 0
        self._lines: tuple[tuple[str, ...], tuple[int, ...]] = (), ()
        self._height = max(_MIN_HEIGHT, round(size[1] / _TEXTS_PER_HEIGHT))
        self._lettering: GlyphAtlas = bake_atlas(self._height)
        baked = self._lettering.coverage
        if self._atlas is not None:
            self._atlas.release()
        self._atlas = self._ctx.texture((baked.shape[1], baked.shape[0]), 1, baked.tobytes(), alignment=1)
        self._atlas.filter = (moderngl.LINEAR, moderngl.LINEAR)
        set_uniform(self._program, "cell", self._lettering.cell)

    def draw(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw the caption of `view` over the content of `target`."""
        level = view.caption_level * view.brightness
        if not view.caption or level <= 0.0 or self._atlas is None:
            return
        texts = tuple(text for text, _ in view.caption)
        shares = tuple(round(100.0 * share) for _, share in view.caption)
        if (texts, shares) != self._lines:
            self._lines = texts, shares
            self._lay_out(texts, shares)
        set_uniform(self._program, "level", level)
        set_uniform(self._program, "atlas", 1)
        target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._atlas.use(1)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._count)
        self._ctx.disable(moderngl.BLEND)

    def _lay_out(self, texts: tuple[str, ...], shares: tuple[int, ...]) -> None:
        """Write the boxes of a panel and of all lines; `shares` in hundredths, below 0: no bar."""
        atlas, has_bars = self._lettering, max(shares) >= 0
        scale = _SMALL if has_bars else 1.0
        texts = tuple(text if len(text) <= _MAX_TEXT else f"{text[: _MAX_TEXT - 1]}..." for text in texts)
        counts = tuple(f"{share} %" for share in shares)
        letter, inset = scale * self._height, 0.7 * scale * self._height
        widest = scale * max(atlas.width(text) for text in texts)
        if has_bars:  # the name at the left, the share at the right, the bar below both
            widest = max(widest + scale * atlas.width("  100 %"), _MIN_BAR * letter)
        pitch = (1.9 if has_bars else 1.2) * letter
        fit = min(1.0, 0.9 * self._size[0] / (widest + 2.0 * inset))
        wide, tall = widest + 2.0 * inset, len(texts) * pitch + 1.3 * inset
        left, top = 0.5 * (self._size[0] / fit - wide), (1.0 - _SAFE) * self._size[1] / fit - tall
        rows: list[tuple[float, ...]] = [(left, top, wide, tall, 0.55 * letter * fit, 0.0, _PANEL)]
        leading = max(shares)
        for number, (text, share, count) in enumerate(zip(texts, shares, counts, strict=True)):
            x, y = left + inset, top + 0.65 * inset + number * pitch
            rows += self._letters(text, x, y, scale)
            if share >= 0:
                rows += self._letters(count, x + widest - scale * atlas.width(count), y, scale)
                bar = (x, y + 1.38 * letter, widest, 0.14 * letter)
                rows.append((*bar, 0.0, 0.0, _TRACK))
                rows.append((bar[0], bar[1], bar[2] * share / 100.0, bar[3], float(share == leading), 0.0, _BAR))
        made = np.array(rows[: _MAX_LETTERS + 63], np.float32)
        made[:, :4] *= fit
        self._buffer.write(made)
        self._count = len(made)

    def _letters(self, text: str, x: float, y: float, scale: float) -> list[tuple[float, ...]]:
        """Return the boxes of a text's letters from a corner [pixels, y down]."""
        cell = self._lettering.cell
        placed = self._lettering.lay_out((text,), (0.0, 0.0), _MAX_LETTERS)
        return [
            (x + scale * float(row[0]), y + scale * float(row[1]), scale * cell[0], scale * cell[1],
             float(row[2]), float(row[3]), _LETTER)
            for row in placed
        ]  # fmt: skip

    def release(self) -> None:
        """Free everything."""
        if self._atlas is not None:
            self._atlas.release()
        release_all(self._array, self._buffer, self._program)
