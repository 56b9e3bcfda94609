"""Headless rendering: an OpenGL context without a screen, an offscreen target, and asynchronous frame readback."""

from typing import Any

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.system.features import OFFSCREEN_GL

Picture = npt.NDArray[np.uint8]


class FrameReader:
    """Reads frames of one size (width, height) through two pixel buffers, so that nothing waits for the GPU.

    Pictures are uint8 RGB of shape (height, width, 3), with `alpha` RGBA of four channels, the top row first. They are
    views of an internal array and valid until the next call; copy a picture to keep it. A framebuffer of another size
    (a window resized during filming) is cropped or padded from the upper left corner; the padding is black and
    transparent.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], *, alpha: bool = False) -> None:
        width, height = size
        if width < 1 or height < 1:
            raise ValueError(f"a picture of {width}x{height} pixels cannot be read")
        self.size = size
        self._channels = 4 if alpha else 3
        self._buffers = [ctx.buffer(reserve=width * height * self._channels) for _ in range(2)]
        self._filled: list[tuple[int, int] | None] = [None, None]
        self._turn = 0
        self._pixels: Picture = np.zeros((height, width, self._channels), np.uint8)

    def push(self, framebuffer: moderngl.Framebuffer) -> Picture | None:
        """Start reading the frame just drawn; return the previous one (None the first time)."""
        self._start(framebuffer)
        self._turn = 1 - self._turn
        return self._finish()

    def flush(self) -> Picture | None:
        """Return the last picture that was pushed and not yet returned, or None."""
        self._turn = 1 - self._turn
        return self._finish()

    def read(self, framebuffer: moderngl.Framebuffer) -> Picture:
        """Return the frame just drawn; this waits for the GPU."""
        self._start(framebuffer)
        picture = self._finish()
        assert picture is not None
        return picture

    def release(self) -> None:
        """Free the pixel buffers."""
        for buffer in self._buffers:
            buffer.release()

    def _start(self, framebuffer: moderngl.Framebuffer) -> None:
        there: Any = framebuffer.viewport  # only the viewport has the true size of a window's framebuffer
        left, bottom, width, height = there
        columns, rows = min(width, self.size[0]), min(height, self.size[1])
        corner = (left, bottom + height - rows, columns, rows)
        framebuffer.read_into(self._buffers[self._turn], viewport=corner, components=self._channels, alignment=1)
        self._filled[self._turn] = (columns, rows)

    def _finish(self) -> Picture | None:
        filled = self._filled[self._turn]
        if filled is None:
            return None
        self._filled[self._turn] = None
        if filled == self.size:
            self._buffers[self._turn].read_into(self._pixels)
            return self._pixels[::-1]  # OpenGL's first row is the lowest
        columns, rows = filled
        part = np.frombuffer(self._buffers[self._turn].read(size=columns * rows * self._channels), np.uint8)
        self._pixels.fill(0)
        upright = self._pixels[::-1]
        upright[:rows, :columns] = part.reshape(rows, columns, self._channels)[::-1]
        return upright


_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "basic render")


class NoOpenGL(RuntimeError):
    """There is no headless OpenGL 4.1; the message states the cause and the remedy."""


def create_headless_context() -> moderngl.Context:
    """Create an OpenGL 4.1 context without a screen (EGL on Linux), on the graphics card or in software.

    Raises `NoOpenGL`.
    """
    try:
        return moderngl.create_context(require=410, standalone=True, **OFFSCREEN_GL)
    except Exception as error:  # moderngl raises bare Exceptions
        raise NoOpenGL(
            f"no OpenGL 4.1 without a screen: {error}; install EGL and OpenGL "
            "(Debian, Ubuntu: apt-get install --no-install-recommends libegl1 libgl1; "
            "Fedora: dnf install mesa-libEGL mesa-libGL mesa-dri-drivers), which no package of pip brings; "
            "motion needs none: `live render --out show.glb` writes the dancers for other programs, and "
            "`live play --headless` plays without a picture"
        ) from error


def release_headless_context(ctx: moderngl.Context) -> None:
    """Release the context, and leave none current: while an EGL context is current, opening a GLX window in this thread
    makes Xlib end the whole process."""
    with ctx:  # restores the previous context
        pass
    ctx.release()


def is_software_name(renderer: str) -> bool:
    """Whether this name of a renderer (OpenGL's GL_RENDERER) is that of a software renderer."""
    renderer = renderer.casefold()
    return any(word in renderer for word in _SOFTWARE)


def is_software(ctx: moderngl.Context) -> bool:
    """Whether OpenGL renders in software, so that expensive passes can be left out."""
    return is_software_name(str(ctx.info["GL_RENDERER"]))


class OffscreenTarget:
    """A framebuffer (RGBA of 8 bits, depth) of `size` (width, height) [pixels] with its reader."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], *, alpha: bool = False) -> None:
        """`alpha`: pictures are RGBA. Raises ValueError for a size that this driver cannot draw."""
        limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
        if not all(1 <= length <= limit for length in size):
            raise ValueError(f"a picture of {size[0]}x{size[1]} pixels cannot be drawn: 1 to {limit} each way")
        self.size = size
        self._colour = ctx.renderbuffer(size, 4)
        self._depth = ctx.depth_renderbuffer(size)
        self.framebuffer: moderngl.Framebuffer = ctx.framebuffer([self._colour], self._depth)
        self._reader = FrameReader(ctx, size, alpha=alpha)

    def push(self) -> Picture | None:
        """Start reading the frame just drawn; return the previous one (see `FrameReader.push`)."""
        return self._reader.push(self.framebuffer)

    def flush(self) -> Picture | None:
        """Return the last frame that was pushed and not yet returned, or None."""
        return self._reader.flush()

    def read(self) -> Picture:
        """Return the frame just drawn: uint8 RGB (height, width, 3), top row first, valid until the next call."""
        return self._reader.read(self.framebuffer)

    def release(self) -> None:
        """Free everything."""
        self._reader.release()
        for thing in (self.framebuffer, self._colour, self._depth):
            thing.release()
