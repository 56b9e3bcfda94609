"""Drawing: frames at 1280x720 in the step of quality that a live show settles in, and styles.

Whole frames, finished before the clock is read, with what the graphics side needs by its own clock. Bars hold in the
step that the ladder of a live show chooses: `FrameBudget` and `Pacer` as in a window, at a live show's rate, dancers
dancing until no step has been taken for `SETTLED` seconds. A busy machine chooses a lower step and may miss them all
the same: `processor` is what all threads of this process computed for a frame, which other programs disturb less.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import moderngl
import numpy as np

from bench._show import crowd
from bench.render_crowd import drawn, timed
from live.app.film.live_recording import SOFTWARE_FPS
from live.base.arrays import Float64
from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import (
    BY_ADDRESS,
    STYLE_ADDRESS_PREFIX,
    STYLE_NAMES,
    group_parameter,
    picture_row,
)
from live.base.stage_snapshot import Scene, StageView
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.render.headless import OffscreenTarget, create_headless_context, is_software
from live.render.outputs.output import Output, SoftEdge
from live.render.outputs.output_pass import OutputPass
from live.render.outputs.photosensitivity import FlashLimiter
from live.render.outputs.picture_layout import drawn_part, picture_reach
from live.render.outputs.screen import FrameBuffers
from live.render.renderer import Renderer
from live.render.shader import release_all
from live.render.timing.frame_budget import FrameBudget
from live.render.timing.frame_stats import Pacer
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.show import Show
from live.show.view.render_scene import make_scene

SIZE = (1280, 720)
SETTLED, LONGEST = 6.0, 40.0
"""Seconds without a change of step, and in all, until a step counts as chosen."""
CARD_FPS = 60.0
MOST_TICKS = 30
"""Ticks that are made up for within a frame."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median time and rate for dancers dancing; the bars are those of this machine's kind of renderer."""
    ctx = create_headless_context()
    loaded = load_show(DEFAULT_PATCH)
    rows: list[Row] = []
    for dancers in (24, 50, 100, 200) if full else (50, 100):
        show = crowd(dancers, loaded)
        rows += _settled(ctx, show, f"{dancers} dancers", dancers, full)
    for name in WORLD_NAMES:
        look = loaded.patch.look.model_copy(update={"world": name})
        show = crowd(50, replace(loaded, patch=loaded.patch.model_copy(update={"look": look})))
        rows += _settled(ctx, show, f"50 dancers in {name}", 50, full=False)
    show = crowd(24, loaded)
    rows += _styles(ctx, show, make_scene(show.patch), full)
    rows += _parts(ctx, show, make_scene(show.patch), full)
    ctx.release()
    return rows


def _settled(ctx: moderngl.Context, show: Show, words: str, dancers: int, full: bool) -> list[Row]:
    """In the best step, and in the one that the ladder chooses."""
    software, view, scene = is_software(ctx), show.view(), make_scene(show.patch)
    bars = {50: 30.0, 100: 20.0} if software else {}
    _dance(show, view)
    with drawn(ctx, scene, SIZE, steps=True) as (renderer, target):

        def draw() -> None:
            renderer.draw(view, target)

        rows = [_row(f"{words}, best step", _frames(ctx, show, view, draw, full))]
        changes = _settle(show, view, renderer, draw, ctx, SOFTWARE_FPS if software else CARD_FPS)
        step, quality = renderer.step, renderer.quality
        name = f"{words}, step {step} of {len(renderer.steps) - 1}: {renderer.steps[step].name}"
        measured = _frames(ctx, show, view, draw, full)
        rows.append(_row(name, measured, bars.get(dancers)))
        passes = ", ".join(one for one in scene.passes if one not in quality.left_out)
        told = {
            "samples": quality.samples, "scale": quality.scale, "floor map": quality.floor_map,
            "far body from m": quality.far_from, "changes": changes,
        }  # fmt: skip
        rows.append(Row(f"{words}, passes left on there: {passes}", len(passes.split(", ")), "", peers=told))
        if full and dancers == 50:
            for number, one in enumerate(renderer.steps):
                renderer.set_step(number)
                rows.append(_row(f"{words} held at {number}: {one.name}", _frames(ctx, show, view, draw, full)))
    return rows


def _frames(
    ctx: moderngl.Context,
    show: Show,
    view: StageView,
    draw: Callable[[], object],
    full: bool,
    row: Float64 | None = None,
) -> Float64:
    """`Measured` of so many frames, shape (N, 3)."""
    times = []
    for _ in range(60 if full else 24):
        _dance(show, view, row=row)
        times.append(timed(ctx, draw))
    return np.array(times)[4:]


PARTS = (
    ("a quarter of 2560x1440", (2560, 1440), (0.5, 0.0, 0.5, 0.5), 0.65),
    ("an eighth of 5120x720", (5120, 720), (0.375, 0.0, 0.125, 1.0), 0.4),
)
"""What a render node draws of a picture: words, size of the whole one, crop, and the largest ratio of their times."""


