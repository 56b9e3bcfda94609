"""The one door to numba: kernels with explicit signatures, kept on disk under a name that follows their sources.

A lazy kernel recompiles without a word when it meets a read-only, strided or float64 array, and forty frames are
lost on stage. Here every kernel names its types, so it is compiled when its module is imported and a wrong array
is a TypeError. numba's disk cache does not see an edit in *another* file that a kernel calls; therefore the cache
directory carries a hash of all kernel sources, and must be named before numba is loaded.
"""

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import platformdirs

_PACKAGE = Path(__file__).resolve().parent.parent
Function = TypeVar("Function", bound=Callable[..., Any])

kernel_compiled: list[Callable[[str], None]] = []
"""Called with a kernel's name each time one is ready (progress bars listen here)."""


CONSTANTS = ("agents/procedural/kinds.py", "agents/wants.py", "base/stage_view.py")
"""Files whose numbers are written into kernels; a test sees to it that none is missing."""


def kernel_files() -> list[Path]:
    """All files that hold kernels, in a fixed order: every ``kernels.py`` of the package."""
    return sorted(_PACKAGE.rglob("kernels.py"))


def kernel_count() -> int:
    """How many kernels there are in all, for the length of a progress bar."""
    return sum(path.read_text(encoding="utf-8").count("\n@kernel(") for path in kernel_files())


def cache_directory() -> Path:
    """Where compiled kernels are kept; `LIVE_CACHE_DIR` overrides the user's cache directory."""
    digest = hashlib.sha256(sys.version.encode())
    for path in (*kernel_files(), *(_PACKAGE / name for name in CONSTANTS)):
        digest.update(path.read_bytes())
    root = os.environ.get("LIVE_CACHE_DIR") or platformdirs.user_cache_dir("choreographics-live")
    return Path(root) / f"kernels-{digest.hexdigest()[:16]}"


def _name_cache_directory() -> None:
    directory = cache_directory()
    try:
        directory.mkdir(parents=True, exist_ok=True)
        if not os.access(directory, os.W_OK):
            raise PermissionError(directory)
    except OSError:  # a read-only home: the show starts all the same, and compiles again the next time
        directory = Path(tempfile.gettempdir()) / directory.name
        directory.mkdir(parents=True, exist_ok=True)
    os.environ["NUMBA_CACHE_DIR"] = str(directory)


_name_cache_directory()
import numba  # noqa: E402 - its cache directory had to be named first

JIT_DISABLED = bool(numba.config.DISABLE_JIT)


def kernel(signature: str, **options: Any) -> Callable[[Function], Function]:
    """Compile a function for one signature, e.g. ``"void(f4[:,::1], f4)"``; nogil, cached, IEEE division.

    The caller owns every array; a kernel allocates nothing that outlives it and raises nothing.
    With `NUMBA_DISABLE_JIT=1` the plain Python function remains, so that indices are checked.
    """

    def compile_(function: Function) -> Function:
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
