"""Flash limiter for photosensitive viewers: dims frames so that there are at most three flashes per second.

A general flash is a pair of opposing changes of luminance by 10 % of the maximum or more, where the darker level is
below 0.8, on more than a quarter of the picture (W3C, WCAG 2.2, "general flash and red flash thresholds";
ITU-R BT.1702). The picture is measured in cells; a rise beyond the limit is cut off just below the threshold. Falls
cannot be prevented, but each needs a rise before it.
"""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.render.shader import compile_program, release_all, set_uniform

CHANGE: Final = 0.1
"""Smallest change of luminance that counts."""
DARK: Final = 0.8
"""A change counts if its darker level is below this."""
RED_CHANGE: Final = 20.0 / 320.0
"""Smallest change of R - G - B of saturated red (R / (R + G + B) of 0.8 or more) that counts, at any brightness."""
RISE_SHARE: Final = 0.95
"""A rise is cut off at this share of the counting change, so that it does not count."""
AREA: Final = 0.25
"""Share of the picture that has to change."""
CHANGE_WINDOW: Final = 0.12
"""Cells that change within this time [s] count as one change."""
SECOND: Final = 1.0
MAX_RISES: Final = 3
"""Maximum number of rises in a second: each flash has one."""
WATCH_RISES: Final = 2
"""From this number of rises on, the luminance of a frame must be known before it is shown."""


class FlashLimit:
    """Computes the allowed light of successive frames. Deterministic for the same frames and times."""

    def __init__(self, cells: int, *, change: float = CHANGE, dark: float = DARK) -> None:
        """`cells`: number of cells of a frame; `change` and `dark`: thresholds, see `CHANGE` and `DARK`."""
        self._change, self._dark = change, dark
        self._low, self._high = np.full(cells, np.inf), np.full(cells, -np.inf)
        self._rising, self._falling = np.zeros(cells, np.bool_), np.zeros(cells, np.bool_)
        self._rose, self._fell = np.full(cells, -np.inf), np.full(cells, -np.inf)
        self._rises: list[float] = []
        self._last_was_rise: bool | None = None  # whether the last change was a rise
        self._last_change_time = -np.inf  # when that was
        self._max_changed_cells = max(int(np.ceil(AREA * cells)) - 1, 0)

    def rises(self, time: float) -> int:
        """Return the number of rises in the second before `time` [s]."""
        while self._rises and self._rises[0] <= time - SECOND + 1e-9:
            self._rises.pop(0)
        return len(self._rises)

    @property
    def is_watching(self) -> bool:
        """Whether there were so many rises lately that each frame must be measured before it is shown."""
        return len(self._rises) >= WATCH_RISES

    def max_light(self, time: float, luminance: Float64) -> float:
        """Return the maximum share of light, 0 to 1, at which a frame may be shown at `time` [s]."""
        return self._max_light(time, luminance) if self.rises(time) >= MAX_RISES else 1.0

    def record(self, time: float, shown: Float64) -> None:
        """Record a frame shown at `time` [s] with the luminance of its cells, 0 to 1, shape (cells,)."""
        self._update_cells(time, shown)

    def _max_light(self, time: float, luminance: Float64) -> float:
        """Return the maximum share of light at which too few cells rise for a counted change."""
        if self._last_was_rise:
            return 1.0  # it has risen already: more light is not another change
        free = max(self._max_changed_cells - int(np.count_nonzero(self._rose > time - CHANGE_WINDOW)), 0)
        dark = (self._low < self._dark) & ~self._rising
        share = np.where(dark, (self._low + RISE_SHARE * self._change) / np.maximum(luminance, 1e-9), np.inf)
        place = min(free, len(share) - 1)
        return float(min(np.partition(share, place)[place], 1.0))

    def _update_cells(self, time: float, shown: Float64) -> None:
        """Update the extremes and directions of all cells."""
        self._low, self._high = np.minimum(self._low, shown), np.maximum(self._high, shown)
        up = (shown - self._low >= self._change) & (self._low < self._dark) & ~self._rising
        down = (self._high - shown >= self._change) & (shown < self._dark) & ~self._falling
        for now, before, since, extreme in (
            (up, self._rising, self._rose, self._high),
            (down, self._falling, self._fell, self._low),
        ):
            before[now] = True
            since[now] = time
            extreme[now] = shown[now]
        self._falling[up], self._rising[down] = False, False
        self._count_change(time)

    def _count_change(self, time: float) -> None:
        """Count a change of the whole picture if enough cells have changed together in the opposite direction, all
        since the last change: a fall just before a rise is not one after it."""
        for rises, since in ((True, self._rose), (False, self._fell)):
            lately = (since > time - CHANGE_WINDOW) & (since >= self._last_change_time)
            if self._last_was_rise is not rises and np.count_nonzero(lately) > self._max_changed_cells:
                self._last_was_rise, self._last_change_time = rises, time
                if rises:
                    self._rises.append(time)


