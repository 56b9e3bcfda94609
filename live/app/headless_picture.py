"""Offscreen picture of a show without a window, for films and other programs."""

from typing import TYPE_CHECKING

import moderngl

from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.base.stage_snapshot import Scene, StageView

if TYPE_CHECKING:
    from collections.abc import Callable


class HeadlessPicture:
    """An OpenGL context without a screen, and the renderer in it. Thread: the one that made it."""

    def __init__(self, options: LaunchOptions, scene: Scene) -> None:
        """Raise PersonError if there is no OpenGL."""
        from live.render.headless import NoOpenGL, create_headless_context
        from live.render.outputs.photosensitivity import FlashLimiter
        from live.render.outputs.projection import OutputFrame
        from live.render.outputs.screen import FrameBuffers
        from live.render.renderer import Renderer

        try:
            self.ctx = create_headless_context()
        except NoOpenGL as error:
            raise PersonError(str(error)) from None
        self._pictures, self.flashes = FrameBuffers(self.ctx, options.size), FlashLimiter(self.ctx)
        self._output = OutputFrame(self.ctx, options.size)
        self.renderer = Renderer(self.ctx, scene, size=options.size, steps=options.quality is not None)

    def draw(self, view: StageView, now: "Callable[[], float]") -> moderngl.Framebuffer:
        """Draw a picture and return it with flashes limited. `now` returns the show's time [s] after drawing."""
        self.renderer.draw(view, self._pictures.next)
        self._pictures.swap()
        if view.flash_limit_lifted:
            self.flashes.suspend()
        left = 1.0 if view.flash_limit_lifted else self.flashes.allowed_light(self._pictures.texture, now())
        return self._output.render(self._pictures, left)

    def close(self) -> None:
        """Release all resources."""
        from live.render.headless import release_headless_context

        for thing in (self.renderer, self._output, self.flashes, self._pictures):
            thing.release()
        release_headless_context(self.ctx)
