"""Starting: from the command to the first frame, with compiled kernels (warm) and without (cold); time and processor.

Wall-clock time depends on what else runs on the machine, processor time hardly. The processor time is that of all
processes of a command. `live play` starts a supervisor, an engine, a sound and an OSC process.
"""

import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import psutil

from live.cli.bench import Row

COLD_BAR_S, WARM_BAR_S, WARM_BAR_CPU_S = 25.0, 1.5, 2.0
POLL_S = 0.02
TIMEOUT_S = 900.0

Cost = tuple[float, float]
"""Wall-clock and processor seconds."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Measure `live render` of one frame at 320x180 as whole processes, and `live play --headless` to its first frame.

    The median of several warm starts. The first frame of a show comes a second before its first line of status.
    """
    repeats = 5 if full else 3
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        environment = dict(os.environ, LIVE_CACHE_DIR=name)
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # a person's start reads compiled modules
        cold = _film(folder, environment)
        warm = _median(lambda: _film(folder, environment), repeats)
        play = _median(lambda: _play(folder / "status.json", environment), repeats)
    return [
        Row("cold start to the first frame", cold[0], "s", COLD_BAR_S),
        Row("cold start to the first frame, processor", cold[1], "s"),
        Row("warm start to the first frame", warm[0], "s", WARM_BAR_S),
        Row("warm start to the first frame, processor", warm[1], "s", WARM_BAR_CPU_S),
        Row("warm start of live play to its first frame", play[0], "s", WARM_BAR_S),
        Row("warm start of live play to its first frame, processor", play[1], "s", WARM_BAR_CPU_S),
    ]


def _median(measure: Callable[[], Cost], repeats: int) -> Cost:
    costs = [measure() for _ in range(repeats)]
    return statistics.median(cost[0] for cost in costs), statistics.median(cost[1] for cost in costs)


def _film(folder: Path, environment: dict[str, str]) -> Cost:
    command = [
        sys.executable, "-m", "live", "render", "--seconds", "0.02", "--size", "320x180",
        "--out", str(folder / "first.mp4"),
    ]  # fmt: skip
    begin, before = time.perf_counter(), _ended_children_seconds()
    subprocess.run(command, env=environment, check=True, capture_output=True)
    return time.perf_counter() - begin, _ended_children_seconds() - before


def _ended_children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _play(status: Path, environment: dict[str, str]) -> Cost:
    """Return the time until the first frame, and what all processes have used until then."""
    status.unlink(missing_ok=True)
    command = [
        sys.executable, "-m", "live", "play", "--headless", "--osc", "127.0.0.1:0", "--status-json", str(status),
    ]  # fmt: skip
    used: list[Cost] = []
    begin = time.perf_counter()
    with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as show:
        try:
            while not (status.exists() and status.stat().st_size):
                used.append((time.perf_counter() - begin, _tree_seconds(psutil.Process(show.pid))))
                if show.poll() is not None or used[-1][0] > TIMEOUT_S:
                    raise RuntimeError(f"live play did not start; it ended with {show.poll()}")
                time.sleep(POLL_S)
            first = time.perf_counter() - begin - 1.0
        finally:
            show.send_signal(signal.SIGTERM)
    return first, max(processor for wall, processor in used if wall <= first)


def _tree_seconds(root: psutil.Process) -> float:
    """Return the processor time of a process and all below it, children that have ended included."""
    total = 0.0
    for process in (root, *root.children(recursive=True)):
        try:
            used = process.cpu_times()
        except psutil.NoSuchProcess:
            continue
        total += used.user + used.system + used.children_user + used.children_system
    return total
