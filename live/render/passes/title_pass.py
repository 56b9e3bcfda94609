"""Render pass for titles and words: standing in the stage, hidden by dancers before them, or over the picture."""

from collections.abc import Sequence
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32
from live.base.stage_snapshot import StageView, Title
from live.render.lettering.distance_field import CELL, COLUMNS, EM, LetterField
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform

MAX_LETTERS: Final = 2048
"""Maximum number of letters of all titles of a moment; further ones are not drawn."""
ENTRANCES: Final = ("cut", "fade", "rise", "wipe", "type")
_CORNERS: Final = np.array([(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)], np.float32)
_FLOATS: Final = 6
_PICTURE: Final = "picture"
_STRAIGHT: Final = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
"""Blending of straight alpha: colour, opacity."""
_WIDEST: Final = 0.94
"""Titles over the picture are at most as wide as this share of it: longer ones are smaller."""
_FLOOR_FREE: Final = 0.02
"""Letters in the stage higher than this above the floor are mirrored in it [m]."""


class TitlePass(ScenePass):
    """Draws the view's titles; lays out those that have changed. Costs nothing while there are none."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._transparent = making.transparent
        self._multisampled = making.quality.samples > 0
        self._program = compile_program(ctx, "title_vertex.glsl", "title_fragment.glsl")
        self._buffer = ctx.buffer(reserve=MAX_LETTERS * 6 * _FLOATS * 4, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "2f 2f 2f", "in_corner", "in_texel", "in_order")])
        side = COLUMNS * CELL
        self._texture = ctx.texture((side, side), 1, bytes(side * side), alignment=1)
        self._texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._texture.repeat_x = self._texture.repeat_y = False
        self._field = LetterField(dict(making.scene.fonts), blocking=making.blocking_video)
        self._laid_out: tuple[tuple[str, str, float], ...] = ()
        self._parts: list[tuple[int, int, float]] = []  # of each title: first vertex, vertices, half width [ems]

    def prepare_titles(self, view: StageView) -> None:
        """Have the letters of a moment's titles made: their cells are given in the order of the titles."""
        if view.titles:
            self._prepare(view)

    def begin_anew(self, texts: Sequence[tuple[str, str]]) -> None:
        """Give all cells anew: as if these texts, with the names of their fonts, had been shown in this order."""
        self._field.clear()
        self._laid_out = ()
        for text, font in texts:
            self._field.request(text, font)

    @property
    def problems(self) -> list[str]:
        """Letters that are not shown."""
        return [f"titles: {words}" for words in self._field.missing]

    def active(self, moment: Moment) -> bool:
        """Whether any title stands in the stage."""
        return not self._transparent and any(title.place != _PICTURE for title in moment.view.titles)

    def light_active(self, moment: Moment) -> bool:
        """The same as `active`: called only then."""
        return True

    def draw_light(self, moment: Moment) -> None:
        """Draw the titles that stand in the stage, from the back to the front."""
        self._prepare(moment.view)
        ctx = self._ctx
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        ctx.disable(moderngl.CULL_FACE)
        target = ctx.fbo
        target.depth_mask, ctx.depth_func = False, "<="  # cells of letters overlap
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        standing = [pair for pair in zip(moment.view.titles, self._parts, strict=False) if pair[0].place != _PICTURE]
        for title, part in sorted(standing, key=lambda pair: pair[0].at[2]):
            self._set(title)
            em = title.size / self._field.cap_height(title.font)
            set_uniform(self._program, "standing", 1)
            set_uniform(self._program, "origin", title.at)
            set_uniform(self._program, "em", (em, em))
            for mirrored in (0, 1) if title.at[1] > _FLOOR_FREE else (0,):
                set_uniform(self._program, "mirrored", mirrored)
                self._render(part)
        target.depth_mask, ctx.depth_func = self._multisampled, "<"
        ctx.disable(moderngl.BLEND)

    def draw_over(self, view: StageView, target: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Draw the titles that lie over the picture onto `target`, a finished picture of this size [pixels]."""
        if not any(title.place == _PICTURE for title in view.titles):
            return
        self._prepare(view)
        ctx = self._ctx
        target.use()
        ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        ctx.enable(moderngl.BLEND)
        ctx.blend_func = _STRAIGHT  # type: ignore[assignment]  # moderngl knows four, too
        set_uniform(self._program, "standing", 0)
        set_uniform(self._program, "mirrored", 0)
        for title, part in zip(view.titles, self._parts, strict=False):
            if title.place != _PICTURE:
                continue
            self._set(title)
            em = 2.0 * title.size / self._field.cap_height(title.font)
            em = min(em, _WIDEST * size[0] / size[1] / max(part[2], 1e-6))
            set_uniform(self._program, "origin", (2.0 * title.at[0] - 1.0, 1.0 - 2.0 * title.at[1], 0.0))
            set_uniform(self._program, "em", (em * size[1] / size[0], em))
            self._render(part)
        ctx.disable(moderngl.BLEND)

    def _set(self, title: Title) -> None:
        linked = self._program
        self._texture.use(1)
        set_uniform(linked, "field", 1)
        set_uniform(linked, "texture_size", float(COLUMNS * CELL))
        set_uniform(linked, "entrance", ENTRANCES.index(title.entrance))
        set_uniform(linked, "progress", min(max(title.progress, 0.0), 1.0))
        set_uniform(linked, "level", min(max(title.level, 0.0), 1.0))
        set_uniform(linked, "colour", title.colour)

    def _render(self, part: tuple[int, int, float]) -> None:
        if part[1]:
            self._array.render(moderngl.TRIANGLES, vertices=part[1], first=part[0])

    def _prepare(self, view: StageView) -> None:
        """Lay out new titles, and upload the letters that have been made."""
        wanted = tuple((title.text, title.font, title.tracking) for title in view.titles)
        if wanted != self._laid_out:
            self._laid_out = wanted
            for text, font, _ in wanted:
                self._field.request(text, font)
            self._lay_out(wanted)
        while (made := self._field.made()) is not None:
            cell, field = made
            place = (cell % COLUMNS * CELL, cell // COLUMNS * CELL, CELL, CELL)
            self._texture.write(field.tobytes(), viewport=place, alignment=1)

    def _lay_out(self, wanted: tuple[tuple[str, str, float], ...]) -> None:
        self._parts, first = [], 0
        blocks: list[Float32] = []
        for text, font, tracking in wanted:
            letters, half_width, _ = self._field.lay_out(text, font, tracking)
            letters = letters[: MAX_LETTERS - first // 6]
            vertices = np.zeros((len(letters), 6, _FLOATS), np.float32)
            vertices[:, :, :2] = letters[:, None, :2] + _CORNERS * (CELL / EM)
            vertices[:, :, 2:4] = letters[:, None, 2:4] + np.array((0, CELL)) + _CORNERS * np.array((CELL, -CELL))
            vertices[:, :, 4:] = letters[:, None, 4:]
            blocks.append(vertices.reshape(-1, _FLOATS))
            self._parts.append((first, 6 * len(letters), half_width))
            first += 6 * len(letters)
        if first:
            self._buffer.write(np.concatenate(blocks))

    def release(self) -> None:
        """Free everything, and end the thread."""
        self._field.close()
        release_all(self._array, self._buffer, self._program, self._texture)
