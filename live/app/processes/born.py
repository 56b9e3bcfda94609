"""What engines are born with: program, kernels, patch and steps; nothing open. See `live.supervisor.prefork`."""

import contextlib
import gc
import importlib

from rich.console import Console

from live.app.kernel_warmup import warm_kernels
from live.app.played import Played
from live.show.core import Show
from live.show.load import LoadedShow
from live.supervisor.cpu_priority import come_forward, stand_back
from live.supervisor.lifeline import Lifeline
from live.supervisor.prefork import wait_to_be_born


def be_born(played: Played, nursery: Lifeline, console: Console) -> tuple[Lifeline | None, LoadedShow, Show]:
    """Load everything while a show runs, and bear engines; comes back in each of them with its own lifeline, and with a
    show that it may draw to rehearse."""
    processors = stand_back()
    warm_kernels(console)
    for name in ("heir", "stage", "headless_show" if played.headless else "window_show"):
        importlib.import_module(f"live.cli.{name}")  # what an heir needs, all the way down
    if not played.headless:
        from live.render.body.body_mesh import COARSE, FINE, LIGHT, build_body
        from live.render.window.monitors import load_glfw

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
