"""`live warm`: compile all kernels once and keep them, with a progress bar, so that a show starts at once."""

import contextlib
import hashlib
import importlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console


def _ready_mark() -> Path:
    from live.base import jit

    # numba keeps its entries per source path and drops them when a file's time or size changes: so does this mark
    files = jit.kernel_files()
    state = [(str(path), path.stat().st_mtime_ns, path.stat().st_size, jit.cache_name(path)) for path in files]
    digest = hashlib.sha256(repr(state).encode()).hexdigest()
    return jit.KERNELS / f"ready-{digest[:16]}"


def is_warm() -> bool:
    """Whether `warm_kernels` has filled the cache for these very sources."""
    return _ready_mark().exists()


def _kernel_modules(files: list[Path], package: Path) -> list[str]:
    return [".".join(path.relative_to(package.parent).with_suffix("").parts) for path in files]


@contextlib.contextmanager
def _from_the_other_end(names: list[str]) -> Iterator[None]:
    """Where there is a second core, another process compiles the same modules from the last to the first meanwhile.

    Both fill one cache, whose files are put in place whole; whoever comes second finds them there.
    """
    if (os.cpu_count() or 1) < 2:
        yield
        return
    work = f"import importlib\nfor name in {names[::-1]!r}: importlib.import_module(name)"
    quiet = subprocess.DEVNULL
    helper = subprocess.Popen([sys.executable, "-c", work], stdin=quiet, stdout=quiet, stderr=quiet)
    try:
        yield
    finally:
        helper.terminate()
        helper.wait()


def warm_kernels(console: "Console") -> int:
    """Import every kernel module, which compiles what the cache does not hold; the number of kernels in all.

    Quiet when the cache of these sources was filled before; otherwise a bar names each kernel as it gets ready.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from live.base import jit

    names = _kernel_modules(jit.kernel_files(), Path(jit.__file__).parent.parent)
    if is_warm():
        for name in names:
            importlib.import_module(name)
        return jit.kernel_count()

    columns = (
        TextColumn("Compiling kernels (once)"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[kernel]}"),
    )
    total = jit.kernel_count()
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("", total=total, kernel="")

        def advance(kernel: str) -> None:
            progress.update(task, advance=1, kernel=kernel)

        jit.kernel_compiled.append(advance)
        try:
            with _from_the_other_end(names):
                for name in names:
                    importlib.import_module(name)
        finally:
            jit.kernel_compiled.remove(advance)
        progress.update(task, completed=total, kernel="")  # modules loaded before us did not call back
    if not jit.JIT_DISABLED:
        _ready_mark().touch()
    return total


def warm(
    stamp: Annotated[
        Path | None, typer.Option(help="Write into this file which file tells that all is compiled.", dir_okay=False)
    ] = None,
) -> None:
    """Compile and cache the kernels, so that the first show starts at once."""
    from rich.console import Console

    console = Console(stderr=True)
    start = time.perf_counter()
    count = warm_kernels(console)
    console.print(f"{count} kernels ready in {time.perf_counter() - start:.1f} s", highlight=False)
    if stamp is not None:
        stamp.write_text(f"{_ready_mark()}\n", encoding="utf-8")
