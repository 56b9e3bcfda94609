"""Starting: from the command to the first frame, with compiled kernels (warm) and without (cold)."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from live.cli.bench import Row

WARM_BAR_S = 3.0


def run(full: bool, shared: Path | None) -> list[Row]:
    """Wall-clock seconds of `live render` of one frame at 320x180, a whole process each; the best of the runs."""
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, LIVE_CACHE_DIR=folder)
        cold = _seconds(Path(folder), environment)
        warm = min(_seconds(Path(folder), environment) for _ in range(5 if full else 3))
    return [
        Row("cold start to the first frame", cold, "s"),
        Row("warm start to the first frame", warm, "s", WARM_BAR_S),
    ]


def _seconds(folder: Path, environment: dict[str, str]) -> float:
    command = [
        sys.executable, "-m", "live", "render", "--seconds", "0.02", "--size", "320x180",
        "--out", str(folder / "first.mp4"),
    ]  # fmt: skip
    begin = time.perf_counter()
    subprocess.run(command, env=environment, check=True, capture_output=True)
    return time.perf_counter() - begin
