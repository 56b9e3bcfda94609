"""Flash meter: luminance and red of a picture's cells, read back without waiting, or at once where that matters."""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.render.gl_release import release_all
from live.render.outputs.flash_limit import RED_CHANGE, FlashLimit
from live.render.shader import program, set_uniform

CELLS: Final = (16, 9)
"""Across and down."""

Float64 = npt.NDArray[np.float64]


class FlashMeter:
    """Measures pictures; GL objects are made here."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = program(ctx, "bare_vertex.glsl", "flash_fragment.glsl")
        set_uniform(self._program, "picture", 1)
        set_uniform(self._program, "cells", CELLS)
        self._triangle = ctx.vertex_array(self._program, [])
        self._texture = ctx.texture(CELLS, 2, dtype="f4")
        self._target = ctx.framebuffer([self._texture])
        self._size = CELLS[0] * CELLS[1] * 8
        self._buffers = [ctx.buffer(reserve=self._size) for _ in range(2)]
        self._turn = 0

    def measure(self, picture: moderngl.Texture) -> None:
        """Begin to measure a picture."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._target.use()
        picture.use(1)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._turn = 1 - self._turn
        self._target.read_into(self._buffers[self._turn], components=2, dtype="f4", alignment=1)

    def before(self) -> Float64:
        """Luminance and saturated red, 0 to 1, of the cells of the picture before the one measured last, (2, 144)."""
        return self._read(self._buffers[1 - self._turn])

    def now(self) -> Float64:
        """Of the one measured last; this waits until it is drawn."""
        return self._read(self._buffers[self._turn])

    def _read(self, buffer: moderngl.Buffer) -> Float64:
        return np.frombuffer(buffer.read(size=self._size), np.float32).reshape(-1, 2).T.astype(np.float64)

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self._texture, *self._buffers, self._triangle, self._program)


class FlashGuard:
    """Says how much of its light each picture may have. Only where much flashes does it wait for the card."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._meter = FlashMeter(ctx)
        count = CELLS[0] * CELLS[1]
        self.limits = FlashLimit(count), FlashLimit(count, change=RED_CHANGE, dark=np.inf)
        """Of luminance, and of saturated red."""
        self.held = 0
        """Pictures whose light was held back."""
        self._open: float | None = None  # the time of a picture that was shown and not judged yet

    def left(self, picture: moderngl.Texture, time: float) -> float:
        """The share of light, 0 to 1, at which this picture may be shown at `time` [s]."""
        self._meter.measure(picture)
        if self._open is not None:
            for limit, cells in zip(self.limits, self._meter.before(), strict=True):
                limit.show(self._open, cells)
            self._open = None
        for limit in self.limits:
            limit.rises(time)
        if not any(limit.is_watching for limit in self.limits):
            self._open = time
            return 1.0
        now = self._meter.now()
        left = min(limit.most(time, cells) for limit, cells in zip(self.limits, now, strict=True))
        for limit, cells in zip(self.limits, now, strict=True):
            limit.show(time, cells * left)
        self.held += left < 1.0
        return left

    def rest(self) -> None:
        """Nobody wants to know: the next picture is the first one again."""
        self._open = None

    def release(self) -> None:
        """Free everything."""
        self._meter.release()