def _parts(ctx: moderngl.Context, show: Show, scene: Scene, full: bool) -> list[Row]:
    """Processor time of the part that a node draws, with the border of all passes, over that of the whole picture."""
    rows, view = [], show.view()
    reach = partial(picture_reach, scene, row=picture_row(scene))
    for words, size, crop, bar in PARTS:
        part = drawn_part([Output(crop=crop)], [size], reach, asked=size)
        times: list[list[float]] = []
        with drawn(ctx, scene, size) as (whole, target), drawn(ctx, scene, part) as (own, own_target):
            pairs = (whole, target), (own, own_target)
            for _ in range(16 if full else 8):
                _dance(show, view)
                times.append([timed(ctx, partial(renderer.draw, view, into))[2] for renderer, into in pairs])
        each, alone = np.median(np.array(times)[2:], axis=0).tolist()
        rows.append(
            Row(f"24 dancers, {words} with its border over the whole", alone / each, "", bar,
                peers={"whole, ms": 1e3 * each, "part, ms": 1e3 * alone, "share of pixels": math.prod(part.share)})
        )  # fmt: skip
    return rows


def _dance(show: Show, view: StageView, ticks: int = 2, row: Float64 | None = None) -> None:
    for _ in range(ticks):
        show.tick(show.time + TICK)
    show.fill(view, show.time)
    view.picture = view.picture if row is None else row.copy()  # the next fill writes into it


def _row(name: str, measured: Float64, bar: float | None = None) -> Row:
    wall, card, processor = np.median(measured, axis=0).tolist()
    best, _, least = measured.min(axis=0).tolist()
    peers = {"frame ms": wall * 1e3, "renderer's own clock ms": card * 1e3, "processor ms": processor * 1e3}
    peers |= {"best frame ms": best * 1e3, "least processor ms": least * 1e3}
    return Row(f"{name}: rate", 1.0 / wall, "frames/s", bar, sense="at least", peers=peers)


def _settle(
    show: Show, view: StageView, renderer: Renderer, draw: Callable[[], None], ctx: moderngl.Context, fps: float
) -> int:
    """Dance in real time as a live show does until the ladder has found its step; returns how often it changed."""
    now = time.perf_counter
    pacer, watch = Pacer(fps, now, time.sleep), FrameBudget(renderer, now, 1.0 / fps)
    begun = previous = changed = now()
    step, ahead = renderer.step, show.time - begun
    while now() - changed < SETTLED and now() - begun < LONGEST:
        started = pacer.wait()
        watch.begin(pacer.late, started - previous)
        if renderer.step != step:
            step, changed = renderer.step, started
        previous = started
        due = round((started + ahead - show.time) / TICK)
        if due > MOST_TICKS:  # a show skips what it cannot make up for
            ahead -= (due - MOST_TICKS) * TICK
        watch.times.mark("events")
        _dance(show, view, min(max(due, 0), MOST_TICKS))
        watch.times.mark("simulation")
        draw()
        ctx.finish()  # as a window's swap does
        watch.times.mark("draw")
        watch.end()
    return watch.controller.changes


def _styles(ctx: moderngl.Context, show: Show, scene: Scene, full: bool) -> list[Row]:
    """24 dancers in each style and with each picture pass, in the best step; then what outputs add."""
    view, usual, groups = show.view(), picture_row(scene), range(len(show.patch.group))
    rows = []
    with drawn(ctx, scene, SIZE) as (renderer, target):

        def draw() -> None:
            renderer.draw(view, target)

        for name in STYLE_NAMES:
            row = usual.copy()
            for group in groups:
                row[group_parameter(STYLE_ADDRESS_PREFIX + "solid", group).row_slice] = float(
                    name in ("solid", "trails")
                )
                row[group_parameter(STYLE_ADDRESS_PREFIX + name, group).row_slice] = 1.0
            for _ in range(16 if name in ("ribbons", "trails") else 1):  # what leaves a trace has to be danced first
                _dance(show, view, 16, row)
                draw()
            rows.append(_row(f"24 dancers, {name}", _frames(ctx, show, view, draw, full, row)))
        for name in ("trails", "ink", "grade/contrast"):
            row = usual.copy()
            row[BY_ADDRESS[f"/dance/pass/{name}"].row_slice] = 1.1 if name == "grade/contrast" else 1.0
            rows.append(_row(f"24 dancers, pass {name}", _frames(ctx, show, view, draw, full, row)))
    return rows + _outputs(ctx, show, view, full)


def _outputs(ctx: moderngl.Context, show: Show, view: StageView, full: bool) -> list[Row]:
    """What comes after a picture that is there: the limit on flashes, and a bent output with soft edges."""
    pictures, target = FrameBuffers(ctx, SIZE), OffscreenTarget(ctx, SIZE)
    guard = FlashLimiter(ctx)
    corners = ((0.02, 0.03), (0.98, 0.0), (1.0, 1.0), (0.0, 0.97))
    bent = OutputPass(ctx, Output("bench", corners=corners, edge=SoftEdge(left=0.1, right=0.1)))
    rows = [
        _row(
            "flash limit alone",
            _frames(ctx, show, view, lambda: guard.allowed_light(pictures.texture, show.time), full),
        ),
        _row(
            "bent output alone", _frames(ctx, show, view, lambda: bent.draw(pictures.texture, target.framebuffer), full)
        ),
    ]
    release_all(bent, guard, target, pictures)
    return rows
