"""Kernels: types are checked, nothing is compiled twice, code from disk does the same; all processes use one set."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from live.base import jit
from live.base import scalar_kernels as kernels
from live.base.disk import kernel_store as store
from live.motion.pose.foot_lock_kernels import farthest_shift
from tests.fixtures.mostly_long import mostly_long

compiled_only = pytest.mark.skipif(jit.JIT_DISABLED, reason="NUMBA_DISABLE_JIT=1: nothing is compiled")

DAMPER = """
import sys
from live.base import jit
from live.base.scalar_kernels import damper
print(damper.load(), jit.KERNEL_STORE.has(damper.file_name), damper(0.25, 1.5, 0.3, 0.1), jit.KERNEL_TARGET)
"""


INTERRUPTED = """
import signal
from llvmlite.binding.executionengine import ExecutionEngine
from live.base.scalar_kernels import damper
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
find = ExecutionEngine._find_module_ptr
def interrupt(self, module):
    ExecutionEngine._find_module_ptr = find
    signal.raise_signal(signal.SIGINT)
    return find(self, module)
ExecutionEngine._find_module_ptr = interrupt
try:
    damper.prepare()
    print("went on")
except KeyboardInterrupt:
    print("interrupted", damper.ready, signal.getsignal(signal.SIGINT) is signal.default_int_handler)
"""


def run_damper(folder: Path, **environment: str) -> list[str]:
    """Return whether it was loaded before the call, whether it is on disk, its value, and the processor."""
    done = subprocess.run(
        [sys.executable, "-c", DAMPER], capture_output=True, text=True, check=True,
        env={**os.environ, "LIVE_CACHE_DIR": str(folder), **environment},
    )  # fmt: skip
    return done.stdout.split()


@compiled_only
@pytest.mark.parametrize(
    "lock",
    [np.zeros((1, 2, 16)), np.zeros((1, 2, 32), np.float32)[:, :, ::2], np.zeros((2, 16), np.float32)],
    ids=["float64", "strided", "flat"],
)
@pytest.mark.parametrize("prepared", [False, True])
def test_wrong_array_raises_type_error_without_compilation(lock: np.ndarray, prepared: bool) -> None:
    if prepared:
        farthest_shift.prepare()
    with pytest.raises(TypeError):
        farthest_shift(lock)
    assert len(farthest_shift.overloads) == 1
    assert farthest_shift(np.zeros((1, 2, 16), np.float32)) == 0.0


THREADS = """
import sys, threading
from live.base import jit
from live.base.scalar_kernels import damper
sys.setswitchinterval(1e-6)
start, values = threading.Barrier(8), []
def call():
    start.wait()
    values.append(damper(0.25, 1.5, 0.3, 0.1))
