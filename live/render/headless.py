"""Drawing without a screen: an OpenGL context through EGL and a target to draw into."""

import sys
from typing import Any

import moderngl

from live.render.readback import FrameReader, Picture

_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "basic render")


class NoOpenGL(RuntimeError):
    """No OpenGL 4.1 without a screen; the text says why and what can be done."""


def create_headless_context() -> moderngl.Context:
    """An OpenGL 4.1 context that needs no screen (EGL on Linux), on the graphics card or in software.

    Raises `NoOpenGL`.
    """
    settings: dict[str, Any] = {"backend": "egl"} if sys.platform == "linux" else {}
    try:
        return moderngl.create_context(require=410, standalone=True, **settings)
    except Exception as error:  # moderngl raises bare Exceptions
        raise NoOpenGL(
            f"no OpenGL 4.1 without a screen: {error}; install EGL and OpenGL "
            "(Debian, Ubuntu: apt-get install --no-install-recommends libegl1 libgl1; "
            "Fedora: dnf install mesa-libEGL mesa-libGL mesa-dri-drivers)"
        ) from error


def release_headless_context(ctx: moderngl.Context) -> None:
    """Give it back, and let no context be the current one: while one of EGL is, this thread can open no window with
    GLX, and Xlib ends the whole process over it."""
    with ctx:  # what was current before it is so again
        pass
    ctx.release()


def is_software(ctx: moderngl.Context) -> bool:
    """Whether the processor does the drawing: passes that are dear there can be left out."""
    renderer = str(ctx.info["GL_RENDERER"]).casefold()
    return any(word in renderer for word in _SOFTWARE)


class OffscreenTarget:
    """A framebuffer (RGBA of 8 bits, depth) of `size` (width, height) [pixels] with its reader."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], *, alpha: bool = False) -> None:
        """`alpha`: pictures are RGBA. ValueError for a size that this driver cannot draw."""
        limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
        if not all(1 <= length <= limit for length in size):
            raise ValueError(f"a picture of {size[0]}x{size[1]} pixels cannot be drawn: 1 to {limit} each way")
        self.size = size
        self._colour = ctx.renderbuffer(size, 4)
        self._depth = ctx.depth_renderbuffer(size)
        self.framebuffer: moderngl.Framebuffer = ctx.framebuffer([self._colour], self._depth)
        self._reader = FrameReader(ctx, size, alpha=alpha)

    def push(self) -> Picture | None:
        """Start to read the frame just drawn, return the one before it (see `FrameReader.push`)."""
        return self._reader.push(self.framebuffer)

    def flush(self) -> Picture | None:
        """The last frame pushed and not yet returned."""
        return self._reader.flush()

    def read(self) -> Picture:
        """The frame just drawn, at once: uint8 RGB (height, width, 3), top row first, good until the next call."""
        return self._reader.read(self.framebuffer)

    def release(self) -> None:
        """Give everything back to the card."""
        self._reader.release()
        for thing in (self.framebuffer, self._colour, self._depth):
            thing.release()
