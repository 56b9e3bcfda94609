"""The one door to numba: kernels with explicit signatures, kept on disk under names that follow their sources.

A lazy kernel recompiles without a word when it meets a read-only, strided or float64 array, and forty frames are
lost on stage. Here every kernel names its types, so it is compiled when its module is imported and a wrong array
is a TypeError. numba's disk cache does not see an edit in *another* file that a kernel calls; therefore the folder
in which the kernels of a file are kept carries a hash of that file and of all that it takes from others.
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

kernel_compiled: list[Callable[[str], None]] = []
"""Called with a kernel's name each time one is ready (progress bars listen here)."""


_IMPORT = re.compile(r"^from (live\.[\w.]+) import", re.MULTILINE)


def kernel_files() -> list[Path]:
    """All files that hold kernels, in a fixed order: every ``kernels.py`` of the package."""
    return sorted(_PACKAGE.rglob("*kernels.py"))


def kernel_count() -> int:
    """How many kernels there are in all, for the length of a progress bar."""
    return sum(path.read_text(encoding="utf-8").count("\n@kernel(") for path in kernel_files())


def sources_of(path: Path) -> list[Path]:
    """A file of kernels and all files whose code or numbers are written into them, in a fixed order.

    Other files of kernels are followed to their own sources; of any other file only its text counts: kernels take
    plain numbers from there.
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
    """Where compiled kernels are kept; `LIVE_CACHE_DIR` overrides the user's cache directory."""
    return Path(os.environ.get("LIVE_CACHE_DIR") or platformdirs.user_cache_dir("choreographics-live")) / "kernels"


@cache
def cache_name(path: Path) -> str:
    """The folder for the kernels of one file: it changes with its sources, with Python and with checked bounds."""
    digest = hashlib.sha256(sys.version.encode())
    if BOUNDS_CHECKED:
        digest.update(b"bounds")
    for source in sources_of(path):
        digest.update(source.read_bytes())
    name = ".".join(path.relative_to(_PACKAGE).with_suffix("").parts)
    return f"{name}-{digest.hexdigest()[:16]}"


def _writable_root() -> Path:
    root = cache_root()
    try:
        root.mkdir(parents=True, exist_ok=True)
        if not os.access(root, os.W_OK):
            raise PermissionError(root)
    except OSError:  # a read-only home: the show starts all the same, and compiles again the next time
        root = Path(tempfile.gettempdir()) / "choreographics-live-kernels"
        root.mkdir(parents=True, exist_ok=True)
    return root


KERNELS = _writable_root()
"""The folder of this process's compiled kernels."""

os.environ["NUMBA_CACHE_DIR"] = str(KERNELS)
import numba  # noqa: E402 - its cache directory had to be named first

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
        numba.config.CACHE_DIR = str(KERNELS / cache_name(Path(function.__code__.co_filename).resolve()))
        compiled: Function = numba.njit(signature, cache=True, nogil=True, error_model="numpy", **options)(function)
        for listener in kernel_compiled:
            listener(function.__name__)
        return compiled

    return compile_


def part(function: Function) -> Function:
    """A part of kernels, written into each kernel that calls it; only kernels may call it.

    It has no compiled form, so it needs no signature; and the arrays that a kernel makes keep their known lengths in
    it, without which rows could not be told apart and nothing would be vectorised.
    """
    inlined: Function = numba.njit(nogil=True, error_model="numpy", inline="always")(function)
    return inlined
