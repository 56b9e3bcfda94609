"""What engines are born with: the program, its kernels, patch and steps; nothing open. See `live.alive.nursery`."""

import contextlib
import gc
import importlib

from rich.console import Console

from live.alive.lifeline import Lifeline
from live.alive.nursery import wait_to_be_born
from live.alive.priority import come_forward, stand_back
from live.cli.played import Played
from live.cli.warm import warm_kernels
from live.show.core import Show
from live.show.load import LoadedShow


def be_born(played: Played, nursery: Lifeline, console: Console) -> tuple[Lifeline | None, LoadedShow, Show]:
    """Load everything while a show runs, and bear engines; comes back in each of them with its own lifeline, and with a
    show that it may draw to rehearse."""
    processors = stand_back()
    warm_kernels(console)
    for name in ("heir", "stage", "headless_show" if played.headless else "window_show"):
        importlib.import_module(f"live.cli.{name}")  # what an heir needs, all the way down
    if not played.headless:
        from live.render.body import COARSE, FINE, LIGHT, build_body
        from live.render.monitors import load_glfw

        with contextlib.suppress(ImportError):
            load_glfw()
        for level in (COARSE, LIGHT, FINE):
            build_body(level)
    loaded = played.wish.load(whole=False)
    show = loaded.start(seed=played.wish.seed)  # what is computed once and kept with the graph is there then
    come_forward(0, processors)
    gc.collect()
    gc.freeze()
    return wait_to_be_born(nursery), loaded, show
