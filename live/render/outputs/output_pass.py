"""Render passes of an output window: warped picture or test card, and the handles of the warp editor."""

from collections.abc import Sequence
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt
from PIL import Image

from live.base.arrays import Float32
from live.base.errors import PersonError
from live.render.camera import PicturePart
from live.render.lettering.glyph_atlas import bake_atlas
from live.render.outputs.output import Output, Point
from live.render.outputs.test_card import CARDS, TINTS, Card, render_digits, render_label
from live.render.outputs.warp import MAX_VERTICES, vertices
from live.render.shader import compile_program, release_all, set_uniform

LARGEST_MASK: Final = 8192
DISPLAY_GAMMA: Final = 2.2
"""Display gamma: light = signal ** SIGNAL."""

_ROTATIONS: Final = {
    0: ((1, 0, 0), (0, 1, 0)),
    90: ((0, 1, 0), (-1, 0, 1)),
    180: ((-1, 0, 1), (0, -1, 1)),
    270: ((0, -1, 1), (1, 0, 0)),
}
"""By rotation: rows of the matrix from (u, v, 1) of the frame to the cropped picture, upright."""


class OutputPass:
    """Draws one output. GL objects are created here and in `set`, in the context of the output's window."""

    def __init__(self, ctx: moderngl.Context, output: Output, number: int = 0, detail: str = "") -> None:
        """`number`: of the output, from 0, for its tint; `detail`: a line under its name. Raises PersonError if the
        mask cannot be read."""
        self._ctx = ctx
        shaders = "output_vertex.glsl", "output_fragment.glsl"
        kinds = (
            ("TINTED", int(output.is_tinted)), ("GAMMA", int(output.gamma != 1.0)),
            ("BLACK", int(output.edge.black > 0.0)), ("MASKED", int(output.mask is not None)),
        )  # fmt: skip
        self._programs = [compile_program(ctx, *shaders, (("CARD", card), *kinds)) for card in (0, 1)]
        self._buffer = ctx.buffer(reserve=MAX_VERTICES * 20, dynamic=True)
        place = [(self._buffer, "3f 2f", "in_place", "in_frame")]
        self._arrays = [ctx.vertex_array(linked, place) for linked in self._programs]
        picture = render_label(output.name, detail)
        self._label = _grey_texture(ctx, picture)
        self._mask = _grey_texture(ctx, np.full((1, 1), 255, np.uint8) if output.mask is None else read_mask(output))
        self._join_card = _grey_texture(ctx, np.full((1, 1), 255, np.uint8))
        self._digits = _grey_texture(ctx, render_digits())
        self._set_uniforms("sheet_size", (1, 1))
        for unit, name in enumerate(("picture", "mask", "words", "sheet", "digits"), start=1):
            self._set_uniforms(name, unit)
        self._set_uniforms("words_size", (picture.shape[1], picture.shape[0]))
        self._set_uniforms("card_tint", TINTS[number % len(TINTS)])
        self.set(output)

    def _set_uniforms(self, name: str, value: object) -> None:
        for linked in self._programs:
            set_uniform(linked, name, value)

    def set(self, output: Output) -> None:
        """Set warp, crop and soft edge from `output`; mask and shader variant do not change."""
        self._output = output
        data = vertices(output)
        self._buffer.write(data)
        self._count = len(data)
        edge = output.edge
        across, down = bool(edge.left or edge.right), bool(edge.top or edge.bottom)
        self._set_uniforms("crop", output.crop)
        self._set_uniforms("turned", rotation_matrix(output).T.ravel().tolist())
        self._set_uniforms("edge", (edge.left, edge.right, edge.top, edge.bottom))
        self._set_uniforms("blend", (edge.gamma, edge.black, (1 + across) * (1 + down)))
        self._set_uniforms("bent", output.is_warped)

    def set_join_card(self, image: npt.NDArray[np.uint8]) -> None:
        """Set the join card of the audience: brightness, row 0 on top, shape (H, W)."""
        self._join_card.release()
        self._join_card = _grey_texture(self._ctx, np.ascontiguousarray(image))
        self._set_uniforms("sheet_size", (image.shape[1], image.shape[0]))

    def draw(
        self, picture: moderngl.Texture, target: moderngl.Framebuffer, *, card: Card = "off", light_share: float = 1.0,
        tick: int = -1, part: PicturePart | None = None,
    ) -> None:  # fmt: skip
        """Draw `picture`, or a test card, over all of `target`; `light_share`: the light allowed by the flash limit;
        `tick`: the one that a render node presents, for its cards; `part`: what `picture` holds of the whole one."""
        part = part or PicturePart.of(picture.size)
        width, height = target.viewport[2:]
        upright = self._output.rotation in (0, 180)
        drawn = int(card != "off")
        linked, array = self._programs[drawn], self._arrays[drawn]
        set_uniform(linked, "window_size", (width, height))
        set_uniform(linked, "frame_size", (width, height) if upright else (height, width))
        set_uniform(linked, "picture_size", part.whole)
        set_uniform(linked, "drawn", (*part.corner, *part.share))
        set_uniform(
            linked, "light", (self._output.brightness, self._output.gamma, light_share ** (1.0 / DISPLAY_GAMMA))
        )
        set_uniform(linked, "card", CARDS.index(card))
        set_uniform(linked, "tick", tick)
        target.use()
        target.clear(0.0, 0.0, 0.0, 1.0)
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        picture.use(1)
        self._mask.use(2)
        self._label.use(3)
        self._join_card.use(4)
        self._digits.use(5)
        array.render(moderngl.TRIANGLES, vertices=self._count)

    def release(self) -> None:
        """Free everything."""
        release_all(
            *self._arrays, self._buffer, self._label, self._mask, self._join_card, self._digits, *self._programs
        )


