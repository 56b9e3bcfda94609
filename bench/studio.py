"""The studio in a browser: from a gesture to its picture, script for each frame, and what pages cost the show."""

import gc
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from bench._document_score import score_text
from bench._studio_browser import CHROMIUM
from bench._studio_rows import KEY, Frames, StudioShow
from live.cli.bench import BENCH_FOLDER, Row

CALLS = 26
"""In each eight measures, so that 500 measures have 2,000 entries."""
EVERYBODY = """
[[segment]]
measure = 5
measures = 3
path = [[-2.0, 0.0], [0.0, 1.5], [2.0, 0.0]]
"""
SLICE_S = 0.25
DEADLINE_S = 180.0
BLOCK_S = 3.0
SETTLE_S = 2.0


def run(full: bool, shared: Path | None) -> list[Row]:
    """A show of 50 dancers in real time, nothing drawn; headless Chromium with software GL, on the same processor.

    Medians. The browser has a lower priority than the show (10), as pages are on other machines.
    """
    if CHROMIUM is None or find_spec("playwright") is None:
        return [Row("studio", None, "", note="needs Chromium and playwright: make test installs them")]
    with tempfile.TemporaryDirectory() as folder:
        return [*_gestures(Path(folder), 5 if full else 2), *_long_timeline(Path(folder))]


def _gestures(folder: Path, blocks: int) -> list[Row]:
    path = folder / "studio.toml"
    path.write_text(score_text(64) + EVERYBODY)
    with _browsed(path) as browser:
        opened = browser.do("first_openings")
        above = browser.do("frames")
        clicked = browser.do("click_boxes")
        dragged = browser.do("drag_box")
        bent = browser.do("drag_path")
        scrubbed = browser.do("scrub")
        browser.do("show", solid=True)
        solid = browser.do("frames")
        paced = browser.frames_with_pages(blocks)
    return [
        Row("page on the wire", opened.get("kB"), "kB", 250.0),
        Row("opened for the first time, until it can be used", opened.get("usable"), "s", 1.5),
        _row("click on a box to the stage", clicked, "ms", 100.0),
        _row("drag a box, to its planned ways, 50 dancers", dragged, "ms", 250.0),
        _row("drag a point of a way, to the planned ways, 50 dancers", bent, "ms", 250.0),
        _row("scrub, to where everybody stands", scrubbed, "ms", 300.0),
        Row("50 dancers from above: script of a frame", above.get("script"), "ms", 2.0,
            peers=_peers(above, "frames")),
        Row("50 dancers in 3D: script of a frame", solid.get("script"), "ms", 2.0, peers=_peers(solid, "frames")),
        paced,
    ]  # fmt: skip


def _long_timeline(folder: Path) -> list[Row]:
    path = folder / "long.toml"
    path.write_text(score_text(500, calls=CALLS))
    with _browsed(path) as browser:
        browser.do("open")
        panned = browser.do("frames", turn="bench.pan")
        whole = browser.do("whole")
        zoomed = browser.do("frames", turn="bench.zoom")
    entries = _peers(whole, "entries")
    return [
        Row("a timeline of 500 measures pans: script of a frame", panned.get("script"), "ms", 8.0,
            peers=entries | _peers(panned, "frames")),
        Row("a timeline of 500 measures zooms: script of a frame", zoomed.get("script"), "ms", 8.0,
            peers=entries | _peers(zoomed, "frames")),
    ]  # fmt: skip


class _Browser:
    """The browser's process; the show runs in this one while it works."""

    def __init__(self, show: StudioShow) -> None:
        self._show = show
        command = [sys.executable, "-m", "bench._studio_browser", f"http://127.0.0.1:{show.web.port}/studio#key={KEY}"]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env=os.environ | {"PYTHONPATH": str(BENCH_FOLDER.parent)},
        )  # fmt: skip
        self._answers = queue.Queue[str]()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._answers.put(line)

    def do(self, what: str, **values: Any) -> dict[str, float]:
        """Have the person at the browser do something; return its figures, none if it failed (told on stderr)."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps({"do": what} | values) + "\n")
        self._process.stdin.flush()
        for _ in range(int(DEADLINE_S / SLICE_S)):
            self._show.run(SLICE_S, Frames())
            if not self._answers.empty():
                answer: dict[str, Any] = json.loads(self._answers.get())
                if "error" in answer:
                    print(f"studio bench, {what}: {answer['error']}", file=sys.stderr)
                    return {}
                return answer
        raise TimeoutError(what)

    def frames_with_pages(self, blocks: int) -> Row:
        """Frames of the show with two open pages and without any, by turns."""
        gaps: dict[int, list[float]] = {0: [], 2: []}
        late = {0: 0, 2: 0}
        for _ in range(blocks):
            for pages in gaps:
                self.do("close")
                for _ in range(pages):
                    self.do("open")
                self._show.run(SETTLE_S, Frames())
                frames = Frames()
                self._show.run(BLOCK_S, frames)
                gaps[pages] += frames.gaps
                late[pages] += frames.late
        with_pages, without = (float(np.percentile(gaps[pages], 99.0)) for pages in (2, 0))
        return Row(
            "frame interval of the show with two open pages, p99 / without", with_pages / without, "", 1.05,
            peers={"with, ms": with_pages, "without, ms": without, "late with": late[2], "late without": late[0]},
        )  # fmt: skip

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


@contextmanager
def _browsed(path: Path) -> Iterator[_Browser]:
    show = StudioShow(path)
    try:
        browser = _Browser(show)
        gc.collect()
        gc.freeze()  # as a session does once the show is made
        try:
            yield browser
        finally:
            browser.close()
            gc.unfreeze()
    finally:
        show.close()


def _row(name: str, times: dict[str, float], unit: str, bar: float) -> Row:
    return Row(name, times.get("median"), unit, bar, peers=_peers(times, "longest"))


def _peers(figures: dict[str, float], name: str) -> dict[str, float]:
    return {name: figures[name]} if name in figures else {}