CELLS: Final = (16, 9)
"""Number of cells across and down."""


class FlashMeter:
    """Measures luminance and saturated red of a frame's cells on the GPU. GL objects are created here."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "bare_vertex.glsl", "flash_fragment.glsl")
        set_uniform(self._program, "picture", 1)
        set_uniform(self._program, "cells", CELLS)
        self._triangle = ctx.vertex_array(self._program, [])
        self._texture = ctx.texture(CELLS, 2, dtype="f4")
        self._target = ctx.framebuffer([self._texture])
        self._size = CELLS[0] * CELLS[1] * 8
        self._buffers = [ctx.buffer(reserve=self._size) for _ in range(2)]
        self._buffer_index = 0

    def measure(self, picture: moderngl.Texture) -> None:
        """Start measuring a frame; does not wait for the GPU."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._target.use()
        picture.use(1)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._buffer_index = 1 - self._buffer_index
        self._target.read_into(self._buffers[self._buffer_index], components=2, dtype="f4", alignment=1)

    def previous(self) -> Float64:
        """Return luminance and saturated red, 0 to 1, of the cells of the last frame but one, shape (2, 144)."""
        return self._read(self._buffers[1 - self._buffer_index])

    def current(self) -> Float64:
        """Return the same for the last measured frame; waits until it is drawn."""
        return self._read(self._buffers[self._buffer_index])

    def _read(self, buffer: moderngl.Buffer) -> Float64:
        return np.frombuffer(buffer.read(size=self._size), np.float32).reshape(-1, 2).T.astype(np.float64)

    def release(self) -> None:
        """Free everything."""
        release_all(self._target, self._texture, *self._buffers, self._triangle, self._program)


class FlashLimiter:
    """Decides how much of its light each frame may have. Waits for the GPU only when there are many flashes."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._meter = FlashMeter(ctx)
        count = CELLS[0] * CELLS[1]
        self.limits = FlashLimit(count), FlashLimit(count, change=RED_CHANGE, dark=np.inf)
        """For luminance, and for saturated red."""
        self.dimmed_count = 0
        """Number of dimmed frames."""
        self._unrecorded_time: float | None = None  # the time of a frame that was shown and not recorded yet

    def allowed_light(self, picture: moderngl.Texture, time: float) -> float:
        """Return the share of light, 0 to 1, at which this frame may be shown at `time` [s]."""
        self._meter.measure(picture)
        if self._unrecorded_time is not None:
            for limit, cells in zip(self.limits, self._meter.previous(), strict=True):
                limit.record(self._unrecorded_time, cells)
            self._unrecorded_time = None
        for limit in self.limits:
            limit.rises(time)
        if not any(limit.is_watching for limit in self.limits):
            self._unrecorded_time = time
            return 1.0
        now = self._meter.current()
        left = min(limit.max_light(time, cells) for limit, cells in zip(self.limits, now, strict=True))
        for limit, cells in zip(self.limits, now, strict=True):
            limit.record(time, cells * left)
        self.dimmed_count += left < 1.0
        return left

    def suspend(self) -> None:
        """Suspend the limit: the next frame counts as the first one."""
        self._unrecorded_time = None

    def release(self) -> None:
        """Free everything."""
        self._meter.release()
