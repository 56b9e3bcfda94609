"""`live warm`: compiles once, names every kernel, is quick and quiet afterwards."""

import re
from pathlib import Path

import pytest

from live.base import jit
from tests.cli.command import run_live


@pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")
def test_warm_compiles_once_and_leaves_its_mark_in_the_stamp(tmp_path: Path) -> None:
    stamp = tmp_path / "stamp"
    first = run_live("warm", "--stamp", str(stamp), LIVE_CACHE_DIR=str(tmp_path / "cache"))
    assert first.returncode == 0, first.stderr
    count = jit.kernel_count()
    assert f"{count}/{count}" in first.stderr  # the bar reached its end
    assert re.search(rf"^{count} kernels ready in", first.stderr, re.MULTILINE)

    folder = Path(stamp.read_text().strip()).parent
    assert folder == tmp_path / "cache" / "kernels"
    compiled = {path: path.stat().st_mtime_ns for path in folder.rglob("*.nbc")}
    assert len(compiled) == count

    second = run_live("warm", LIVE_CACHE_DIR=str(tmp_path / "cache"))
    assert "Compiling" not in second.stderr
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.nbc")} == compiled
