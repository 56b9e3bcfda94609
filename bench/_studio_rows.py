"""Rows of the document bench: what pages of the studio cost the frames of the show, in real time, nothing drawn."""

import gc
import json
import os
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench._document_score import score_text
from live.app.services.document_service import DocumentService
from live.app.services.score_stream import ScoreStream
from live.app.services.stage_stream import StageStream
from live.app.services.web_service import WebService, preview_files
from live.base.event_queue import EventQueue
from live.cli.bench import BENCH_FOLDER, Row
from live.clock.time_source import SystemClock
from live.control.events.event import ControlEvent
from live.document.document_store import DocumentStore
from live.render.timing.frame_stats import Pacer
from live.show.engine import Engine
from live.show.loader import load_show
from live.show.patch.hot_reload import PatchWatch
from live.show.view.status import Status

FPS = 60.0
BLOCK = 3.0
"""Seconds of one way, before the other one comes [s]."""
SETTLE = 1.0
"""Seconds after each change before anything counts [s]."""
KEY = "a-key-of-the-bench-4711"
NOTHING = {"look": 0, "edits": 0.0, "preview": False}
LOOKING = {"look": 1, "edits": 0.0, "preview": False}
EDITING = {"look": 2, "edits": 1.0, "preview": False}
ASKING = {"look": 0, "edits": 0.0, "preview": True}


@dataclass
class Frames:
    """Frames of one way, of all its blocks."""

    gaps: list[float] = field(default_factory=list)
    """From one to the next [ms]."""
    work: list[float] = field(default_factory=list)
    """Processor time of each in the show's thread [ms]."""
    pages: float = 0.0
    """Processor time of the frames and texts for pages, in all [s]."""
    preview: float = 0.0
    """Processor time of the preview process meanwhile [s]."""
    late: int = 0
    """Frames that began more than half a frame late."""
    counts: Counter[str] = field(default_factory=Counter)
    """What the pages got."""

    @property
    def seconds(self) -> float:
        return sum(self.gaps) / 1e3


class StudioShow:
    """A show of 50 dancers with its web server, and pages in a process of their own."""

    def __init__(self, path: Path) -> None:
        loaded = load_show(path)
        self.show, self.clock, self.inbox = loaded.start(), SystemClock(), EventQueue[ControlEvent]()
        status = Status(self.show, rejected=Counter, memory=lambda: 0.0)
        self.engine = Engine(self.show, clock=self.clock, inbox=self.inbox, status=status)
        self.watch = PatchWatch(loaded, self.show, post=self.inbox.put, now=self.clock.now)
        self.document = DocumentService(self.watch, self.show, path, lambda: DocumentStore(path))
        stage = StageStream(self.show, lambda: self.engine.view, ScoreStream(self.show, self.document), lambda: 0)
        self.web = WebService(
            ("127.0.0.1", 0), KEY, ("127.0.0.1", 9), self.show, self.clock, stage=stage,
            files=preview_files(loaded, None), inbox=self.inbox.add_queue(),
        )  # fmt: skip
        self.document.answer_listeners.append(self.web.answer)
        self.engine.event_listeners.append(self.document.handle)
        self.engine.patch_listeners.append(self.web.update_patch)
        self.web.start()
        self.watch.start()
        command = [sys.executable, "-m", "bench._studio_pages", str(self.web.port), KEY]
        self.pages = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env=os.environ | {"PYTHONPATH": str(BENCH_FOLDER.parent)},
        )  # fmt: skip
        self.pacer = Pacer(FPS, self.clock.now, time.sleep)
        self.order(NOTHING)

    def close(self) -> None:
        assert self.pages.stdin is not None
        self.pages.stdin.close()
        self.pages.wait()
        self.web.stop()
        self.watch.stop()

    def order(self, order: dict[str, Any]) -> Counter[str]:
        """Have the pages do something else (empty: the same); return what they got meanwhile."""
        assert self.pages.stdin is not None
        assert self.pages.stdout is not None
        self.pages.stdin.write(json.dumps(order) + "\n")
        self.pages.stdin.flush()
        return Counter(json.loads(self.pages.stdout.readline()))

    def block(self, order: dict[str, Any], frames: Frames, seconds: float) -> None:
        """Run the show while the pages do something, and add its frames."""
        self.order(order)
        self.run(SETTLE, Frames())
        self.order({})
        simulated = self.preview_seconds()
        self.run(seconds, frames)
        frames.preview += self.preview_seconds() - simulated
        frames.counts += self.order(NOTHING)

    def preview_seconds(self) -> float:
        """Return the processor time of the preview process so far [s]; 0 while there is none, or on other systems."""
        try:
            children = Path(f"/proc/{self.web.pid}/task/{self.web.pid}/children").read_text().split()
            fields = Path(f"/proc/{children[0]}/stat").read_text().rpartition(")")[2].split()
        except (OSError, IndexError):
            return 0.0
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def run(self, seconds: float, frames: Frames) -> None:
        previous = self.pacer.wait()
        end, late = previous + seconds, self.pacer.late
        while previous < end:
            started = self.pacer.wait()
            before = time.thread_time()
            self.engine.frame(lambda view: None)
            middle = time.thread_time()
            self.web.frame()
            after = time.thread_time()
            self.document.frame()
            gc.collect(0)
            frames.work.append((time.thread_time() - before) * 1e3)
            frames.pages += after - middle
            frames.gaps.append((started - previous) * 1e3)
            previous = started
        frames.late += self.pacer.late - late


def rows(folder: Path, blocks: int) -> list[Row]:
    """`blocks` of each way, interleaved in one run, so that other work on the machine meets all of them."""
    path = folder / "studio.toml"
    path.write_text(score_text(64))
    show = StudioShow(path)
    ways = {"nothing": NOTHING, "looking": LOOKING, "editing": EDITING, "asking": ASKING}
    frames = {name: Frames() for name in ways}
    try:
        show.block(ASKING, Frames(), 2 * BLOCK)  # the preview is warm then
        gc.collect()
        gc.freeze()  # as a session does once the show is made
        for _ in range(blocks):
            for name, order in ways.items():
                show.block(order, frames[name], BLOCK)
    finally:
        show.close()
    nothing, looking, editing, asking = frames.values()
    cost = (looking.pages / looking.seconds - nothing.pages / nothing.seconds) * 100.0
    where = "50 dancers with joints at 30 Hz, one page"
    return [
        Row(f"{where}: processor time in the show's process", cost, "% of a core", 3.0),
        Row(f"{where}: bytes a second", looking.counts["bytes"] / looking.seconds / 1e3, "kB/s", 250.0,
            peers={"frames a second": looking.counts["frames"] / looking.seconds}),
        Row("two editing pages: frame interval, p99 / without", _p99(editing.gaps) / _p99(nothing.gaps), "", 1.05,
            peers={"with, ms": _p99(editing.gaps), "without, ms": _p99(nothing.gaps),
                   "accepted edits": editing.counts["accepted"], "late frames": editing.late,
                   "late frames without": nothing.late}),
        Row("two editing pages: frame's processor time, p99", _p99(editing.work), "ms", None,
            peers={"without": _p99(nothing.work), "one page that looks": _p99(looking.work)}),
        Row("late frames while the preview works, beyond those without", float(max(0, asking.late - nothing.late)), "",
            0.0, peers={"with": asking.late, "without": nothing.late,
                        "preview's share of a core, %": 100.0 * asking.preview / asking.seconds}),
    ]  # fmt: skip


def _p99(values: list[float]) -> float:
    return float(np.percentile(values, 99.0))
