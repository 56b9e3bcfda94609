"""Compilation of all kernels into numba's cache (`live warm`), so that a show starts without compiling."""

import contextlib
import hashlib
import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console


def _marker_path() -> Path:
    from live.base import jit

    # numba drops a cache entry when its source file's time or size changes: the mark depends on the same values
    files = jit.kernel_files()
    state = [(str(path), path.stat().st_mtime_ns, path.stat().st_size, jit.cache_name(path)) for path in files]
    digest = hashlib.sha256(repr(state).encode()).hexdigest()
    return jit.KERNEL_CACHE_DIR / f"ready-{digest[:16]}"


def is_warm() -> bool:
    """Whether `warm_kernels` has filled the cache for the present sources."""
    return _marker_path().exists()


def _kernel_modules(files: list[Path], package: Path) -> list[str]:
    return [".".join(path.relative_to(package.parent).with_suffix("").parts) for path in files]


@contextlib.contextmanager
def _compile_in_reverse(names: list[str]) -> Iterator[None]:
    """Compile the same modules in reverse order in a second process meanwhile, if there is a second core.

    Both processes fill one cache, whose files are replaced atomically; the later process finds them there.
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


@contextlib.contextmanager
def _defer_signals() -> Iterator[Callable[[], None]]:
    """Delay SIGINT, SIGTERM and SIGHUP until a kernel is ready; yield the function to call then.

    An exception raised by a signal handler while numba compiles would end in a long report of numba's own errors.
    """
    asked: list[int] = []
    usual: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            if hasattr(signal, name):
                number = getattr(signal, name)
                usual[number] = signal.signal(number, lambda number, _frame: asked.append(number))

    def end_if_asked() -> None:
        while asked:
            number = asked.pop(0)
            if callable(usual[number]):
                usual[number](number, None)

    try:
        yield end_if_asked
        end_if_asked()
    finally:
        for number, handler in usual.items():
            if signal.getsignal(number) is not signal.SIG_IGN:  # set by a handler that ran: it ignores further signals
                signal.signal(number, handler)


def warm_kernels(console: "Console") -> int:
    """Import every kernel module, which compiles kernels missing in the cache; return the number of all kernels.

    Print nothing when the cache is complete for these sources; else show a progress bar that names each kernel.
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
    try:
        with _defer_signals() as end_if_asked, Progress(*columns, console=console) as progress:
            task = progress.add_task("", total=total, kernel="")

            def advance(kernel: str) -> None:
                progress.update(task, advance=1, kernel=kernel)
                end_if_asked()

            jit.compile_listeners.append(advance)
            try:
                with _compile_in_reverse(names):
                    for name in names:
                        importlib.import_module(name)
            finally:
                jit.compile_listeners.remove(advance)
            progress.update(task, completed=total, kernel="")  # modules imported earlier did not report
    except (KeyboardInterrupt, SystemExit):
        console.print("stopped; the next start compiles the remaining kernels", highlight=False)
        raise
    if not jit.JIT_DISABLED:
        _marker_path().touch()
    return total


def warm(
    stamp: Annotated[
        Path | None,
        typer.Option(help="Write into this file the path of the mark of a complete cache.", dir_okay=False),
    ] = None,
) -> None:
    """Compile and cache the kernels, so that the first show starts at once."""
    from rich.console import Console

    console = Console(stderr=True)
    start = time.perf_counter()
    count = warm_kernels(console)
    console.print(f"{count} kernels ready in {time.perf_counter() - start:.1f} s", highlight=False)
    if stamp is not None:
        stamp.write_text(f"{_marker_path()}\n", encoding="utf-8")
