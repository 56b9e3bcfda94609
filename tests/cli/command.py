"""Running the command `live` as people do: in a process of its own."""

import os
import subprocess
import sys


def run_live(*arguments: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run `live ARGUMENTS` without a terminal; `environment` is added to ours."""
    return subprocess.run(
        [sys.executable, "-m", "live", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env={**os.environ, "COLUMNS": "160", "NO_COLOR": "1", **environment},
    )
