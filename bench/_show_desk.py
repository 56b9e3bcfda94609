"""The desk: what fades and cues cost a tick, how late cues are, what a picture costs while light and camera move."""

import time
from typing import Final

import numpy as np

from bench._show import crowd
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context
from live.render.renderer import Renderer
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import PATCHES
from live.show.show import Show
from live.show.view.render_scene import make_scene

SHOW: Final = PATCHES / "cues" / "show.toml"
SIZE: Final = (1280, 720)
PRESSES: Final = 60
"""GOs by hand at seeded moments."""


def rows(full: bool) -> list[Row]:
    """Figures of the show of `patches/cues`."""
    loaded = load_show(SHOW)
    return [*_ticks(loaded.start()), _lateness(loaded, full), *_pictures(loaded, full)]


def _call(show: Show, address: str, *values: object) -> None:
    event = REGISTRY.call(address, values, show.time, "bench")
    if not isinstance(event, ControlEvent) or not show.apply(event):
        raise RuntimeError(f"{address} {values}: {event} {show.refusals.last_reason}")


def _ticks(show: Show) -> list[Row]:
    """The desk's part of a tick, while nothing fades and while everything does."""
    figures = {}
    for name in ("nothing fades", "everything fades"):
        if name == "everything fades":
            show.desk.parameters.fade(dict.fromkeys(range(show.desk.parameters.table.size), 0.5), beats=1e6)
        spent = []
        for _ in range(512):
            begin = time.perf_counter()
            show.desk.tick(show.clock.now(show.state.position))
            show.desk.fire(0.0, 0.0)
            spent.append(time.perf_counter() - begin)
        figures[name] = (float(np.median(spent)) * 1e3, float(np.percentile(spent, 99)) * 1e3)
    return [
        Row(f"desk in a tick, {name}: median", median, "ms", 0.2, peers={"p99": p99})
        for name, (median, p99) in figures.items()
    ]


def _lateness(loaded: LoadedShow, full: bool) -> Row:
    """GO at moments of chance: by how many ticks a cue comes after the one that holds its beat."""
    show, chance, fired = loaded.start(), np.random.default_rng(8), 0
    names = [cue.name for cue in loaded.patch.cue]
    tick = 0
    for _ in range(PRESSES * (4 if full else 1)):
        _call(show, "/dance/cue", names[int(chance.integers(len(names)))])
        for _ in range(int(chance.integers(8, 120))):
            tick += 1
            show.tick(tick * TICK)
        fired = show.desk.cues.fired
    return Row("cues: late at most", float(show.desk.cues.late_ticks_max), "ticks", 1.0, peers={"cues": float(fired)})


def _pictures(loaded: LoadedShow, full: bool) -> list[Row]:
    """A picture while light, or camera, moves, beside one that stands, drawn in turns; nothing without OpenGL."""
    try:
        ctx = create_headless_context()
    except NoOpenGL:
        return [Row("a picture while light moves", None, "x a standing one", 1.5)]
    show = crowd(24, loaded)
    renderer, target = Renderer(ctx, make_scene(show.patch), size=SIZE), OffscreenTarget(ctx, SIZE)
    view = show.view()
    row = view.picture
    assert row is not None
    table = show.desk.parameters.table
    moved = {"light": table.find("/dance/light/rim")[0].first, "camera": table.find("/dance/camera/eye")[0].first}
    spent: dict[str, list[float]] = {"standing": [], "light": [], "camera": []}
    for turn in range(60 if full else 20):
        show.fill(view, show.time)
        for name, times in spent.items():
            for frame in range(3):  # after a change the first two draw the backdrop: coarse, then fine
                if name in moved:
                    row[moved[name]] += 0.01
                begin = time.perf_counter()
                renderer.draw(view, target.framebuffer)
                ctx.finish()
                if frame == 2 and turn:
                    times.append(time.perf_counter() - begin)
    renderer.release()
    target.release()
    standing = float(np.median(spent["standing"]))
    return [
        Row(
            f"a picture while {name} moves", float(np.median(spent[name])) / standing, "x a standing one", 1.5,
            peers={"a standing one [ms]": standing * 1e3},
        )
        for name in ("light", "camera")
    ]  # fmt: skip
