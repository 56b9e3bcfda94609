"""Projection: a show's picture in all its windows: drawn once, then thrown by every output, and seen by the operator.

The renderer belongs to the first output's context; the other windows share its textures. A picture that cannot be
drawn to its end leaves the last one on the projectors. Only the first display paces the show.

Shown: the whole picture as the projectors show it together, for who takes it elsewhere: films, other programs.

It is not cropped, bent, blended or masked, and no test card is in it; but its light is held back where theirs is.
"""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import Scene, StageView
from live.render.gl_release import release_all
from live.render.outputs.output import Output
from live.render.outputs.output_pass import OutputPass
from live.render.outputs.photosensitivity import FlashGuard
from live.render.outputs.screen import Pictures, Screen, picture_size
from live.render.renderer import Renderer
from live.render.window.monitors import Monitor, find_place
from live.render.window.window import Window
from live.render.window.window_input import PointerMoved, PointerPressed, PointerReleased, WindowInput


class Shown:
    """Costs nothing while nothing flashes; GL objects are made here, and when the picture has another size."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._ctx = ctx
        self._pass = OutputPass(ctx, Output())
        self._make(size)

    def _make(self, size: tuple[int, int]) -> None:
        self._texture = self._ctx.texture(size, 4)
        self._target = self._ctx.framebuffer([self._texture])

    def of(self, pictures: Pictures, left: float) -> moderngl.Framebuffer:
        """The last picture with so much of its light left."""
        if left >= 1.0:
            return pictures.last
        if self._texture.size != pictures.size:
            release_all(self._target, self._texture)
            self._make(pictures.size)
        self._pass.draw(pictures.texture, self._target, left=left)
        return self._target

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self._texture, self._pass)


TITLE: Final = "ChoreoGraphics Live"
OPERATOR: Final = "operator"


@dataclass(frozen=True, slots=True)
class Places:
    """Which windows are opened, and where."""

    outputs: tuple[Output, ...] = (Output(),)
    """At least one."""
    monitor: Monitor | None = None
    """Where an output opens that names none."""
    operator: Monitor | None = None
    """Where the operator's own window opens; None: there is none, and the first output is the operator's, too."""
    size: tuple[int, int] = (1280, 720)
    """Of windows that are not full screen [screen coordinates]."""
    fullscreen: bool = False
    hidden: bool = False
    """Nobody sees the windows before they are revealed."""


class Projection:
    """All windows of a show with everything that draws into them. Thread: main thread only."""

    def __init__(self, scene: Scene, places: Places) -> None:
        """Raises NoWindow, UnknownMonitor, and PersonError for a mask that cannot be read."""
        self._closing = contextlib.ExitStack()
        try:
            self._open(scene, places)
        except BaseException:
            self._closing.close()
            raise

    def _open(self, scene: Scene, places: Places) -> None:
        self.screens: list[Screen] = []
        """One for each output, in their order."""
        for number, output in enumerate(places.outputs):
            self.screens.append(self._screen(output, places, number))
        self.window = self.screens[0].window
        """The first output's, whose context the renderer draws in."""
        self.operator: Screen | None = None
        """The operator's own window, if there is one."""
        if places.operator is not None:
            window = Window(
                f"{TITLE}: {OPERATOR}", monitor=places.operator, size=places.size, hidden=places.hidden,
                shares=self.window,
            )  # fmt: skip
            self._closing.callback(window.close)
            self.operator = Screen(Output(OPERATOR), window, 0, fits=True)
        self.window.make_current()
        self.pictures = Pictures(self.window.ctx, self._wanted_size())
        self._noted = None if self.operator is None else Pictures(self.window.ctx, self.pictures.size)
        self.renderer = Renderer(self.window.ctx, scene, size=self.pictures.size, steps=True)
        self.flashes = FlashGuard(self.window.ctx)
        """How much of its light each picture may have."""
        self._lifted, self._left = False, 1.0
        self._shown: Shown | None = None
        self._closing.callback(self._release)
        self._draw_once()

    def _draw_once(self) -> None:
        """Drivers compile a program when it first draws: better now than in the show."""
        for screen in self.all[::-1]:  # the first one last, whose context stays the current one
            screen.window.make_current()
            screen.draw_once(self.pictures)
        for time in (-2.0, -1.0):
            self.flashes.left(self.pictures.texture, time)
        self.flashes.rest()

    def _screen(self, output: Output, places: Places, number: int) -> Screen:
        """Open one output's window."""
        monitor = places.monitor if output.monitor is None else find_place(output.monitor)
        several = len(places.outputs) > 1
        window = Window(
            f"{TITLE}: {output.name}" if several else TITLE, monitor=monitor, fullscreen=places.fullscreen,
            size=places.size, hidden=places.hidden, shares=self.screens[0].window if self.screens else None,
        )  # fmt: skip
        self._closing.callback(window.close)
        return Screen(output, window, number)

    @property
    def all(self) -> Sequence[Screen]:
        """Every screen, the operator's last."""
        return self.screens if self.operator is None else [*self.screens, self.operator]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        return self.pictures.size

    @property
    def fullscreen(self) -> bool:
        """Whether the outputs are meant to be full screen."""
        return self.window.fullscreen

    def toggle_fullscreen(self) -> None:
        """All outputs full screen, or none; the operator's own window stays one."""
        before = self.fullscreen
        for screen in self.screens:
            if screen.window.fullscreen == before:
                screen.window.toggle_fullscreen()

    def poll(self) -> Iterator[tuple[Screen, WindowInput]]:
        """What people did at each window since the last call; never waits."""
        for screen in self.all:
            for value in screen.window.poll():
                yield screen, value

    def on_picture(self, screen: Screen, value: WindowInput) -> WindowInput:
        """An input with the pointer's place in pixels of the picture instead of the window's."""
        if isinstance(value, PointerMoved | PointerPressed | PointerReleased):
            x, y = screen.on_picture((value.x, value.y), self.size)
            return replace(value, x=x, y=y)
        return value

    def draw(self, view: StageView) -> None:
        """Draw the next picture; nobody sees it before `show`. With a window of the operator's own, overlay and guides
        are seen only there."""
        self.window.make_current()
        self._fit()
        self._lifted = view.flashes
        if self.operator is None or self._noted is None:
            self.renderer.draw(view, self.pictures.next)
            self.pictures.take()
            return
        overlay, guides = view.overlay, view.guide_count
        view.overlay, view.guide_count = (), 0
        try:
            self.renderer.draw(view, self.pictures.next)
        finally:
            view.overlay, view.guide_count = overlay, guides
        self.pictures.take()
        self.window.ctx.copy_framebuffer(self._noted.next, self.pictures.last)
        self.renderer.annotate(view, self._noted.next)
        self._noted.take()

    def take_sheet(self, sheet: npt.NDArray[np.uint8]) -> None:
        """The card that an audience joins by is this from now on: brightness, row 0 on top, shape (H, W)."""
        for screen in self.all[::-1]:
            screen.take_sheet(sheet)
        self.window.make_current()

    def take_shaders(self) -> None:
        """Draw with the shaders as they are now, see `Renderer.take_shaders`; PersonError if one is no program."""
        self.window.make_current()
        self.renderer.take_shaders()
        try:
            for screen in self.all[::-1]:
                screen.take_shaders()
        finally:
            self.window.make_current()

    def show(self, time: float) -> None:
        """Throw the last picture on every projector at `time` [s], with no more light than the flash limit leaves."""
        self._left = left = 1.0
        if self._lifted:
            self.flashes.rest()
        else:
            self._left = left = self.flashes.left(self.pictures.texture, time)
        others = self.all[1:]
        if others:
            self.window.ctx.finish()  # other contexts see only what is done
        for screen in others:
            screen.window.make_current()
            noted = screen is self.operator and self._noted is not None
            screen.draw(self._noted if noted and self._noted is not None else self.pictures, left)
            screen.window.swap()
        if others:
            self.window.make_current()
        self.screens[0].draw(self.pictures, left)
        self.window.swap()

    def prepare_shown(self) -> None:
        """Make what `shown` needs; before the show, if anybody will ask."""
        self._shown = Shown(self.window.ctx, self.pictures.size)

    def shown(self) -> moderngl.Framebuffer:
        """The whole picture that was thrown last, with the light that it had there, see `Shown`."""
        return self.pictures.last if self._shown is None else self._shown.of(self.pictures, self._left)

    def reveal(self, *, fullscreen: bool) -> None:
        """Show windows that were opened hidden."""
        for screen in self.screens:
            screen.window.reveal(fullscreen=fullscreen)
        if self.operator is not None:
            self.operator.window.reveal(fullscreen=False)

    def _wanted_size(self) -> tuple[int, int]:
        return picture_size([one.output for one in self.screens], [one.window.size for one in self.screens])

    def _fit(self) -> None:
        """Follow the windows' sizes."""
        size = self._wanted_size()
        if size == self.pictures.size:
            return
        for screen in self.all:
            screen.forget()
        self.pictures.resize(size)
        if self._noted is not None:
            self._noted.resize(size)
        self.renderer.resize(size)

    def _release(self) -> None:
        for screen in self.all:
            screen.release()
        self.window.make_current()
        self.flashes.release()
        if self._shown is not None:
            self._shown.release()
        self.renderer.release()
        self.pictures.release()
        if self._noted is not None:
            self._noted.release()

    def close(self) -> None:
        """Release what draws and close all windows."""
        self._closing.close()
