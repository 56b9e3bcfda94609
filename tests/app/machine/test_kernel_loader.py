"""Kernels behind a running show: one a frame, none in a frame; a rehearsal leaves the show as it was."""

from pathlib import Path

import pytest

from live.app.machine import kernel_build, kernel_loader, kernel_warmup
from live.app.machine.kernel_loader import KernelLoader, rehearse_show
from live.base import jit
from live.base.disk.kernel_store import KernelStore, ShowLock, writable_root
from live.base.jit import KERNEL_SET, Kernel, kernels
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH

pytestmark = pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")


def test_one_kernel_is_loaded_in_a_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel_build.all_kernels()
    monkeypatch.setattr(kernel_loader, "is_warm", lambda: True)
    monkeypatch.setattr(Kernel, "ready", property(lambda self: False))
    loaded: list[Kernel] = []
    monkeypatch.setattr(Kernel, "load", lambda self: loaded.append(self) or True)
    loader = KernelLoader()
    counts = []
    for _ in range(len(kernels) + len(kernel_build.kernel_modules()) + 10):
        before = len(loaded)
        loader.frame()
        counts.append(len(loaded) - before)
    assert max(counts) == 1
    assert loaded == kernels
    assert not loader.compiles
    loader.close()


class _Build:
    """A build that takes three frames."""

    total, done = 3, 0

    def update(self, timeout: float) -> bool:
        assert timeout == 0.0  # the frame does not wait
        self.done += 1
        return self.done >= self.total

    def close(self) -> None:
        self.closed = True


@pytest.mark.parametrize("kept", [True, False])
def test_nothing_is_loaded_while_kernels_are_compiled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kept: bool
) -> None:
    store = KernelStore((tmp_path / KERNEL_SET,))
    monkeypatch.setattr(kernel_loader, "KERNEL_STORE", store)
    monkeypatch.setattr(KernelStore, "has", lambda self, name: kept)
    monkeypatch.setattr(kernel_loader, "is_warm", lambda: False)
    build = _Build()
    monkeypatch.setattr(kernel_loader, "KernelBuild", lambda *_, **__: build)
    loader = KernelLoader()
    states = []
    for _ in range(4):
        states.append((loader.compiles, bool(loader.notice)))
        loader.frame()
    assert states == [(True, True), (True, True), (True, True), (False, False)]
    assert build.closed
    loader.close()
    assert store.is_complete() == kept  # a disk that keeps nothing is not said to be complete


@pytest.mark.long
def test_a_rehearsal_leaves_the_show_as_it_was() -> None:
    loaded = load_show(DEFAULT_PATCH)

    def hashes() -> list[str]:
        show = loaded.start(seed=3)
        found = []
        for tick in range(200):
            show.tick(tick / 64)
            found.append(show.state_hash())
        return found

    before = hashes()
    rehearse_show(loaded, 3)
    assert hashes() == before


def test_no_kernel_is_compiled_beside_a_show(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    writable_root.cache_clear()
    try:
        assert not ShowLock.is_taken()
        lock = ShowLock()
        lock.take()
        assert ShowLock.is_taken()
        updates: list[float] = []

        class Build(_Build):
            def __enter__(self) -> "Build":
                return self

            def __exit__(self, *_: object) -> None:
                pass

            def update(self, timeout: float) -> bool:
                updates.append(timeout)
                return True

        monkeypatch.setattr(kernel_build, "KernelBuild", lambda *_, **__: Build())
        kernel_warmup.compile_between_shows()
        assert updates == []
        lock.release()
        assert not ShowLock.is_taken()
    finally:
        writable_root.cache_clear()
