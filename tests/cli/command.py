"""Running the command `live`: within this process, or in a process of its own where the process matters."""

import contextlib
import io
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import numpy as np

from live.cli.main import main

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WITHOUT_TERMINAL = {"COLUMNS": "160", "NO_COLOR": "1"}


@contextlib.contextmanager
def _restore_process_state() -> Iterator[None]:
    """Restores what the command sets for a whole process: working folder, arguments, signals, numpy's error state."""
    folder, handlers = Path.cwd(), {number: signal.getsignal(number) for number in SIGNALS}
    try:
        with np.errstate():
            yield
    finally:
        os.chdir(folder)
        for number, handler in handlers.items():
            signal.signal(number, handler)


def run_live(*arguments: str, cwd: Path | None = None, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run `live ARGUMENTS` in this process, without a terminal, in the folder `cwd`; `environment` is added to ours.

    It goes through the whole of `main`: exit codes and messages are those of the command. For what a new process does
    differently (what it imports, what it reads from the environment once) there is `run_live_process`.
    """
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with (
        _restore_process_state(),
        mock.patch.dict(os.environ, {**WITHOUT_TERMINAL, **environment}),
        mock.patch.object(sys, "argv", ["live", *arguments]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        os.chdir(cwd or ".")
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
    return subprocess.CompletedProcess(["live", *arguments], code, out.getvalue(), err.getvalue())


def run_live_process(
    *arguments: str, cwd: Path | None = None, **environment: str
) -> "subprocess.CompletedProcess[str]":
    """Run `live ARGUMENTS` in a process of its own, which takes seconds to start."""
    return subprocess.run(
        [sys.executable, "-m", "live", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=cwd,
        env={**os.environ, **WITHOUT_TERMINAL, **environment},
    )