threads = [threading.Thread(target=call) for _ in range(8)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(len(values), len(set(values)))
"""


@compiled_only
@mostly_long("compiled", [False, True], quick=[])
def test_several_threads_may_call_a_kernel_for_the_first_time(tmp_path: Path, compiled: bool) -> None:
    if compiled:
        run_damper(tmp_path)
    for _ in range(3):
        done = subprocess.run(
            [sys.executable, "-c", THREADS], capture_output=True, text=True, check=True,
            env={**os.environ, "LIVE_CACHE_DIR": str(tmp_path)},
        )  # fmt: skip
        assert done.stdout.split() == ["8", "1"], done.stderr


@compiled_only
def test_ctrl_c_while_a_kernel_is_loaded_ends_the_program(tmp_path: Path) -> None:
    """LLVM asks for the code by a call into Python, where an exception would be printed and lost."""
    told = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=True,
        env={**os.environ, "LIVE_CACHE_DIR": str(tmp_path)},
    )  # fmt: skip
    assert (told.stdout.split(), told.stderr) == (["interrupted", "True", "True"], "")


@pytest.mark.long
@compiled_only
def test_a_kernel_is_compiled_at_its_first_call_and_loaded_afterwards(tmp_path: Path) -> None:
    first = run_damper(tmp_path)
    assert first[:2] == ["False", "False"]
    (path,) = (path for path in tmp_path.rglob("*.damper") if path.parent.name != "locks")
    written = path.stat().st_mtime_ns
    assert run_damper(tmp_path) == ["True", "True", *first[2:]]
    assert path.stat().st_mtime_ns == written
    assert path.stat().st_mode & 0o077 == 0  # machine code: for this user alone


@compiled_only
@mostly_long(
    "damage",
    ["cut", "flipped", *(pytest.param(one, marks=pytest.mark.long) for one in ("empty", "foreign"))],
    quick=[0],
)
def test_a_damaged_kernel_is_compiled_again(tmp_path: Path, damage: str) -> None:
    value = run_damper(tmp_path)[2]
    (path,) = (path for path in tmp_path.rglob("*.damper") if path.parent.name != "locks")
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    path.write_bytes(
        {"cut": whole[: len(whole) // 2], "flipped": bytes(flipped), "empty": b"", "foreign": b"\x80\x04." * 99}[damage]
    )
    assert run_damper(tmp_path)[0] == "False"
    assert run_damper(tmp_path)[:3] == ["True", "True", value]


HALFWAY = """
import gc
from numba.core.codegen import JITCodeLibrary
from live.base.scalar_kernels import damper
finish = JITCodeLibrary._finalize_specific
def fail(library):
    if "damper" in library.name:
        raise MemoryError
    finish(library)
JITCodeLibrary._finalize_specific = fail
failed = damper.load()
JITCodeLibrary._finalize_specific = finish
gc.collect()
print(failed, damper.load(), damper(0.25, 1.5, 0.3, 0.1))
"""


@pytest.mark.long
@compiled_only
def test_loading_that_fails_halfway_does_not_disturb_the_next_one(tmp_path: Path) -> None:
    """LLVM has the module by then, and asks its owner for code when it next compiles."""
    value = run_damper(tmp_path)[2]
    done = subprocess.run(
        [sys.executable, "-c", HALFWAY], capture_output=True, text=True, check=True,
        env={**os.environ, "LIVE_CACHE_DIR": str(tmp_path)},
    )  # fmt: skip
    assert done.stdout.split() == ["False", "True", value]
    assert done.stderr == ""


@pytest.mark.long
@compiled_only
def test_code_from_disk_can_be_called_by_kernels_that_are_compiled(tmp_path: Path) -> None:
    """A kernel that calls another is compiled in a process that has the other one from disk."""
    run_damper(tmp_path)
    (tmp_path / "outer.py").write_text(
        "from live.base.jit import kernel\nfrom live.base.scalar_kernels import damper\n"
        '@kernel("f8(f8, f8)")\ndef twice(a, b):\n    return 2.0 * damper(a, b, 0.3, 0.1)\n'
        "print(damper.load(), twice(0.25, 1.5), 2.0 * damper(0.25, 1.5, 0.3, 0.1))\n"
    )
    done = subprocess.run(
        [sys.executable, str(tmp_path / "outer.py")], capture_output=True, text=True, check=True,
        env={**os.environ, "LIVE_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(Path(jit.__file__).parents[2])},
    )  # fmt: skip
    loaded, outer, inner = done.stdout.split()
    assert loaded == "True"
    assert outer == inner


@pytest.mark.long
@compiled_only
def test_code_for_a_level_of_processors_gives_the_same_and_is_kept_apart(tmp_path: Path) -> None:
    native = run_damper(tmp_path)
    levels = store.processor_levels(jit.host_processor()[2])
    if not levels:
        pytest.skip("kernels are shipped for no level of this processor")
    for level in levels:
        found = run_damper(tmp_path, LIVE_KERNEL_TARGET=level)
        assert found == ["False", "False", native[2], level]
    assert len([path for path in tmp_path.rglob("*.damper") if path.parent.name != "locks"]) == 1 + len(levels)


@pytest.mark.long
@compiled_only
def test_shipped_kernels_are_taken_until_native_ones_are_complete(tmp_path: Path) -> None:
    """A package like the companion wheel's; then all kernels of this machine's own."""
    levels = store.processor_levels(jit.host_processor()[2])
    if not levels:
        pytest.skip("kernels are shipped for no level of this processor")
    run_damper(tmp_path / "made", LIVE_KERNEL_TARGET=levels[0])
    package = tmp_path / store.SHIPPED_PACKAGE
    package.mkdir()
    (package / "__init__.py").touch()
    (tmp_path / "made" / "kernels" / jit.set_name(levels[0])).rename(package / jit.set_name(levels[0]))
    path = f"{tmp_path}{os.pathsep}{Path(jit.__file__).parents[2]}"
    environment = {"PYTHONPATH": path, "LIVE_KERNEL_TARGET": ""}
    mark = store.KernelStore((package / jit.set_name(levels[0]),)).complete_mark
    assert run_damper(tmp_path / "own", **environment)[3] == "native"  # not complete: not taken
    mark.touch()
    assert run_damper(tmp_path / "other", **environment)[0::3] == ["True", levels[0]]
    mark.rename(mark.with_name("complete-0123456789abcdef"))  # of other sources
    assert run_damper(tmp_path / "third", **environment)[3] == "native"
    mark.with_name("complete-0123456789abcdef").rename(mark)
    run_damper(tmp_path / "other", LIVE_KERNEL_TARGET="native")
    store.KernelStore((tmp_path / "other" / "kernels" / jit.set_name("native"),)).complete_mark.touch()
    assert run_damper(tmp_path / "other", **environment)[0::3] == ["True", "native"]


def test_every_kernel_file_is_found() -> None:
    assert kernels.__file__ in [str(path) for path in store.kernel_files()]


def test_kernels_import_their_sources_by_full_name() -> None:
    """`sources_of` reads ``from live.… import …`` at the beginning of a line: other import forms are not allowed."""
    for path in store.kernel_files():
        text = path.read_text(encoding="utf-8")
        for line in re.findall(r"^.*\blive[.\w]*.*\bimport\b.*$|^.*\bimport\b.*\blive\b.*$", text, re.MULTILINE):
            assert re.match(r"from live\.[\w.]+ import", line), f"{path}: {line}"
        for module in re.findall(r"^from (live\.[\w.]+) import", text, re.MULTILINE):
            source = Path(jit.__file__).parents[2].joinpath(*module.split(".")).with_suffix(".py")
            assert source in store.sources_of(path), f"{path}: {module} is a package or missing"
