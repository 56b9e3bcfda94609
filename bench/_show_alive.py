"""Rows of the show bench: how long nobody dances when an engine, or the machine that leads, ends.

Real processes without a picture. An observer connects as a machine that stands by would, and looks at when ticks come:
an engine tells them after each of its frames, so the longest pause is what a public would have seen.
"""

import contextlib
import itertools
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import psutil

from live.cli.bench import Row
from live.supervisor.network.remote_standby import DEPUTY_NOTE

PATIENCE: Final = 180.0
"""Seconds for a start on a machine that has other work to do."""
AFTER: Final = 2.0
"""Seconds that are looked at after the show goes on."""
TICK: Final = re.compile(rb'\{"tick":\d+\}\n')


class Observer:
    """Notes when ticks come from a machine that leads."""

    def __init__(self, port: int) -> None:
        self.times: list[float] = []
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def pause(self, since: float) -> float:
        """The longest [s] from shortly before `since` on, once it is over."""
        until(lambda: bool(self.times) and self.times[-1] - self._last(since) > AFTER, "the show to go on")
        times = [self._last(since), *(one for one in list(self.times) if one > since)]
        return max(b - a for a, b in itertools.pairwise(times))

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join(5.0)
        self._socket.close()

    def _last(self, since: float) -> float:
        return max((one for one in list(self.times) if one <= since), default=since)

    def _listen(self) -> None:
        with contextlib.suppress(OSError), self._socket.makefile("rb") as file:
            for line in file:
                if TICK.fullmatch(line):
                    self.times.append(time.monotonic())


def rows(full: bool) -> list[Row]:
    """Pauses; `full`: the longest of three engines that were killed, else of one."""
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder, leads, stands = Path(name), _free(), _free()
        leader = stack.enter_context(playing(folder / "leader", "--lead", str(leads)))
        killed: list[float] = []
        for _ in range(3 if full else 1):
            until(lambda: alive(folder / "leader").get("spare", False), "an engine that waits")
            killed.append(_pause(leads, lambda: os.kill(engines(leader)[0].pid, signal.SIGKILL)))
        how = ("--standby", f"127.0.0.1:{leads}", "--lead", str(stands))
        stack.enter_context(playing(folder / "standby", *how))
        until(lambda: alive(folder / "leader").get("followers") == 1, "a machine that stands by")
        until(lambda: DEPUTY_NOTE in _said(folder / "standby"), "a machine that is the deputy")
        silent = _pause(stands, lambda: _stop(leader))
        return [
            Row("alive: kill of an engine to the next tick of another, no window", max(killed), "s", 3.0),
            Row("alive: silence of the leader to the next tick of a machine that stands by", silent, "s", 0.5),
        ]


def _pause(port: int, end: Callable[[], None]) -> float:
    observer = Observer(port)
    try:
        until(lambda: len(observer.times) > 100, "ticks")
        since = time.monotonic()
        end()
        return observer.pause(since)
    finally:
        observer.close()


@contextlib.contextmanager
def playing(status: Path, *how: str, display: str | None = None) -> Iterator[subprocess.Popen[bytes]]:
    """`live play` without a picture, or full screen on `display`; its status lines go to the file `status`."""
    options = ["--headless"] if display is None else ["--fullscreen"]
    options += ["--bpm", "120", "--osc", "127.0.0.1:0", "--status-json", str(status), *how]
    there = os.environ if display is None else {**os.environ, "DISPLAY": display}
    with status.with_suffix(".said").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "live", "play", *options], stdout=subprocess.DEVNULL, stderr=said, env=there
        )
    try:
        yield process
    finally:
        everyone = psutil.Process(process.pid).children(recursive=True)
        for one in everyone:
            one.send_signal(signal.SIGCONT)
        process.send_signal(signal.SIGCONT)
        process.send_signal(signal.SIGINT)
        try:
            process.wait(30.0)
        except subprocess.TimeoutExpired:
            process.kill()
            for one in everyone:
                with contextlib.suppress(psutil.NoSuchProcess):
                    one.kill()
            process.wait()


def engines(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    """Those of a show, the oldest first: that one dances."""
    found = []
    for one in psutil.Process(process.pid).children():
        with contextlib.suppress(psutil.NoSuchProcess):  # who was killed is a zombie until the supervisor looks
            if "live.app.processes.engine_main" in one.cmdline():
                found.append((one.create_time(), one))
    return [one for _, one in sorted(found, key=lambda each: each[0])]


def _stop(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGSTOP)
    for one in engines(process):
        one.send_signal(signal.SIGSTOP)


def last_line(status: Path) -> dict[str, Any]:
    """Return the last whole status line; empty before the first."""
    whole = status.read_bytes().rpartition(b"\n")[0].splitlines() if status.exists() else []
    found: dict[str, Any] = json.loads(whole[-1]) if whole else {}
    return found


def alive(status: Path) -> dict[str, Any]:
    """What the last whole status line says of the processes."""
    found: dict[str, Any] = last_line(status).get("alive", {})
    return found


def _said(status: Path) -> str:
    return status.with_suffix(".said").read_text()


def until(what: Callable[[], bool], named: str) -> None:
    """Wait for a condition; TimeoutError, with what it is `named`, after `PATIENCE`."""
    deadline = time.monotonic() + PATIENCE
    while not what():
        if time.monotonic() > deadline:
            raise TimeoutError(f"waited {PATIENCE:.0f} s for {named}")
        time.sleep(0.02)


def _free() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])
