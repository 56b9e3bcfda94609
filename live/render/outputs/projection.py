"""Projection of a show: renders each frame, or the part of it that is shown, once and draws it to all output windows
and the operator's window.

The renderer belongs to the first output's context; the other windows share its textures. If rendering fails, the
projectors keep the last complete frame. Only the first display paces the show.
"""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.picture_parameters import picture_row
from live.base.stage_snapshot import Scene, StageView
from live.render.camera import PicturePart, Size
from live.render.headless import FrameReader, Picture
from live.render.outputs.output import Output
from live.render.outputs.output_pass import OutputPass
from live.render.outputs.photosensitivity import FlashLimiter
from live.render.outputs.picture_layout import (
    WORTH,
    drawn_part,
    picture_reach,
    picture_size,
    shown_share,
    whole_picture_reason,
)
from live.render.outputs.screen import FrameBuffers, Screen
from live.render.renderer import Renderer
from live.render.shader import release_all
from live.render.window.monitors import Monitor, resolve_monitor
from live.render.window.window import Window
from live.render.window.window_input import PointerMoved, PointerPressed, PointerReleased, WindowInput


class OutputFrame:
    """The whole frame as projected, for films and other programs: without crop, warp, soft edge, mask or test card, but
    dimmed by the flash limit. Costs nothing while no light is limited. GL objects are created here and for a new size.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._ctx = ctx
        self._pass = OutputPass(ctx, Output())
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._texture = self._ctx.texture(size, 4)
        self._target = self._ctx.framebuffer([self._texture])

    def render(self, pictures: FrameBuffers, left: float) -> moderngl.Framebuffer:
        """Return the last frame with `left` of its light."""
        if left >= 1.0:
            return pictures.last
        if self._texture.size != pictures.size:
            release_all(self._target, self._texture)
            self._make(pictures.size)
        self._pass.draw(pictures.texture, self._target, light_share=left)
        return self._target

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self._texture, self._pass)


COPY_SIZE: Final = (384, 216)
"""Largest size of a copy [pixels]; it has the proportions of the picture."""


def fitted_size(width: int, height: int) -> tuple[int, int]:
    """Return the size of a copy of a picture of this size [pixels]: within `COPY_SIZE`, at least one pixel."""
    scale = min(COPY_SIZE[0] / width, COPY_SIZE[1] / height)
    return max(1, round(width * scale)), max(1, round(height * scale))


class PictureSampler:
    """Copies a picture when asked, and gives the copy a frame later.

    Thread: the one of the OpenGL context. GL objects are created here, and anew for a picture of another size.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        """`size`: width and height of the picture [pixels]."""
        self._ctx = ctx
        self._pass = OutputPass(ctx, Output())
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._size = size
        small = fitted_size(*size)
        self._texture = self._ctx.texture(small, 4)
        self._target = self._ctx.framebuffer([self._texture])
        self._reader = FrameReader(self._ctx, small)
        self._waits = False

    def start(self, framebuffer: moderngl.Framebuffer) -> None:
        """Begin to copy the picture that was drawn into a framebuffer with one texture."""
        texture = framebuffer.color_attachments[0]
        if not isinstance(texture, moderngl.Texture):
            return
        if texture.size != self._size:
            self._release_target()
            self._make(texture.size)
        self._pass.draw(texture, self._target)
        self._reader.push(self._target)
        self._waits = True

    def take(self) -> Picture | None:
        """Return the copy that was begun in an earlier frame: RGB, uint8, shape (height, width, 3), the top row first;
        None without one. It is a view, valid until the next call."""
        if not self._waits:
            return None
        self._waits = False
        return self._reader.flush()

    def _release_target(self) -> None:
        self._reader.release()
        release_all(self._target, self._texture)

    def release(self) -> None:
        """Free everything."""
        self._release_target()
        self._pass.release()


TITLE: Final = "ChoreoGraphics Live"
OPERATOR: Final = "operator"


@dataclass(frozen=True, slots=True)
class WindowLayout:
    """The windows to open, and their monitors."""

    outputs: tuple[Output, ...] = (Output(),)
    """At least one."""
    monitor: Monitor | None = None
    """The monitor of outputs that name none."""
    operator: Monitor | None = None
    """The monitor of the operator's window; None: no such window, the operator uses the first output."""
    size: tuple[int, int] = (1280, 720)
    """Size of windows that are not full screen [screen coordinates]."""
    fullscreen: bool = False
    hidden: bool = False
    """Whether windows stay hidden until `reveal`."""
    picture: Size | None = None
    """Width and height of the whole picture [pixels]; None: so that no output has to enlarge it."""
    whole_for: str = ""
    """Who needs the whole picture beside the outputs, in words; empty: only the part that they show is drawn."""


