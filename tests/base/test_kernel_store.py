"""Compiled kernels on disk: named by content, checked, private, for one process at a time to make."""

import multiprocessing
import os
import re
import shutil
import stat
import tempfile
import time
from pathlib import Path

import pytest

from live.base.disk import kernel_store
from live.base.disk.kernel_store import (
    KernelStore,
    ShowLock,
    content_name,
    make_private,
    processor_levels,
    writable_root,
)
from live.base.system import file_lock
from live.base.system.file_lock import lock_file

as_other_user = pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owner here")


def test_names_depend_on_a_file_and_its_imports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An edit renames the kernels of its importers only."""
    package = tmp_path / "live"
    texts = {
        "a/kernels.py": "from live.b.kernels import part_of\n",
        "b/kernels.py": "from live.c import NUMBER\n",
        "c.py": "from live.d import OTHER\nNUMBER = 1\n",
        "d.py": "OTHER = 1\n",
        "e/kernels.py": "import math\n",
    }
    for name, text in texts.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    monkeypatch.setattr(kernel_store, "_PACKAGE", package)

    def names() -> dict[str, str]:
        content_name.cache_clear()
        kernel_store._text.cache_clear()
        return {folder: content_name(package / folder / "kernels.py") for folder in "abe"}

    before = names()
    (package / "c.py").write_text("from live.d import OTHER\nNUMBER = 2\n")
    after = names()
    assert {folder for folder in "abe" if after[folder] != before[folder]} == {"a", "b"}
    (package / "e/kernels.py").write_text("import numpy\n")
    again = names()
    assert {folder for folder in "abe" if again[folder] != after[folder]} == {"e"}


def test_a_kernel_outside_of_the_package_has_its_own_name(tmp_path: Path) -> None:
    """Those of a bench, for example."""
    file = tmp_path / "bench.py"
    file.write_text("")
    assert re.fullmatch(r"bench-[0-9a-f]{16}", content_name(file))


def test_what_is_written_is_read_and_folders_before_the_last_are_only_read(tmp_path: Path) -> None:
    shipped, own = KernelStore((tmp_path / "shipped",)), KernelStore((tmp_path / "shipped", tmp_path / "own"))
    shipped.write("a", b"from the wheel")
    own.write("b", b"compiled here")
    assert (own.read("a"), own.read("b"), own.read("c")) == (b"from the wheel", b"compiled here", None)
    assert [own.has(name) for name in "abc"] == [True, True, False]
    assert sorted(path.name for path in (tmp_path / "shipped").iterdir()) == ["a"]


def test_full_and_read_only_disks_are_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    store = KernelStore((blocked / "kernels",))
    store.write("a", b"x")
    store.mark_complete([])
    with store.compiling("a"):
        pass
    assert store.read("a") is None

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    there = KernelStore((tmp_path / "there",))
    monkeypatch.setattr(os, "replace", full)
    there.write("a", b"x")
    assert there.read("a") is None
    assert list((tmp_path / "there").iterdir()) == []  # the half of a file is gone


@as_other_user
def test_folders_of_others_are_refused_and_open_ones_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    open_one = tmp_path / "open"
    open_one.mkdir()
    open_one.chmod(0o777)
    assert make_private(open_one)
    assert stat.S_IMODE(open_one.stat().st_mode) == 0o700
    monkeypatch.setattr(os, "getuid", lambda: open_one.stat().st_uid + 1)
    assert not make_private(open_one)


@as_other_user
def test_a_link_among_the_temporary_files_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody else may have put it there before."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "file"))
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / "theirs").mkdir()
    planted = tmp_path / f"choreographics-live-kernels-{os.getuid()}"
    planted.symlink_to(tmp_path / "theirs")
    writable_root.cache_clear()
    try:
        found = writable_root()
    finally:
        writable_root.cache_clear()
    assert found.parent == tmp_path
    assert found != planted
    assert found.resolve() != (tmp_path / "theirs").resolve()


def test_old_kernels_of_other_sources_go_and_present_ones_stay(tmp_path: Path) -> None:
    store = KernelStore((tmp_path,))
    present = f"{content_name(kernel_store.kernel_files()[0])}.function"
    long_ago = time.time() - 100 * 86_400.0
    for name in (present, "live.gone-0123456789abcdef.function", "complete-0123456789abcdef", "new-0123456789abcdef.f"):
        store.write(name, b"")
        if not name.startswith("new"):
            os.utime(tmp_path / name, (long_ago, long_ago))
    store.mark_complete([present, "lacks"])
    assert not store.is_complete()
    store.mark_complete([present])
    store.drop_old()
    assert store.is_complete()
    assert {path.name for path in tmp_path.iterdir()} == {present, "new-0123456789abcdef.f", store.complete_mark.name}


def _compile_slowly(
    folder: Path, begun: "multiprocessing.synchronize.Event", go: "multiprocessing.synchronize.Event"
) -> None:
    store = KernelStore((folder,))
    with store.compiling("a"):
        begun.set()
        go.wait(30.0)
        store.write("a", b"theirs")


@pytest.mark.long
def test_a_process_waits_for_the_one_that_compiles(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    begun, go = context.Event(), context.Event()
    other = context.Process(target=_compile_slowly, args=(tmp_path, begun, go))
    other.start()
    assert begun.wait(30.0)
    store = KernelStore((tmp_path,))
    assert store.read("a") is None
    go.set()
    with store.compiling("a"):
        assert store.read("a") == b"theirs"
    other.join(30.0)
    assert other.exitcode == 0


def test_levels_of_processors() -> None:
    v3 = dict.fromkeys(("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"), True)
    v4 = dict.fromkeys(("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"), True)
    assert processor_levels({**v3, **v4}) == ["x86-64-v4", "x86-64-v3"]
    assert processor_levels({**v3, **v4, "avx512vl": False}) == ["x86-64-v3"]
    assert processor_levels({**v3, **v4, "avx2": False}) == []
    assert processor_levels({}) == []


def test_where_nothing_can_be_written_nothing_is_kept_and_nothing_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "file"))
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "file"))
    writable_root.cache_clear()
    try:
        found = writable_root()
    finally:
        writable_root.cache_clear()
    store = KernelStore((found,))
    store.write("kernel", b"code")
    assert store.read("kernel") is None


def test_clear_removes_what_shows_keep_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    temporary = tmp_path / "temporary"
    monkeypatch.setattr(kernel_store.tempfile, "gettempdir", lambda: str(temporary))
    cache = tmp_path / "cache"
    monkeypatch.setenv("LIVE_CACHE_DIR", str(cache))
    kernels = KernelStore((cache / "kernels" / "set",))
    kernels.write("a", b"code")
    arrays = cache / "steps-0123456789abcdef.npz"
    mine = cache / "my-dance.npz"
    for path in (arrays, mine):
        path.write_bytes(b"")
    spare = kernel_store._temporary_root()
    spare.mkdir(parents=True)
    another = Path(tempfile.mkdtemp(prefix=f"{spare.name}-", dir=temporary))  # as where the spare one is no folder
    assert set(kernel_store.clear_cache()) == {cache / "kernels", arrays, spare, another}
    assert list(cache.iterdir()) == [mine]
    mine.unlink()
    assert kernel_store.clear_cache() == []
    assert not cache.exists()
    assert temporary.exists()


def test_clear_leaves_folders_of_other_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_store.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    user = kernel_store.user_number()
    if user is None:
        pytest.skip("files have no owner's number here")
    monkeypatch.setattr(kernel_store, "user_number", lambda: user + 1)
    spare = kernel_store._temporary_root()  # somebody else was first to take the name
    spare.mkdir()
    assert kernel_store.clear_cache() == []
    assert spare.exists()


def test_clear_deletes_nothing_of_a_show_that_runs_and_none_begins_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_store.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    kernels = tmp_path / "cache" / "kernels"
    spare = kernel_store._temporary_root()
    (kernels / "set").mkdir(parents=True)
    spare.mkdir()
    with (spare / "show").open("wb") as show:
        lock_file(show, shared=True)
        with pytest.raises(BlockingIOError):
            kernel_store.clear_cache()
    assert (kernels / "set").exists()
    remove = shutil.rmtree

    def remove_and_look(path: Path) -> None:
        if path.parent == kernels:
            with (kernels / "show").open("rb") as show, pytest.raises(BlockingIOError):
                lock_file(show, shared=True)
        remove(path)

    monkeypatch.setattr(kernel_store.shutil, "rmtree", remove_and_look)
    assert kernel_store.clear_cache() == [kernels, spare]


def test_clear_follows_no_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_store.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file").touch()
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "kernels").symlink_to(tmp_path / "other")
    assert kernel_store.clear_cache() == []
    assert (tmp_path / "other" / "file").exists()


def test_a_show_that_begins_waits_for_who_looks_whether_one_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    writable_root.cache_clear()
    show = ShowLock()
    try:
        look = (writable_root() / "show").open("wb")
        lock_file(look)
        monkeypatch.setattr(file_lock.time, "sleep", lambda _seconds: look.close())
        show.take()
        assert look.closed
        assert ShowLock.is_taken()
    finally:
        show.release()
        writable_root.cache_clear()
