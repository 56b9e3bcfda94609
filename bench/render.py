"""Drawing: whole frames at 1280x720 on this machine's OpenGL, finished before the clock is read."""

import time
from pathlib import Path

import numpy as np

from bench._show import crowd
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.render.headless import OffscreenTarget, create_headless_context
from live.render.renderer import Renderer
from live.show.load import load_show
from live.show.patch_file import DEFAULT_PATCH
from live.show.scene_of import scene_of

SIZE = (1280, 720)


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median time and rate for 24, 50 and 200 dancers dancing; the bar is 30 frames/s for 50 in software."""
    loaded = load_show(DEFAULT_PATCH)
    ctx = create_headless_context()
    rows: list[Row] = []
    for dancers in (24, 50, 200) if full else (24, 50):
        show = crowd(dancers, loaded)
        renderer = Renderer(ctx, scene_of(show.patch), size=SIZE)
        target = OffscreenTarget(ctx, SIZE)
        view = show.view()
        times = []
        for frame in range(90 if full else 45):
            for tick in (2 * frame + 1, 2 * frame + 2):
                show.tick(tick * TICK)
            show.fill(view, show.time)
            begin = time.perf_counter()
            renderer.draw(view, target.framebuffer)
            ctx.finish()
            times.append(time.perf_counter() - begin)
        renderer.release()
        target.release()
        median = float(np.median(times[5:]))
        bar = 30.0 if dancers == 50 else None
        rows.append(Row(f"{dancers} dancers: rate", 1.0 / median, "frames/s", bar, sense="at least"))
        rows.append(Row(f"{dancers} dancers: frame, median", median * 1e3, "ms"))
    ctx.release()
    return rows