def rotation_matrix(output: Output) -> npt.NDArray[np.float32]:
    """Return the matrix (2, 3) from (u, v, 1) of the frame to the cropped picture, upright: rotation, then mirror."""
    matrix = np.array(_ROTATIONS[output.rotation], np.float32)
    if output.mirror:
        matrix[0] = (0.0, 0.0, 1.0) - matrix[0]
    return matrix


def read_mask(output: Output) -> npt.NDArray[np.uint8]:
    """Return the mask of an output, row 0 on top, shape (H, W). Raises PersonError if it cannot be read."""
    path = output.mask
    try:
        with Image.open(str(path)) as image:
            if max(image.size) > LARGEST_MASK:
                raise PersonError(f"mask {path}: {image.size[0]}x{image.size[1]} pixels", f"at most {LARGEST_MASK}")
            return np.array(image.convert("L"), np.uint8)
    except FileNotFoundError:
        raise PersonError(f"mask {path}: there is no such file", "put a PNG next to the venue file") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise PersonError(f"mask {path}: cannot be read as an image: {error}", "save it as PNG") from None


def _grey_texture(ctx: moderngl.Context, picture: npt.NDArray[np.uint8]) -> moderngl.Texture:
    """Create a texture with one channel."""
    texture = ctx.texture((picture.shape[1], picture.shape[0]), 1, picture.tobytes(), alignment=1)
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


_MAX_MARKS: Final = 1600
"""Maximum number of points and letters together."""
_MAX_LETTERS: Final = 1024
_LINES_PER_HEIGHT: Final = 38
"""Number of text lines that fill the window's height."""
_RADIUS: Final = 0.022
"""Radius of a point's mark, as a share of the window's height."""


class HandlePass:
    """Draws movable points and help text over an edited output. Belongs to the context of the output's window; the
    glyph atlas is made for its height."""

    def __init__(self, ctx: moderngl.Context, height: int) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "handle_vertex.glsl", "handle_fragment.glsl")
        self._buffer = ctx.buffer(reserve=_MAX_MARKS * 32, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f 4f/i", "in_box", "in_what")])
        self._height = max(12, round(height / _LINES_PER_HEIGHT))
        self._lettering = bake_atlas(self._height)
        baked = self._lettering.coverage
        self._atlas = ctx.texture((baked.shape[1], baked.shape[0]), 1, baked.tobytes(), alignment=1)
        self._atlas.filter = (moderngl.NEAREST, moderngl.NEAREST)
        set_uniform(self._program, "atlas", 1)

    def draw(self, points: Sequence[Point], chosen: int, lines: tuple[str, ...], target: moderngl.Framebuffer) -> None:
        """Draw marks at `points` [shares of the window], one of them chosen, and lines of text over `target`."""
        size = target.viewport[2:]
        marks = np.concatenate([self._panel(lines, size), self._points(points, chosen, size)])[:_MAX_MARKS]
        self._buffer.write(np.ascontiguousarray(marks, np.float32))
        set_uniform(self._program, "window_size", size)
        target.use()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._ctx.enable(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._atlas.use(1)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=len(marks))
        self._ctx.disable(moderngl.BLEND)

    def _points(self, points: Sequence[Point], chosen: int, size: tuple[int, int]) -> Float32:
        radius = _RADIUS * size[1]
        marks = np.zeros((len(points), 8), np.float32)
        place = np.array(points, np.float32).reshape(-1, 2) * size
        inside = np.clip(place, 0.7 * radius, np.array(size) - 0.7 * radius)  # a corner outside can be grabbed
        marks[:, 0:2], marks[:, 2:4] = inside - radius, 2.0 * radius
        marks[:, 6] = 2.0
        if 0 <= chosen < len(marks):
            marks[chosen, 7] = 1.0
        return marks

    def _panel(self, lines: tuple[str, ...], size: tuple[int, int]) -> Float32:
        """Return a panel with lines of text in the lower part of the window."""
        if not lines:
            return np.zeros((0, 8), np.float32)
        cell, inset = self._lettering.cell, 0.6 * self._height
        wide = max(self._lettering.width(line) for line in lines) + 2.0 * inset
        tall = len(lines) * cell[1] + 2.0 * inset
        x, y = round(0.5 * (size[0] - wide)), round(0.68 * size[1])
        letters = self._lettering.lay_out(lines, (round(x + inset), round(y + inset)), _MAX_LETTERS)
        marks = np.zeros((len(letters) + 1, 8), np.float32)
        marks[0, :4] = x, y, wide, tall
        marks[1:, 0:2], marks[1:, 2:4] = letters[:, 0:2], cell
        marks[1:, 4:6], marks[1:, 6] = letters[:, 2:4], 1.0
        return marks

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._atlas, self._program)
