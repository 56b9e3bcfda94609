"""`live warm`: compiles once, names every kernel, is quick and quiet afterwards."""

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
jit.kernel_files = lambda: [Path(jit.__file__).parents[1] / name / "kernels.py" for name in ("base", "motion")]
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


@pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")
def test_warm_compiles_once_and_leaves_its_mark_in_the_stamp(tmp_path: Path) -> None:
    package = Path(jit.__file__).parents[1]
    count = sum((package / name / "kernels.py").read_text().count("\n@kernel(") for name in ("base", "motion"))
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
