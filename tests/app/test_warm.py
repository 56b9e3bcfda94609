"""`live warm`: compiles once, names every kernel, keeps what is ready; a first start compiles what it needs."""

import io
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from live.app.machine import kernel_build, kernel_warmup
from live.app.machine.kernel_build import FIRST_KERNELS, KernelBuild, all_kernels, kernel_name
from live.base import jit
from live.base.disk import kernel_store
from tests.cli.command import WITHOUT_TERMINAL

compiled_only = pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")

FEW = """
from pathlib import Path
from live.app.machine import kernel_build
from live.base.disk import kernel_store
from live.cli.main import main
files = ("base/scalar_kernels.py", "motion/pose/yaw_kernels.py")
found = [Path(kernel_store.__file__).parents[2] / name for name in files]
kernel_store.kernel_files = kernel_build.kernel_files = lambda: found
main()
"""
"""The command in a project whose only kernels are those of two files, because to compile all takes minutes."""
FEW_COUNT = 4


def warm(cache: Path, *options: str, code: str = FEW) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", code, "warm", *options],
        capture_output=True, text=True, check=False,
        env={**os.environ, **WITHOUT_TERMINAL, "LIVE_CACHE_DIR": str(cache)},
    )  # fmt: skip


def kept(cache: Path) -> dict[str, int]:
    """Return the kernels on disk and when each was written."""
    files = (path for path in (cache / "kernels").rglob("*_kernels-*.*") if path.parent.name != "locks")
    return {path.name: path.stat().st_mtime_ns for path in files}


@compiled_only
@pytest.mark.long
def test_warm_compiles_once_and_writes_stamp(tmp_path: Path) -> None:
    stamp = tmp_path / "stamp"
    first = warm(tmp_path / "cache", "--stamp", str(stamp))
    assert first.returncode == 0, first.stderr
    assert f"{FEW_COUNT}/{FEW_COUNT}" in first.stderr  # the bar reached its end
    assert re.search(rf"^{FEW_COUNT} kernels ready in", first.stderr, re.MULTILINE)
    mark = Path(stamp.read_text().strip())
    assert mark.exists()
    assert mark.parent.parent == tmp_path / "cache" / "kernels"
    compiled = kept(tmp_path / "cache")
    assert len(compiled) == FEW_COUNT

    second = warm(tmp_path / "cache")
    assert "Compiling" not in second.stderr
    assert kept(tmp_path / "cache") == compiled


@compiled_only
@pytest.mark.long
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_interrupted_warm_prints_one_line(tmp_path: Path, name: str, code: int) -> None:
    """The signal comes when one kernel is ready."""
    tripped = FEW.replace(
        "main()\n",
        f"""
import os, signal
take = kernel_build.KernelBuild._take_answer
def trip(self, worker):
    take(self, worker)
    if self.done == 1:
        os.kill(os.getpid(), signal.{name})
kernel_build.KernelBuild._take_answer = trip
main()
""",
    )
    done = warm(tmp_path / "cache", code=tripped)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.splitlines()[-1] == "stopped; the next start compiles the remaining kernels"
    assert kept(tmp_path / "cache")  # what was ready is kept
    assert not list((tmp_path / "cache").rglob("complete-*"))


@compiled_only
@pytest.mark.long
def test_a_worker_that_dies_costs_its_kernel_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(
        kernel_build, "KERNEL_STORE", kernel_store.KernelStore((tmp_path / "kernels" / jit.KERNEL_SET,))
    )
    wanted = [each for each in all_kernels() if "scalar_kernels" in each.file_name or "yaw_kernels" in each.file_name]
    with KernelBuild(wanted, workers=2) as build:
        os.kill(build._workers[0].process.pid, signal.SIGKILL)
        for _ in range(600):
            if build.update(0.2):
                break
        assert (build.done, len(build.failed)) == (FEW_COUNT - 1, 1)


def test_kernels_that_are_called_come_before_those_that_call_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """The order of a whole build, without workers: every callee is at least as urgent as its callers."""
    if jit.JIT_DISABLED:
        pytest.skip("NUMBA_DISABLE_JIT=1: nothing is compiled")
    monkeypatch.setattr(kernel_build, "KERNEL_STORE", kernel_store.KernelStore((Path("nothing here"),)))
    monkeypatch.setattr(KernelBuild, "_give_orders", lambda self: None)
    monkeypatch.setattr(kernel_build, "_Worker", lambda background: pytest.fail("no process is needed"))
    monkeypatch.setattr(kernel_build, "worker_count", lambda: 0)
    build = KernelBuild(all_kernels(), workers=0)
    place = {kernel: number for number, kernel in enumerate(build._left)}
    assert len(place) == build.total == len(all_kernels())
    called = [(kernel, each) for kernel, callees in build._calls.items() for each in callees]
    assert called
    assert [(a.file_name, b.file_name) for a, b in called if place[b] > place[a]] == []


def test_the_first_kernels_exist() -> None:
    """What they are is written by `tools/write_first_kernels.py`; a name that is gone would be compiled too late."""
    names = FIRST_KERNELS.read_text(encoding="utf-8").split()
    assert not jit.JIT_DISABLED or pytest.skip("NUMBA_DISABLE_JIT=1: nothing is compiled")
    assert set(names) - {kernel_name(each) for each in all_kernels()} == set()


@compiled_only
@pytest.mark.long
def test_the_first_kernels_are_those_that_the_default_show_uses() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import sys; sys.path.insert(0, 'tools')\nfrom write_first_kernels import used_kernels\n"
         "print('\\n'.join(used_kernels()))"],
        capture_output=True, text=True, check=True, cwd=Path(kernel_store.__file__).parents[3],
    )  # fmt: skip
    assert done.stdout.split() == FIRST_KERNELS.read_text(encoding="utf-8").split()


def test_kernels_that_are_kept_elsewhere_are_told_where(tmp_path, monkeypatch):
    store = kernel_store.KernelStore((tmp_path / "elsewhere",))
    for name, value in (("is_warm", lambda: False), ("_compile", lambda *_: 1), ("find_spec", lambda _: None)):
        monkeypatch.setattr(kernel_warmup, name, value)
    monkeypatch.setattr(kernel_build, "first_kernels", lambda: ())
    monkeypatch.setattr(jit, "KERNEL_STORE", store)
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "home"))
    console = Console(file=io.StringIO(), width=1000)
    kernel_warmup.warm_kernels(console)
    told = console.file.getvalue()
    assert f"{tmp_path / 'home' / 'kernels'} cannot be written" in told
    assert f"kept in {tmp_path / 'elsewhere'}" in told
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(jit, "KERNEL_STORE", kernel_store.KernelStore((tmp_path / "kernels" / "x",)))
    kernel_warmup.warm_kernels(console)
    assert console.file.getvalue() == told


@pytest.mark.long
def test_clear_deletes_the_cache_but_not_under_a_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / "cache"
    monkeypatch.setenv("LIVE_CACHE_DIR", str(cache))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    kernel_store.writable_root.cache_clear()
    show = kernel_store.ShowLock()
    show.take()
    refused = warm(cache, "--clear")
    assert refused.returncode == 2
    assert "a show runs" in refused.stderr
    assert (cache / "kernels").exists()
    show.release()
    kernel_store.writable_root.cache_clear()
    (cache / "mine").touch()
    for told in (f"deleted: {cache / 'kernels'}\n", "nothing to delete\n"):
        cleared = warm(cache, "--clear", code="from live.cli.main import main; main()")
        assert (cleared.returncode, cleared.stdout) == (0, told)
        assert list(cache.iterdir()) == [cache / "mine"]
