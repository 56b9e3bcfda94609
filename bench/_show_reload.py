"""Rows of the show bench: what an edit of the patch costs the frames of the show that runs meanwhile."""

import gc
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from live.base.event_queue import EventQueue
from live.cli.bench import Row
from live.clock.time_source import SystemClock
from live.control.events.events import ControlEvent
from live.rehearse.fault_injection import PatchEditor
from live.render.timing.frame_stats import Pacer
from live.show.engine import Engine
from live.show.loader import load_show
from live.show.patch.hot_reload import PatchWatch
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.view.status import Status

FPS = 60.0
EVERY = 2.0
"""Seconds from one edit to the next."""
WARM = 1.0
"""Seconds before anything counts."""


@dataclass
class Run:
    """Frames of some seconds."""

    work: list[float] = field(default_factory=list)
    """Processor time of each in the show's thread [ms]."""
    gaps: list[float] = field(default_factory=list)
    """From one to the next [ms]."""
    taken: int = 0
    """Edits that took effect."""

    @property
    def late(self) -> int:
        """Frames that came more than half a frame late."""
        return int((np.array(self.gaps) > 1.5e3 / FPS).sum())


def rows(full: bool) -> list[Row]:
    """The same show with and without edits, in real time, nothing drawn; the second is the peer."""
    seconds = 60.0 if full else 8.0
    with tempfile.TemporaryDirectory() as folder:
        plain = _run(Path(folder) / "a", seconds, edited=False)
        edited = _run(Path(folder) / "b", seconds, edited=True)
    return [
        Row("hot reload: edits that took effect", float(edited.taken), "", max(1.0, seconds / EVERY / 2), "at least"),
        Row("hot reload: late frames of an edited show beyond those of one that is not",
            float(max(0, edited.late - plain.late)), "", 0.0, peers={"edited": edited.late, "not": plain.late}),
        Row("hot reload: longest frame, processor time", max(edited.work), "ms", 1e3 / FPS,
            peers={"not edited": max(plain.work)}),
    ]  # fmt: skip


def _run(folder: Path, seconds: float, *, edited: bool) -> Run:
    edits = PatchEditor(DEFAULT_PATCH, folder, 1)
    loaded = load_show(edits.path)
    show, clock, inbox, run = loaded.start(), SystemClock(), EventQueue[ControlEvent](), Run()
    status = Status(show, rejected=Counter, memory=lambda: 0.0)
    engine = Engine(show, clock=clock, inbox=inbox, status=status)
    watch = PatchWatch(loaded, show, post=inbox.put, now=clock.now)
    pacer = Pacer(FPS, clock.now, time.sleep)
    watch.start()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        previous, following = clock.now(), WARM
        while previous < seconds + WARM:
            started = pacer.wait()
            if edited and started >= following:
                following += EVERY
                edits.save_valid()
            before = time.thread_time()
            engine.frame(lambda view: None)
            gc.collect(0)
            if started > WARM:
                run.work.append((time.thread_time() - before) * 1e3)
                run.gaps.append((started - previous) * 1e3)
            previous = started
    finally:
        gc.enable()
        gc.unfreeze()
        watch.stop()
    run.taken = show.patch_updates.applied_count
    return run