class Projection:
    """All windows of a show and what draws into them. Thread: main thread only."""

    def __init__(self, scene: Scene, layout: WindowLayout) -> None:
        """Raises NoWindow, UnknownMonitor, and PersonError for a mask that cannot be read."""
        self._closing = contextlib.ExitStack()
        try:
            self._open(scene, layout)
        except BaseException:
            self._closing.close()
            raise

    def _open(self, scene: Scene, places: WindowLayout) -> None:
        self.screens: list[Screen] = []
        """One for each output, in order."""
        for number, output in enumerate(places.outputs):
            self.screens.append(self._screen(output, places, number))
        self.window = self.screens[0].window
        """The first output's window, whose context the renderer uses."""
        self.operator: Screen | None = None
        """The operator's window, if there is one."""
        if places.operator is not None:
            window = Window(
                f"{TITLE}: {OPERATOR}", monitor=places.operator, size=places.size, hidden=places.hidden,
                share_with=self.window,
            )  # fmt: skip
            self._closing.callback(window.close)
            self.operator = Screen(Output(OPERATOR), window, 0, keep_aspect=True)
        self.window.make_current()
        self._places, self._row = places, picture_row(scene)
        self._whole_for = places.whole_for or ("" if self.operator is None else "the operator's window shows it")
        self.pictures = FrameBuffers(self.window.ctx, self._required_part(scene, self._row))
        self._operator_buffers = None if self.operator is None else FrameBuffers(self.window.ctx, self.pictures.size)
        self.renderer = Renderer(self.window.ctx, scene, size=self.pictures.part, steps=True)
        self.flash_limiter = FlashLimiter(self.window.ctx)
        """The flash limiter."""
        self._limit_bypassed, self._light_share = False, 1.0
        self._output_frame: OutputFrame | None = None
        self._closing.callback(self._release)
        self._warm_up()

    def _warm_up(self) -> None:
        """Draw everything once: drivers compile a program at its first draw, which would delay the show."""
        for screen in self.all_screens[::-1]:  # the first one last: its context has to stay current
            screen.window.make_current()
            screen.warm_up(self.pictures)
        for time in (-2.0, -1.0):
            self.flash_limiter.allowed_light(self.pictures.texture, time)
        self.flash_limiter.suspend()

    def _screen(self, output: Output, places: WindowLayout, number: int) -> Screen:
        """Open one output's window."""
        monitor = places.monitor if output.monitor is None else resolve_monitor(output.monitor)
        several = len(places.outputs) > 1
        window = Window(
            f"{TITLE}: {output.name}" if several else TITLE, monitor=monitor, fullscreen=places.fullscreen,
            size=places.size, hidden=places.hidden, share_with=self.screens[0].window if self.screens else None,
        )  # fmt: skip
        self._closing.callback(window.close)
        return Screen(output, window, number)

    @property
    def all_screens(self) -> Sequence[Screen]:
        """All screens, the operator's last."""
        return self.screens if self.operator is None else [*self.screens, self.operator]

    @property
    def size(self) -> Size:
        """Width and height of the whole picture [pixels], of which a part may be rendered."""
        whole = self.pictures.part.whole
        return round(whole[0]), round(whole[1])

    @property
    def fullscreen(self) -> bool:
        """Whether the outputs are full screen."""
        return self.window.fullscreen

    def toggle_fullscreen(self) -> None:
        """Toggle full screen for all outputs; the operator's window stays a window."""
        before = self.fullscreen
        for screen in self.screens:
            if screen.window.fullscreen == before:
                screen.window.toggle_fullscreen()

    def poll(self) -> Iterator[tuple[Screen, WindowInput]]:
        """Yield the inputs at each window since the last call; never waits."""
        for screen in self.all_screens:
            for value in screen.window.poll():
                yield screen, value

    def to_picture(self, screen: Screen, value: WindowInput) -> WindowInput:
        """Return an input with the pointer's place in pixels of the picture instead of the window."""
        if isinstance(value, PointerMoved | PointerPressed | PointerReleased):
            x, y = screen.to_picture((value.x, value.y), self.size)
            return replace(value, x=x, y=y)
        return value

    def draw(self, view: StageView) -> None:
        """Render the next frame, which becomes visible with `show`. Overlay and guides appear only in the operator's
        window, if there is one."""
        self.window.make_current()
        self._update_size(view)
        self._limit_bypassed = view.flash_limit_lifted
        if self.operator is None or self._operator_buffers is None:
            self.renderer.draw(view, self.pictures.next)
            self.pictures.swap()
            return
        overlay, guides = view.overlay, view.guide_count
        view.overlay, view.guide_count = (), 0
        try:
            self.renderer.draw(view, self.pictures.next)
        finally:
            view.overlay, view.guide_count = overlay, guides
        self.pictures.swap()
        self.window.ctx.copy_framebuffer(self._operator_buffers.next, self.pictures.last)
        self.renderer.annotate(view, self._operator_buffers.next)
        self._operator_buffers.swap()

    def set_join_card(self, image: npt.NDArray[np.uint8]) -> None:
        """Set the join card of the audience: brightness, row 0 on top, shape (H, W)."""
        for screen in self.all_screens[::-1]:
            screen.set_join_card(image)
        self.window.make_current()

    def reload_shaders(self) -> None:
        """Reload the shaders, see `Renderer.reload_shaders`. Raises PersonError if one does not compile."""
        self.window.make_current()
        self.renderer.reload_shaders()
        try:
            for screen in self.all_screens[::-1]:
                screen.reload_shaders()
        finally:
            self.window.make_current()

    def show(self, time: float) -> None:
        """Show the last frame on all outputs at `time` [s], dimmed by the flash limit."""
        self._light_share = left = 1.0
        if self._limit_bypassed:
            self.flash_limiter.suspend()
        else:
            self._light_share = left = self.flash_limiter.allowed_light(self.pictures.texture, time)
        others = self.all_screens[1:]
        if others:
            self.window.ctx.finish()  # other contexts see only completed drawing
        for screen in others:
            screen.window.make_current()
            noted = screen is self.operator and self._operator_buffers is not None
            screen.draw(self._operator_buffers if noted and self._operator_buffers is not None else self.pictures, left)
            screen.window.swap()
        if others:
            self.window.make_current()
        self.screens[0].draw(self.pictures, left)
        self.window.swap()

    def prepare_output_frame(self) -> None:
        """Create what `output_frame` needs; call it before the show if `output_frame` will be used."""
        self._output_frame = OutputFrame(self.window.ctx, self.pictures.size)

    def output_frame(self) -> moderngl.Framebuffer:
        """Return the last shown frame, whole and with its limited light, see `OutputFrame`."""
        return (
            self.pictures.last
            if self._output_frame is None
            else self._output_frame.render(self.pictures, self._light_share)
        )

    def reveal(self, *, fullscreen: bool) -> None:
        """Show windows that were opened hidden."""
        for screen in self.screens:
            screen.window.reveal(fullscreen=fullscreen)
        if self.operator is not None:
            self.operator.window.reveal(fullscreen=False)

    def _required_part(self, scene: Scene, row: Float64) -> PicturePart:
        """Return what has to be drawn of a scene with a parameter row. What once needs the whole picture gets it from
        then on: changing back and forth would stop the frame loop each time."""
        outputs, windows = [one.output for one in self.screens], [one.window.size for one in self.screens]
        asked = self._places.picture
        self._whole_for = self._whole_for or whole_picture_reason(scene, row)
        if self._whole_for:
            return PicturePart.of(picture_size(outputs, windows, asked=asked))
        return drawn_part(outputs, windows, lambda height: picture_reach(scene, height, row), asked=asked)

    @property
    def whole_for(self) -> str:
        """Why all of the picture is drawn though the outputs show less; empty if that is not so."""
        return self._whole_for if shown_share([one.output for one in self.screens]) <= WORTH else ""

    def describe_part(self) -> str:
        """Return which part of the picture is drawn, in words."""
        part, (width, height) = self.pictures.part, self.size
        if part.is_whole:
            return f"{width}x{height} pixels" + (f", all of them: {self.whole_for}" if self.whole_for else "")
        return f"{part.size[0]}x{part.size[1]} of {width}x{height} pixels"

    def _update_size(self, view: StageView) -> None:
        """Adapt what is drawn to the sizes of the windows and to what the picture needs."""
        size = self._required_part(self.renderer.scene, self._row if view.picture is None else view.picture)
        if size == self.pictures.part:
            return
        for screen in self.all_screens:
            screen.forget_textures()
        self.pictures.resize(size)
        if self._operator_buffers is not None:
            self._operator_buffers.resize(size.size)
        self.renderer.resize(size)

    def _release(self) -> None:
        for screen in self.all_screens:
            screen.release()
        self.window.make_current()
        self.flash_limiter.release()
        if self._output_frame is not None:
            self._output_frame.release()
        self.renderer.release()
        self.pictures.release()
        if self._operator_buffers is not None:
            self._operator_buffers.release()

    def close(self) -> None:
        """Release GL objects and close all windows."""
        self._closing.close()
