"""Drawing of crowds: what asking costs the processor, and what the graphics card needs by its own clock.

A thousand and ten thousand dancers in two dozen poses, side by side; no show is needed. Without a graphics card, its
rows have no figures. What a part costs is what a frame takes less without it.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import moderngl
import numpy as np

from live.base.stage_snapshot import Camera, Scene, StageView
from live.cli.bench import Row
from live.motion.quaternion import chain, from_rotation_vector
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.adaptive_quality import Quality, choose_quality
from live.render.camera import PicturePart, Size
from live.render.headless import OffscreenTarget, create_headless_context, is_software
from live.render.renderer import Renderer

LARGE = (1920, 1080)
SMALL = (16, 16)
"""A picture of next to no pixels."""
POSES = 24
BEND = 0.5
"""Standard deviation of the joints' angles in these poses [rad]."""
RASTERIZER_DISCARD = 0x8C89
Measured = tuple[float, float, float]
"""Seconds of a frame: by our clock, by the renderer's own, and of this process on all cores."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median times; the bars of the graphics card hold where there is one."""
    ctx = create_headless_context()
    frames = 60 if full else 24
    rows: list[Row] = []
    for dancers, on_card, asking in ((1000, 4.0, 0.3), (10_000, 12.0, None)):
        scene = Scene((60.0, 40.0), Camera(), dancers, JOINT_COUNT)
        view = repeated(posed_dancers(), dancers)
        rows += [*_card_rows(ctx, scene, view, frames, on_card), *_asking_rows(ctx, scene, view, frames, asking)]
    ctx.release()
    return rows


def _card_rows(ctx: moderngl.Context, scene: Scene, view: StageView, frames: int, bar: float) -> list[Row]:
    name = f"{scene.dancer_count} dancers at {LARGE[0]}x{LARGE[1]}: graphics card"
    if is_software(ctx):
        return [Row(name, None, "ms", bar, note="OpenGL draws on the processor here")]
    quality = choose_quality(ctx, scene.dancer_count)
    left_out = {f"without {name}": (*quality.left_out, name) for name in ("shadow", "mirror", "bloom")}
    peers = {
        what: _card_ms(ctx, scene, view, replace(quality, left_out=without), frames)
        for what, without in left_out.items()
    }
    peers["without multisampling of more than 2"] = _card_ms(ctx, scene, view, replace(quality, samples=2), frames)
    view.present[:] = False
    peers["nobody"] = _card_ms(ctx, scene, view, quality, frames)
    view.present[:] = True
    return [Row(name, _card_ms(ctx, scene, view, quality, frames), "ms", bar, peers=peers)]


def _card_ms(ctx: moderngl.Context, scene: Scene, view: StageView, quality: Quality, frames: int) -> float:
    """Median time of a frame by the graphics card's own clock [ms]."""
    with drawn(ctx, scene, LARGE, quality=quality) as (renderer, target):
        draw = partial(renderer.draw, view, target)
        return float(np.median([timed(ctx, draw)[1] for _ in range(frames)][3:])) * 1e3


def _asking_rows(ctx: moderngl.Context, scene: Scene, view: StageView, frames: int, bar: float | None) -> list[Row]:
    """What a frame costs the thread that draws, until all is asked for."""
    with drawn(ctx, scene, SMALL) as (renderer, target):
        asked = np.array([_asked(ctx, renderer, view, target) for _ in range(frames)])[3:]
        with empty_calls(ctx):
            bare = np.array([_asked(ctx, renderer, view, target) for _ in range(frames)])[3:]
        with empty_calls(ctx, drawing=False):
            ours = np.array([_asked(ctx, renderer, view, target) for _ in range(frames)])[3:]
    upload, drawing = (np.median(asked, axis=0) * 1e3).tolist()
    calls, without = (float(np.median(some[:, 1])) * 1e3 for some in (bare, ours))
    best = float(asked[:, 0].min()) * 1e3
    peers = {
        "calls": calls,
        "of them without the driver's draw calls": without,
        "best": best + float(bare[:, 1].min()) * 1e3,
        "upload of data that is in the cache": float(np.median(bare[:, 0])) * 1e3,
        "with what the driver draws within them": upload + drawing,
    }
    name = f"{scene.dancer_count} dancers: upload"
    return [
        Row(name, upload, "ms", peers={"best": best}),
        Row(f"{name} and calls", upload + calls, "ms", bar, peers=peers),
    ]


@contextmanager
def empty_calls(ctx: moderngl.Context, *, drawing: bool = True) -> Iterator[None]:
    """Every call of a frame is made as ever, but each draws three vertices of one instance, and the driver throws the
    triangle away before it becomes pixels (GL_RASTERIZER_DISCARD): a driver that draws on the processor has nothing to
    do within the calls that a graphics card would do after them. Without `drawing` the draw calls are left out, too."""
    render = moderngl.VertexArray.render

    def three(self: moderngl.VertexArray, mode: int | None = None, *args: object, **options: object) -> None:
        if drawing:
            render(self, mode, 3, instances=1)

    moderngl.VertexArray.render = three  # type: ignore[method-assign]
    ctx.enable_direct(RASTERIZER_DISCARD)
    try:
        yield
    finally:
        ctx.disable_direct(RASTERIZER_DISCARD)
        moderngl.VertexArray.render = render  # type: ignore[method-assign]


def posed_dancers() -> StageView:
    """So many dancers at the origin, in random poses that are the same each time."""
    random, view = np.random.default_rng(3), StageView.allocate(POSES, JOINT_COUNT)
    turns = random.normal(0.0, BEND, (POSES, JOINT_COUNT, 3))
    turns[:, 0] = 0.0
    turns[:, 0, 1] = random.uniform(-np.pi, np.pi, POSES)
    view.joint_position[:], view.joint_rotation[:] = chain(
        SKELETON.parents, SKELETON.offsets, from_rotation_vector(turns)
    )
    view.group[:] = np.arange(POSES) % 3
    return view


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
    ctx: moderngl.Context,
    scene: Scene,
    size: Size | PicturePart,
    *,
    steps: bool = False,
    quality: Quality | None = None,
) -> Iterator[tuple[Renderer, moderngl.Framebuffer]]:
    """A renderer and what it draws into."""
    renderer = Renderer(ctx, scene, size=size, steps=steps, quality=quality)
    target = OffscreenTarget(ctx, renderer.size)
    try:
        yield renderer, target.framebuffer
    finally:
        renderer.release()
        target.release()


def timed(ctx: moderngl.Context, draw: Callable[[], object]) -> Measured:
    """Seconds of a whole frame: by our clock, by the renderer's own, and of this process on all cores."""
    query = ctx.query(time=True)
    begin, worked = time.perf_counter(), time.process_time()
    with query:
        draw()
    ctx.finish()
    return time.perf_counter() - begin, query.elapsed * 1e-9, time.process_time() - worked


def _asked(
    ctx: moderngl.Context, renderer: Renderer, view: StageView, target: moderngl.Framebuffer
) -> tuple[float, float]:
    """Seconds of this thread until everything is handed over, and from then on until everything is asked for."""
    marks: list[float] = []
    renderer.mark = lambda part: marks.append(time.thread_time())
    begin = time.thread_time()
    renderer.draw(view, target)
    end = time.thread_time()
    ctx.finish()
    return marks[0] - begin, end - marks[0]
