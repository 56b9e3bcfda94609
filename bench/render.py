"""Drawing: whole frames at 1280x720 on this machine's OpenGL, finished before the clock is read; what the graphics
side needs by its own clock, and what the processor needs to ask for it."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import moderngl
import numpy as np

from bench._show import crowd
from live.base.stage_view import Scene, StageView
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.render.headless import OffscreenTarget, create_headless_context
from live.render.quality import is_software
from live.render.renderer import Renderer
from live.show.load import load_show
from live.show.patch_file import DEFAULT_PATCH
from live.show.scene_of import scene_of

SIZE = (1280, 720)
LARGE = (1920, 1080)
SMALL = (16, 16)
"""A picture of next to no pixels: what is left is the asking."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median time and rate for dancers dancing; the bars are those of this machine's kind of renderer."""
    ctx = create_headless_context()
    software = is_software(ctx)
    loaded = load_show(DEFAULT_PATCH)
    rows: list[Row] = []
    bars = {50: 30.0, 100: 20.0} if software else {}
    for dancers in (24, 50, 100, 200) if full else (24, 50, 100):
        show = crowd(dancers, loaded)
        view, scene = show.view(), scene_of(show.patch)
        times, gpu = [], []
        with drawn(ctx, scene, SIZE) as (renderer, target):
            for frame in range(90 if full else 45):
                for tick in (2 * frame + 1, 2 * frame + 2):
                    show.tick(tick * TICK)
                show.fill(view, show.time)
                wall, card = _timed(ctx, renderer, view, target)
                times.append(wall)
                gpu.append(card)
        median = float(np.median(times[5:]))
        rate = Row(f"{dancers} dancers: rate", 1.0 / median, "frames/s", bars.get(dancers), sense="at least")
        rows += [rate, Row(f"{dancers} dancers: frame, median", median * 1e3, "ms")]
        rows.append(Row(f"{dancers} dancers: by the renderer's own clock", float(np.median(gpu[5:])) * 1e3, "ms"))
    rows += _many(ctx, scene, view, 30 if full else 12, software=software)
    ctx.release()
    return rows


def _many(ctx: moderngl.Context, scene: Scene, dancing: StageView, frames: int, *, software: bool) -> list[Row]:
    """1,000 and 10,000 dancers: those that dance, again and again, side by side."""
    rows = []
    for dancers, bar in ((1000, 4.0), (10_000, 12.0)):
        wide = Scene((60.0, 40.0), scene.camera, scene.look, dancers, scene.joint_count)
        view = repeated(dancing, dancers)
        if not software:
            with drawn(ctx, wide, LARGE) as (renderer, target):
                gpu = [_timed(ctx, renderer, view, target)[1] for _ in range(frames)]
            rows.append(
                Row(f"{dancers} dancers at 1920x1080: graphics card", float(np.median(gpu[3:])) * 1e3, "ms", bar)
            )
        with drawn(ctx, wide, SMALL) as (renderer, target):
            upload = [_asked(ctx, renderer, view, target)[0] for _ in range(frames)]
            view.present[:] = False
            calls = [_asked(ctx, renderer, view, target)[1] for _ in range(frames)]
        ask = 1e3 * (float(np.median(upload[3:])) + float(np.median(calls[3:])))
        rows += [
            Row(f"{dancers} dancers: upload", 1e3 * float(np.median(upload[3:])), "ms"),
            Row(f"{dancers} dancers: upload and calls", ask, "ms", 0.5 if dancers == 1000 else None),
        ]
    return rows


def repeated(view: StageView, dancers: int) -> StageView:
    """So many dancers in the poses of `view`, on a grid."""
    some = len(view.group)
    of = np.arange(dancers) % some
    many = StageView.allocate(dancers, view.joint_position.shape[1])
    side = int(np.ceil(np.sqrt(dancers)))
    place = np.zeros((dancers, 1, 3), np.float32)
    place[:, 0, 0], place[:, 0, 2] = np.arange(dancers) % side - side / 2, -(np.arange(dancers) // side)
    many.joint_position[:] = view.joint_position[of] - view.joint_position[of, :1] * (1.0, 0.0, 1.0) + place
    many.joint_rotation[:] = view.joint_rotation[of]
    many.group[:] = view.group[of]
    return many


@contextmanager
def drawn(
    ctx: moderngl.Context, scene: Scene, size: tuple[int, int]
) -> Iterator[tuple[Renderer, moderngl.Framebuffer]]:
    """A renderer and what it draws into."""
    renderer, target = Renderer(ctx, scene, size=size), OffscreenTarget(ctx, size)
    try:
        yield renderer, target.framebuffer
    finally:
        renderer.release()
        target.release()


def _timed(
    ctx: moderngl.Context, renderer: Renderer, view: StageView, target: moderngl.Framebuffer
) -> tuple[float, float]:
    """Seconds of a whole frame by our clock, and by the renderer's."""
    query = ctx.query(time=True)
    begin = time.perf_counter()
    with query:
        renderer.draw(view, target)
    ctx.finish()
    wall = time.perf_counter() - begin
    return wall, query.elapsed * 1e-9


def _asked(
    ctx: moderngl.Context, renderer: Renderer, view: StageView, target: moderngl.Framebuffer
) -> tuple[float, float]:
    """Seconds until everything is handed over, and from then on until everything is asked for."""
    marks: list[float] = []
    renderer.mark = lambda part: marks.append(time.perf_counter())
    begin = time.perf_counter()
    renderer.draw(view, target)
    end = time.perf_counter()
    ctx.finish()
    return marks[0] - begin, end - marks[0]
