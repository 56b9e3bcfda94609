"""CPU time of a frame without drawing: ticks, steering, planning, poses; 50, 200, 1,000 and 4,000 dancers.

And with bad input (`_hostile.py`): no frame may be late.
"""

import gc
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from bench import _hostile as hostile
from bench._show import crowd
from live.base.event_queue import EventQueue
from live.cli.bench import Row
from live.clock.time_source import ManualClock
from live.control.events.events import ControlEvent, PlaceElement
from live.show.engine import Engine
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.view.status import Status

Float64 = npt.NDArray[np.float64]

FPS: Final = 60
SIZES: Final = ((50, 0.6), (200, 1.5), (1000, 5.0), (4000, None))
"""Dancers, and the most that the median of their frames may take [ms]."""
WARM_S: Final = 3.0
"""So long at the beginning nothing counts [s]: everything is used for the first time."""


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """CPU time of each frame [ms], whether a measure began in it, and whether the next one was decided in it, (F,)."""

    spent: Float64
    line: npt.NDArray[np.bool_]
    decision: npt.NDArray[np.bool_]

    @property
    def others(self) -> float:
        """Median of the frames in which neither happens [ms]."""
        return float(np.median(self.spent[~self.line & ~self.decision]))


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median and 99th percentile of the CPU time of frames at 60 frames/s, attractors and spreaders acting."""
    loaded = load_show(DEFAULT_PATCH)
    rows: list[Row] = []
    found = {}
    for dancers, bar in SIZES:
        seconds = (120.0 if full else 24.0) if dancers <= 1000 else (40.0 if full else 10.0)
        found[dancers] = frames = measured(dancers, loaded, WARM_S + seconds)
        median, p99 = (float(v) for v in np.percentile(frames.spent, [50, 99]))
        name = f"{dancers} dancers"
        rows += [
            Row(
                f"{name}: frame, median",
                median,
                "ms",
                bar,
                peers={"quickest tenth": float(np.percentile(frames.spent, 10))},
            ),
            Row(f"{name}: frame, p99 over median", p99 / median, "", 2.0, peers={"p99 [ms]": p99}),
            _against(f"{name}: frame with a measure line, to the others", frames, frames.line),
            _against(f"{name}: frame with a decision, to the others", frames, frames.decision),
            Row(f"{name}: longest frame", float(frames.spent.max()), "ms"),
        ]
    each = [float(np.median(found[dancers].spent)) / dancers for dancers in (1000, 4000)]
    rows.append(Row("a dancer of 4000 : one of 1000", each[1] / each[0], "", 1.3))
    return [*rows, *hostile.rows(loaded, 60.0 if full else 12.0)]


def _against(name: str, frames: Frames, which: npt.NDArray[np.bool_]) -> Row:
    """Median of some frames over that of those in which nothing special happens."""
    if not which.any():
        return Row(name, None, "", 1.3)
    spent = frames.spent[which]
    return Row(name, float(np.median(spent)) / frames.others, "", 1.3, peers={"longest [ms]": float(spent.max())})


def measured(dancers: int, loaded: LoadedShow, seconds: float) -> Frames:
    """The frames of a show with `dancers` dancers, but for the first WARM_S."""
    show = crowd(dancers, loaded)
    clock, inbox = ManualClock(), EventQueue[ControlEvent]()
    engine = Engine(show, clock=clock, inbox=inbox, status=Status(show, rejected=Counter, memory=lambda: 0.0))
    count = int(seconds * FPS)
    spent, line, decision = np.zeros(count), np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        for frame in range(count):
            clock.set(frame / FPS)
            _throw(inbox, frame)
            measure, decided = show.span.number, show.dancers.decided
            begin = time.thread_time_ns()
            engine.frame(lambda view: None)
            gc.collect(0)
            spent[frame] = (time.thread_time_ns() - begin) * 1e-6
            line[frame] = show.span.number != measure
            decision[frame] = show.dancers.decided and not decided
    finally:
        gc.enable()
        gc.unfreeze()
    kept = slice(int(WARM_S * FPS), None)
    return Frames(spent[kept], line[kept], decision[kept])


def _throw(inbox: EventQueue[ControlEvent], frame: int) -> None:
    """An attractor and a spreader in turn, every three seconds."""
    now = frame / FPS
    if frame % (6 * FPS) == 0:
        x = 3.0 if frame % (12 * FPS) else -3.0
        inbox.put(PlaceElement(time=now, source="bench", kind="attract", points=((x, 0.5),), measures=2.0))
    elif frame % (6 * FPS) == 3 * FPS:
        inbox.put(PlaceElement(time=now, source="bench", kind="spread", measures=2.0))
