"""`live warm`: compiles once, names every kernel, and does nothing on the second run."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from live.base import jit
from tests.cli.command import WITHOUT_TERMINAL

FEW = """
from pathlib import Path
from live.base import jit
from live.cli.main import main
files = ("base/scalar_kernels.py", "motion/yaw_kernels.py")
jit.kernel_files = lambda: [Path(jit.__file__).parents[1] / name for name in files]
main()
"""
"""The command in a project whose only kernels are those of two files, because to compile all takes minutes."""


def warm(cache: Path, *options: str) -> "subprocess.CompletedProcess[str]":
    done = subprocess.run(
        [sys.executable, "-c", FEW, "warm", *options],
        capture_output=True, text=True, check=False,
        env={**os.environ, **WITHOUT_TERMINAL, "LIVE_CACHE_DIR": str(cache)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.long
@pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")
def test_warm_compiles_once_and_writes_stamp(tmp_path: Path) -> None:
    package = Path(jit.__file__).parents[1]
    count = sum(
        (package / name).read_text().count("\n@kernel(") for name in ("base/scalar_kernels.py", "motion/yaw_kernels.py")
    )
    stamp = tmp_path / "stamp"
    first = warm(tmp_path / "cache", "--stamp", str(stamp))
    assert f"{count}/{count}" in first.stderr  # the bar reached its end
    assert re.search(rf"^{count} kernels ready in", first.stderr, re.MULTILINE)

    folder = Path(stamp.read_text().strip()).parent
    assert folder == tmp_path / "cache" / "kernels"
    compiled = {path: path.stat().st_mtime_ns for path in folder.rglob("*.nbc")}
    assert len(compiled) == count

    second = warm(tmp_path / "cache")
    assert "Compiling" not in second.stderr
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.nbc")} == compiled


@pytest.mark.long
@pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_interrupted_warm_prints_one_line(tmp_path: Path, name: str, code: int) -> None:
    """The signal comes at the worst moment: in the middle of numba's work on the second kernel."""
    tripped = FEW.replace(
        "main()\n",
        f"""
import os, signal
from numba.core import codegen
finalize, calls = codegen.CPUCodeLibrary.finalize, []
def trip(self):
    calls.append(1)
    if len(calls) == 2:
        os.kill(os.getpid(), signal.{name})
    return finalize(self)
codegen.CPUCodeLibrary.finalize = trip
main()
""",
    )
    done = subprocess.run(
        [sys.executable, "-c", tripped, "warm"],
        capture_output=True, text=True, check=False,
        env={**os.environ, **WITHOUT_TERMINAL, "LIVE_CACHE_DIR": str(tmp_path / "cache")},
    )  # fmt: skip
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.splitlines()[-1] == "stopped; the next start compiles the remaining kernels"
    assert list((tmp_path / "cache").rglob("*.nbc"))  # what was ready is kept
    assert not list((tmp_path / "cache").rglob("ready-*"))
