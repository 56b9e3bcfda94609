"""The command `live` as a user starts it, with its output files read back."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.control.conftest import pulse_sink
from tests.control.waiting import BUSY
from tests.render.conftest import two_monitor_x

__all__ = ["pulse_sink", "two_monitor_x"]

PATCH = """
name = "end to end"
seed = 1
[stage]
width = 12
depth = 8
[camera]
eye = [0.0, 3.0, 12.0]
[[group]]
name = "blue"
dancers = 8
colour = [0.02, 0.2, 1.0]
steps = ["walk"]
formation = "grid"
centre = [-3.0, 0.0]
size = [4.0, 4.0]
"""


@dataclass
class Running:
    """A running `live play` and the file of its status lines."""

    process: subprocess.Popen[str]
    status: Path
    mark: str
    """The environment entry of all its processes."""

    def lines(self) -> list[dict[str, Any]]:
        """Complete status lines written so far."""
        text = self.status.read_text() if self.status.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def wait_for(self, condition: Callable[[dict[str, Any]], bool], seconds: float) -> dict[str, Any]:
        """The first status line that fulfills the condition; fails when the process ends, or after `seconds` on an
        idle machine."""
        deadline = time.monotonic() + BUSY * seconds
        while time.monotonic() < deadline:
            for line in self.lines():
                if condition(line):
                    return line
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        output = self.stop()
        raise AssertionError(f"not within {seconds} s; last status {self.lines()[-1:]}; output: {output}")

    def stop(self) -> str:
        """End it as Ctrl-C does, and return what it printed."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        elif self.process.returncode < 0:
            end_all(self.mark)  # what outlives its supervisor has the pipe
        try:
            return self.process.communicate(timeout=20)[0]
        except subprocess.TimeoutExpired:
            self.process.kill()
            end_all(self.mark)
            return self.process.communicate()[0]


def end_all(mark: str) -> None:
    """Kill every process with this entry in its environment."""
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if mark.encode() in (path / "environ").read_bytes().split(b"\0"):
                os.kill(int(path.name), signal.SIGKILL)
        except OSError:
            continue


def children(running: Running, module: str) -> list[int]:
    """Processes of that module started by the command, the oldest first."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            stat = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(stat[1]) == running.process.pid and module in (folder / "cmdline").read_text():
                found.append((int(stat[19]), int(folder.name)))
        except OSError:
            continue
    return [pid for _, pid in sorted(found)]


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Callable[..., Running]]:
    """Start `live play` with options; everything started is ended after the test."""
    started: list[Running] = []

    def start(*options: str, env: dict[str, str] | None = None, status: Path | None = None) -> Running:
        status = status or tmp_path / f"status{len(started)}.jsonl"
        key, value = "LIVE_TEST_SHOW", str(tmp_path)
        process = subprocess.Popen(
            [sys.executable, "-m", "live", "play", *options, "--status-json", str(status)],
            env={**os.environ, "LIVE_CONFIG_DIR": str(tmp_path / "config"), key: value, **(env or {})},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=tmp_path,
        )
        started.append(Running(process, status, f"{key}={value}"))
        return started[-1]

    yield start
    for running in started:
        running.stop()
    end_all(f"LIVE_TEST_SHOW={tmp_path}")


@pytest.fixture
def patch(tmp_path: Path) -> Path:
    """A patch of eight blue dancers on the left of the stage."""
    path = tmp_path / "show.toml"
    path.write_text(PATCH)
    return path
