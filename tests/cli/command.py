"""Running the command `live` as people do: in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path


def run_live(*arguments: str, cwd: Path | None = None, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run `live ARGUMENTS` without a terminal in the folder `cwd`; `environment` is added to ours."""
    return subprocess.run(
        [sys.executable, "-m", "live", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=cwd,
        env={**os.environ, "COLUMNS": "160", "NO_COLOR": "1", **environment},
    )
