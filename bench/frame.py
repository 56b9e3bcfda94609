"""CPU time of a frame without drawing: ticks, steering, planning, poses; 50, 200, 1,000, 4,000 and 10,000 dancers.

And 10,000 on two threads, the state captured for a snapshot, 500 elements set in one frame, and frames with bad input
(`_hostile.py`), of which none may be late.
"""

import gc
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from bench import _hostile as hostile
from bench._show import crowd
from live.app.machine.kernel_warmup import load_kernels
from live.base.event_queue import EventQueue
from live.base.row_ranges import Part, row_runner
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events.events import ControlEvent, PlaceElement
from live.show.background_work import import_late_modules
from live.show.engine import Engine
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.stages.row_threads import row_threads
from live.show.state.snapshot import Snapshotter
from live.show.view.status import Status

Float64 = npt.NDArray[np.float64]

FPS: Final = 60
SIZES: Final = ((50, 0.4), (200, 1.5), (1000, 2.5), (4000, None), (10_000, 18.0))
"""Dancers, and the most that the median of their frames may take [ms]."""
EVEN: Final = (50, 200, 1000, 10_000)
"""Of so many dancers no frame may take much longer than the others."""
ELEMENTS: Final = 500
"""So many elements are set in one frame."""
WARM_S: Final = 3.0
"""So long at the beginning nothing counts [s]: everything is used for the first time."""


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """CPU time of each frame [ms], whether a measure began in it, and whether the next one was decided in it, (F,)."""

    spent: Float64
    passed: Float64
    """Time on the wall [ms], (F,)."""
    line: npt.NDArray[np.bool_]
    decision: npt.NDArray[np.bool_]

    @property
    def others(self) -> float:
        """Median of the frames in which neither happens [ms]."""
        return float(np.median(self.spent[~self.line & ~self.decision]))


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median and 99th percentile of the CPU time of frames at 60 frames/s, attractors and spreaders acting."""
    load_kernels()  # a show does so within its first seconds, see `KernelLoader`
    import_late_modules()
    loaded = load_show(DEFAULT_PATCH)
    rows: list[Row] = []
    found = {}
    for dancers, bar in SIZES:
        seconds = (120.0 if full else 24.0) if dancers <= 1000 else (40.0 if full else 8.0)
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
            Row(
                f"{name}: frame, p99 over median",
                p99 / median,
                "",
                1.5 if dancers in EVEN else None,
                peers={"p99 [ms]": p99},
            ),
            _against(f"{name}: frame with a measure line, to the others", frames, frames.line),
            _against(f"{name}: frame with a decision, to the others", frames, frames.decision),
            Row(f"{name}: longest frame", float(frames.spent.max()), "ms"),
        ]
    each = [float(np.median(found[dancers].spent)) / dancers for dancers in (1000, 4000)]
    rows.append(Row("a dancer of 4000 : one of 1000", each[1] / each[0], "", 1.3))
    rows += [*_two_threads(loaded, full), *_snapshots(loaded), *_many_elements(loaded)]
    return [*rows, *hostile.rows(loaded, 60.0 if full else 12.0)]


class _Shared:
    """A runner of one thread that counts the CPU time of what two threads could share."""

    threads = 2

    def __init__(self) -> None:
        self.spent = 0.0

    def run(self, part: Part, ranges: Sequence[tuple[int, int]]) -> None:
        """Do all ranges, one after the other."""
        begin = time.thread_time_ns()
        for first, end in ranges:
            part(first, end)
        self.spent += (time.thread_time_ns() - begin) * 1e-6


def _two_threads(loaded: LoadedShow, full: bool) -> Iterator[Row]:
    """How much quicker 10,000 dancers are on two threads: on the wall, in the quicker frames of each; and by the share
    of the CPU time that threads share, which counts on a machine with other work, too."""
    seconds = WARM_S + (20.0 if full else 4.0)
    runner = _Shared()
    with row_runner(runner):
        shared = measured(10_000, loaded, seconds)
    share = runner.spent / (len(shared.spent) / (seconds - WARM_S) * seconds * float(shared.spent.mean()))
    passed = {}
    for threads in (1, 2):
        with row_threads(threads):
            passed[threads] = measured(10_000, loaded, seconds).passed
    one, two = (float(np.percentile(passed[threads], 25)) for threads in (1, 2))
    peers = {"one [ms]": one, "two [ms]": two}
    yield Row("10000 dancers: one thread : two, on the wall", one / two, "", 1.7, "at least", peers=peers)
    peers = {"so two threads would be quicker by": 1.0 / (1.0 - 0.5 * share)}
    yield Row("10000 dancers: share of the work that threads share", share, "", 0.83, "at least", peers=peers)


def _snapshots(loaded: LoadedShow) -> Iterator[Row]:
    """CPU time in the frame to capture the state of a show, the median of those after the first, which names all."""
    for dancers in (50, 1000, 10_000):
        show = crowd(dancers, loaded)
        snapshotter, spent = Snapshotter(show), []
        for tick in range(1, 240):
            show.tick(tick * TICK)
            begin = time.thread_time_ns()
            if snapshotter.capture(tick) is not None:
                spent.append((time.thread_time_ns() - begin) * 1e-6)
        yield Row(f"{dancers} dancers: snapshot", float(np.median(spent[1:])), "ms", 1.0, peers={"first": spent[0]})


def _many_elements(loaded: LoadedShow) -> Iterator[Row]:
    """CPU time by which a frame is longer in which 500 elements are set than those around it."""
    for dancers in (50, 1000):
        show = crowd(dancers, loaded)
        clock, inbox = ManualClock(), EventQueue[ControlEvent]()
        engine = Engine(show, clock=clock, inbox=inbox, status=Status(show, rejected=Counter, memory=lambda: 0.0))
        spent, count = [], 6 * FPS
        for frame in range(count):
            clock.set(frame / FPS)
            for n in range(ELEMENTS if frame == count - 1 else 0):
                place = (n % 25 * 0.4 - 5.0, n // 25 * 0.3 - 3.0)
                inbox.put(PlaceElement(time=frame / FPS, source="bench", kind="attract", points=(place,), measures=1.0))
            begin = time.thread_time_ns()
            engine.frame(lambda view: None)
            spent.append((time.thread_time_ns() - begin) * 1e-6)
        usual = float(np.median(spent[-FPS:-1]))
        yield Row(f"{dancers} dancers: {ELEMENTS} elements set in a frame", spent[-1] - usual, "ms", 5.0)


def _against(name: str, frames: Frames, which: npt.NDArray[np.bool_]) -> Row:
    """Median of some frames over that of those in which nothing special happens."""
    if not which.any():
        return Row(name, None, "", 1.2)
    spent = frames.spent[which]
    return Row(name, float(np.median(spent)) / frames.others, "", 1.2, peers={"longest [ms]": float(spent.max())})


def measured(dancers: int, loaded: LoadedShow, seconds: float) -> Frames:
    """The frames of a show with `dancers` dancers, but for the first WARM_S."""
    show = crowd(dancers, loaded)
    clock, inbox = ManualClock(), EventQueue[ControlEvent]()
    engine = Engine(show, clock=clock, inbox=inbox, status=Status(show, rejected=Counter, memory=lambda: 0.0))
    count = int(seconds * FPS)
    spent, passed = np.zeros((2, count))
    line, decision = np.zeros((2, count), np.bool_)
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        for frame in range(count):
            clock.set(frame / FPS)
            _throw(inbox, frame)
            measure, decided = show.span.number, show.dancers.decided
            wall, begin = time.perf_counter_ns(), time.thread_time_ns()
            engine.frame(lambda view: None)
            gc.collect(0)
            spent[frame] = (time.thread_time_ns() - begin) * 1e-6
            passed[frame] = (time.perf_counter_ns() - wall) * 1e-6
            line[frame] = show.span.number != measure
            decision[frame] = show.dancers.decided and not decided
    finally:
        gc.enable()
        gc.unfreeze()
    kept = slice(int(WARM_S * FPS), None)
    return Frames(spent[kept], passed[kept], line[kept], decision[kept])


def _throw(inbox: EventQueue[ControlEvent], frame: int) -> None:
    """An attractor and a spreader in turn, every three seconds."""
    now = frame / FPS
    if frame % (6 * FPS) == 0:
        x = 3.0 if frame % (12 * FPS) else -3.0
        inbox.put(PlaceElement(time=now, source="bench", kind="attract", points=((x, 0.5),), measures=2.0))
    elif frame % (6 * FPS) == 3 * FPS:
        inbox.put(PlaceElement(time=now, source="bench", kind="spread", measures=2.0))
