"""Screens: each draws the rendered frame, or a test card, for one output into its window.

Frames are double-buffered: if drawing fails, the last complete frame stays.
"""

from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np
import numpy.typing as npt

from live.render.camera import PicturePart, Size
from live.render.outputs.output import FULL_WINDOW, Output, Point
from live.render.outputs.output_coordinates import window_to_picture
from live.render.outputs.output_pass import HandlePass, OutputPass
from live.render.outputs.test_card import Card
from live.render.outputs.warp_editor import FloorEditor, WarpEditor
from live.render.shader import release_all
from live.render.window.window import Window


class FrameBuffers:
    """Double buffer of rendered frames, whole or of a part. GL objects are created here and in `resize`."""

    def __init__(self, ctx: moderngl.Context, size: Size | PicturePart) -> None:
        self.ctx = ctx
        self._last = 0
        self._make(PicturePart.of(size))

    def _make(self, part: PicturePart) -> None:
        self.part = part
        """The part of the picture that they hold."""
        self.size = size = part.size
        """Width and height [pixels]."""
        self._textures = [self.ctx.texture(size, 4) for _ in range(2)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._framebuffers = [self.ctx.framebuffer([texture]) for texture in self._textures]
        for framebuffer in self._framebuffers:
            framebuffer.clear(0.0, 0.0, 0.0, 1.0)

    @property
    def next(self) -> moderngl.Framebuffer:
        """The framebuffer for the next frame."""
        return self._framebuffers[1 - self._last]

    def swap(self) -> None:
        """Swap the buffers after a complete frame was drawn into `next`."""
        self._last = 1 - self._last

    @property
    def last(self) -> moderngl.Framebuffer:
        """The last complete frame."""
        return self._framebuffers[self._last]

    @property
    def texture(self) -> moderngl.Texture:
        """The last complete frame as a texture."""
        return self._textures[self._last]

    def resize(self, size: Size | PicturePart) -> None:
        """Set the size [pixels] or the part; both buffers become black."""
        self.release()
        self._make(PicturePart.of(size))

    def release(self) -> None:
        """Free everything."""
        release_all(*self._framebuffers, *self._textures)


class Screen:
    """Draws the rendered frame into one window. Thread: main thread only, as GLFW requires."""

    def __init__(self, output: Output, window: Window, number: int, *, keep_aspect: bool = False) -> None:
        """`number`: of the output, from 0. `keep_aspect`: keep the ratio with black bars, for an operator's window.
        Raises PersonError for a mask that cannot be read."""
        self.output, self.window = output, window
        self.card: Card = "off"
        """The test card that is shown."""
        self.tick = -1
        """The tick that a render node presents, for its cards; negative: this is no node."""
        self._keeps_aspect = keep_aspect
        self._join_card: npt.NDArray[np.uint8] | None = None
        self._fitted: tuple[Any, ...] = ()
        window.make_current()
        self._number, self._detail = number, f"{window.size[0]} x {window.size[1]}   {window.monitor.name}"
        if output.node:
            self._detail += f"   node {output.node}"
        self._pass = self._make_pass()
        self._shared_textures: dict[int, moderngl.Texture] = {}
        self.editing: WarpEditor | FloorEditor | None = None
        """The editor of its points while they are moved; else None."""
        self.lines: tuple[str, ...] = ()
        """Lines of text over the window while it is edited."""
        self._handles: HandlePass | None = None

    def _make_pass(self) -> OutputPass:
        return OutputPass(self.window.ctx, self.output, self._number, self._detail)

    def set(self, output: Output) -> None:
        """Use the settings of `output` from now on."""
        self.output = output
        self.window.make_current()
        self._pass.set(output)

    def edit(self, enabled: bool) -> None:
        """Start or end manual editing of corners and mesh."""
        self._begin(WarpEditor(self.output) if enabled else None)

    def edit_floor(self, corners: Sequence[Point]) -> None:
        """Start marking the corners of the real floor; `corners`: their present places, as shares of the frame."""
        self._begin(FloorEditor(self.output, corners))

    def _begin(self, editing: WarpEditor | FloorEditor | None) -> None:
        self.editing = editing
        if editing is not None and self._handles is None:
            self.window.make_current()
            self._handles = HandlePass(self.window.ctx, self.window.size[1])

    def set_join_card(self, image: npt.NDArray[np.uint8]) -> None:
        """Set the join card of the audience (QR code)."""
        self._join_card = image
        self.window.make_current()
        self._pass.set_join_card(image)

    def reload_shaders(self) -> None:
        """Reload the shaders. Raises PersonError if one does not compile; the old ones then stay in use."""
        self.window.make_current()
        made = self._make_pass()
        self._pass.release()
        self._pass = made
        self._pass.set(self.output)
        if self._join_card is not None:
            self._pass.set_join_card(self._join_card)
        self._fitted = ()

    def forget_textures(self) -> None:
        """Drop the references to shared textures, before the frame buffers are created again."""
        self._shared_textures.clear()  # this context does not own them

    def draw(self, pictures: FrameBuffers, light_share: float) -> None:
        """Draw the last frame into the window, whose context must be current. `light_share`: see `OutputPass.draw`."""
        target: Any = self.window.target
        self._draw_output(pictures, target, light_share)
        if self.editing is not None and self._handles is not None:
            self._handles.draw(self.editing.points, self.editing.chosen, self.lines, target)

    def warm_up(self, pictures: FrameBuffers) -> None:
        """Draw everything once off screen, so that drivers compile their programs."""
        scratch = self.window.ctx.texture((16, 16), 4)
        target = self.window.ctx.framebuffer([scratch])
        for card in ("off", "grid"):
            self._pass.draw(self._texture(pictures), target, card=card)
        target.release()
        scratch.release()

    def _draw_output(self, pictures: FrameBuffers, target: Any, left: float) -> None:
        untouched = self.output.is_plain and self.card == "off" and left >= 1.0 and pictures.size == self.window.size
        if untouched and pictures.ctx is self.window.ctx:
            self.window.ctx.copy_framebuffer(target, pictures.last)
            return
        if self._keeps_aspect and self._fitted != (self.window.size, pictures.size):
            self._fitted = (self.window.size, pictures.size)
            self.set(Output(self.output.name, corners=_letterbox_corners(self.window.size, pictures.size)))
        picture = self._texture(pictures)
        self._pass.draw(picture, target, card=self.card, light_share=left, tick=self.tick, part=pictures.part)

    def _texture(self, pictures: FrameBuffers) -> moderngl.Texture:
        """Return the last frame as a texture of this window's context."""
        texture = pictures.texture
        if pictures.ctx is self.window.ctx:
            return texture
        if texture.glo not in self._shared_textures:
            self._shared_textures[texture.glo] = self.window.ctx.external_texture(texture.glo, texture.size, 4, 0, "f1")
        return self._shared_textures[texture.glo]

    def to_picture(self, place: tuple[float, float], picture: tuple[int, int]) -> tuple[float, float]:
        """Return the place of a window pixel in a frame of size `picture` [pixels]."""
        window = self.window.size
        x, y = window_to_picture(self.output, (place[0] / window[0], place[1] / window[1]))
        return x * picture[0], y * picture[1]

    def release(self) -> None:
        """Free everything; the window stays."""
        self.window.make_current()
        self._pass.release()
        if self._handles is not None:
            self._handles.release()


def _letterbox_corners(window: tuple[int, int], picture: tuple[int, int]) -> tuple[Point, Point, Point, Point]:
    """Return the corners at which a frame keeps its aspect ratio in a window."""
    share = (window[0] * picture[1]) / (window[1] * picture[0])
    across, down = (1.0 / share, 1.0) if share > 1.0 else (1.0, share)
    x, y = 0.5 - 0.5 * across, 0.5 - 0.5 * down
    if (x, y) == (0.0, 0.0):
        return FULL_WINDOW
    return (x, y), (1.0 - x, y), (1.0 - x, 1.0 - y), (x, 1.0 - y)
