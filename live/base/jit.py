"""Interface to numba: kernels with explicit signatures, cached on disk under a hash of their sources.

A lazy kernel silently recompiles for a read-only, strided or float64 array, which costs about forty frames during a
show. Here every kernel states its types, so it is compiled when its module is imported, and a wrong array raises
TypeError. numba's disk cache does not notice an edit in *another* file that a kernel calls; therefore the cache folder
of each file's kernels carries a hash of that file and of all that it imports from others.
"""

import hashlib
import os
import re
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import platformdirs

_PACKAGE = Path(__file__).resolve().parent.parent
Function = TypeVar("Function", bound=Callable[..., Any])

compile_listeners: list[Callable[[str], None]] = []
"""Callbacks that receive each kernel's name once it is compiled (for progress bars)."""


_IMPORT = re.compile(r"^from (live\.[\w.]+) import", re.MULTILINE)


def kernel_files() -> list[Path]:
    """Return all files with kernels, in a fixed order: every ``*kernels.py`` of the package."""
    return sorted(_PACKAGE.rglob("*kernels.py"))


def kernel_count() -> int:
    """Return the number of all kernels, for the length of a progress bar."""
    return sum(path.read_text(encoding="utf-8").count("\n@kernel(") for path in kernel_files())


def sources_of(path: Path) -> list[Path]:
    """Return a file of kernels and all files whose code or constants are compiled into them, in a fixed order.

    Imports of kernel files are followed recursively. Of any other file only the text counts, as kernels take only
    constants from there.
    """
    found: set[Path] = set()
    waiting = [path]
    while waiting:
        file = waiting.pop()
        if file in found or not file.is_file():
            continue
        found.add(file)
        if file.stem.endswith("kernels"):
            modules = _IMPORT.findall(file.read_text(encoding="utf-8"))
            waiting += [_PACKAGE.parent.joinpath(*module.split(".")).with_suffix(".py") for module in modules]
    return sorted(found)


def cache_root() -> Path:
    """Return the folder for compiled kernels; `LIVE_CACHE_DIR` overrides the user's cache directory."""
    return Path(os.environ.get("LIVE_CACHE_DIR") or platformdirs.user_cache_dir("choreographics-live")) / "kernels"


@cache
def cache_name(path: Path) -> str:
    """Return the cache folder of one file's kernels: it depends on its sources, on Python and on bounds checking."""
    digest = hashlib.sha256(sys.version.encode())
    if BOUNDS_CHECKED:
        digest.update(b"bounds")
    for source in sources_of(path):
        digest.update(source.read_bytes())
    inside = path.relative_to(_PACKAGE) if path.is_relative_to(_PACKAGE) else Path(path.name)  # a bench's kernel is not
    name = ".".join(inside.with_suffix("").parts)
    return f"{name}-{digest.hexdigest()[:16]}"


def _writable_root() -> Path:
    root = cache_root()
    try:
        root.mkdir(parents=True, exist_ok=True)
        if not os.access(root, os.W_OK):
            raise PermissionError(root)
    except OSError:  # a read-only home: the show still starts, and compiles again the next time
        root = Path(tempfile.gettempdir()) / "choreographics-live-kernels"
        root.mkdir(parents=True, exist_ok=True)
    return root


KERNEL_CACHE_DIR = _writable_root()
"""The folder of this process's compiled kernels."""

os.environ["NUMBA_CACHE_DIR"] = str(KERNEL_CACHE_DIR)
import numba  # noqa: E402 - its cache directory has to be set first

JIT_DISABLED = bool(numba.config.DISABLE_JIT)
BOUNDS_CHECKED = bool(numba.config.BOUNDSCHECK)
"""Set by `NUMBA_BOUNDSCHECK=1`: a kernel that reads or writes beyond an array raises IndexError."""


def kernel(signature: str, **options: Any) -> Callable[[Function], Function]:
    """Compile a function for one signature, e.g. ``"void(f4[:,::1], f4)"``; nogil, cached, IEEE division.

    The caller owns every array; a kernel allocates nothing that outlives it and raises nothing.
    With `NUMBA_DISABLE_JIT=1` the plain Python function remains; with `NUMBA_BOUNDSCHECK=1` (`make test-bounds`) the
    compiled one checks its indices.
    """

    def compile_(function: Function) -> Function:
        numba.config.CACHE_DIR = str(KERNEL_CACHE_DIR / cache_name(Path(function.__code__.co_filename).resolve()))
        compiled: Function = numba.njit(signature, cache=True, nogil=True, error_model="numpy", **options)(function)
        for listener in compile_listeners:
            listener(function.__name__)
        return compiled

    return compile_


def inline_kernel(function: Function) -> Function:
    """Mark a function that is inlined into each kernel that calls it; only kernels may call it.

    It has no compiled form, so it needs no signature. Inlining also keeps the known lengths of arrays that a kernel
    makes, which vectorisation depends on.
    """
    inlined: Function = numba.njit(nogil=True, error_model="numpy", inline="always")(function)
    return inlined
