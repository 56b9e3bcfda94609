"""CPU time of a frame without drawing: ticks, steering, planning, poses; 50, 200 and 1,000 dancers."""

import gc
import time
from collections import Counter
from pathlib import Path

import numpy as np

from bench._show import crowd
from live.base.inbox import Inbox
from live.cli.bench import Row
from live.clock.source import ManualClock
from live.control.events import Attract, ControlEvent, Spread
from live.show.engine import Engine
from live.show.load import load_show
from live.show.patch_file import DEFAULT_PATCH
from live.show.status import Status

FPS = 60


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median and 99th percentile of the CPU time of frames at 60 frames/s, attractors and spreaders acting."""
    loaded = load_show(DEFAULT_PATCH)
    rows: list[Row] = []
    for dancers, bar in ((50, None), (200, 3.0), (1000, None)):
        show = crowd(dancers, loaded)
        clock, inbox = ManualClock(), Inbox[ControlEvent]()
        status = Status(show, rejected=Counter, memory=lambda: 0.0)
        engine = Engine(show, clock=clock, inbox=inbox, status=status)
        frames = (120 if full else 30) * FPS
        times = np.zeros(frames)
        gc.collect()
        gc.freeze()
        gc.disable()
        try:
            for frame in range(frames):
                clock.set(frame / FPS)
                if frame % (6 * FPS) == 0:
                    x = 3.0 if frame % (12 * FPS) else -3.0
                    inbox.put(Attract(time=clock.now(), source="bench", x=x, z=0.5, measures=2.0))
                elif frame % (6 * FPS) == 3 * FPS:
                    inbox.put(Spread(time=clock.now(), source="bench", measures=2.0))
                begin = time.process_time_ns()
                engine.frame(lambda view: None)
                gc.collect(0)
                times[frame] = (time.process_time_ns() - begin) * 1e-6
        finally:
            gc.enable()
            gc.unfreeze()
        p50, p99 = (float(v) for v in np.percentile(times, [50, 99]))
        rows.append(Row(f"{dancers} dancers: frame, median", p50, "ms", bar))
        rows.append(Row(f"{dancers} dancers: frame, p99", p99, "ms"))
        rows.append(Row(f"{dancers} dancers: longest frame", float(times.max()), "ms"))
    return rows
