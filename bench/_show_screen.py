"""Rows of the show bench: how long a screen shows no new picture of the dance when engines are killed.

A real X server (Xorg with its dummy driver), a show full screen on it, and an eye that compares what stands there a
hundred times a second. The black window under the picture, and the last picture of the dead, are no new pictures.
"""

import contextlib
import itertools
import os
import signal
import subprocess
import tempfile
import threading
import time
import zlib
from pathlib import Path
from typing import Final

import psutil

from bench._show_alive import AFTER, alive, engines, playing, until
from live.cli.bench import Row
from tests.fixtures import two_monitor_x
from tests.fixtures.screen_eye import ScreenReader

STAGE: Final = (160, 100, 320, 200)
"""The middle of the first monitor: x, y, width, height [pixels]."""
APART: Final = 0.5
"""Seconds from one kill to the next of three in a row."""
NAMES: Final = (
    "alive: kill of an engine to the next picture on a screen",
    "alive: three kills 0.5 s apart to the next picture on a screen",
)


class Onlooker:
    """Notes when new pictures of the dance come."""

    def __init__(self, display: str) -> None:
        self.times: list[float] = []
        self._eye = ScreenReader(display, *STAGE)
        self._going = True
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def __enter__(self) -> "Onlooker":
        return self

    def __exit__(self, *_: object) -> None:
        self._going = False
        self._thread.join(5.0)
        self._eye.close()

    def pause(self, since: float) -> float:
        """The longest [s] from `since` on, once new pictures have come for a while after it."""
        until(lambda: bool(self.times) and self.times[-1] - since > AFTER + self._pause(since), "the show to go on")
        return self._pause(since)

    def _pause(self, since: float) -> float:
        times = list(self.times)
        before = max((one for one in times if one <= since), default=since)
        return max((b - a for a, b in itertools.pairwise([before, *(t for t in times if t > since)])), default=0.0)

    def _look(self) -> None:
        last = 0
        while self._going:
            picture = self._eye.picture()
            now, seen = time.monotonic(), zlib.crc32(picture)
            if seen != last and any(memoryview(picture)[::4]):  # blue is in every look's floor; the guard is black
                self.times.append(now)
            last = seen
            time.sleep(0.005)


def rows(full: bool) -> list[Row]:
    """Pauses on a screen: one kill, and with `full` three in a row; None where no X server can be started."""
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        try:
            there, server = two_monitor_x.start(Path(name))
        except two_monitor_x.NoX:
            return [Row(each, None, "s", 3.0, note="needs an X server: make test installs it") for each in NAMES]
        stack.callback(two_monitor_x.stop, server)
        found = [_pause(there.display, Path(name) / f"status{kills}", kills) for kills in ((1, 3) if full else (1,))]
        return [Row(named, value, "s", 3.0) for named, value in zip(NAMES, found, strict=False)]


def _pause(display: str, status: Path, kills: int) -> float:
    """Kill whoever dances, so many times; how long nobody was seen to dance [s] since the first."""
    with playing(status, display=display) as process, Onlooker(display) as eye:
        until(lambda: alive(status).get("spare", False) and len(eye.times) > 20, "an engine that waits")
        gone = [engines(process)[1]]  # the nursery, which nobody sees
        since = time.monotonic()
        for number in range(kills):
            if number:
                time.sleep(APART)
            until(lambda: bool(_dancing(process, gone)), "somebody to kill")
            gone.append(_dancing(process, gone)[0])
            os.kill(gone[-1].pid, signal.SIGKILL)
        return eye.pause(since)


def _dancing(process: subprocess.Popen[bytes], others: list[psutil.Process]) -> list[psutil.Process]:
    return [one for one in engines(process) if one not in others]
