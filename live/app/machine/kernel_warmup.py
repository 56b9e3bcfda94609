"""Compiled kernels before a show (`live warm`): those of the first frames, or all of them, with a progress bar."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from live.base.disk.kernel_store import SHIPPED_PACKAGE
from live.base.errors import PersonError
from live.base.system.process_control import defer_signals, own_session

if TYPE_CHECKING:
    from rich.console import Console

    from live.base.jit import Kernel

Tell = Callable[[int, int, float], None]
"""Called with the number of compiled kernels, of all, and the share of the work that is done, 0 to 1."""

_POLL_S: Final = 0.1
_WAIT_S: Final = 0.5
_PATIENCE_S: Final = 300.0
"""Longest wait of a standby for kernels that others compile [s]."""


def is_warm() -> bool:
    """Whether all kernels are compiled for the present sources."""
    from live.base.jit import JIT_DISABLED, KERNEL_STORE

    return JIT_DISABLED or KERNEL_STORE.is_complete()


def _compile(wanted: "Iterable[Kernel]", console: "Console", tell: Tell | None = None) -> int:
    """Compile those of `wanted` that are missing on disk, with a progress bar; return how many there were."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from live.app.machine.kernel_build import KernelBuild

    columns = (
        TextColumn("Compiling kernels (once)"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[kernel]}"),
    )
    try:
        with defer_signals() as end_if_asked, KernelBuild(wanted) as build:
            if not build.total:
                return 0
            with Progress(*columns, console=console) as progress:
                task = progress.add_task("", total=build.total, kernel="")
                finished = False
                while not finished:
                    finished = build.update(_POLL_S)
                    progress.update(task, completed=build.done, kernel=build.last)
                    if tell is not None:
                        tell(build.done, build.total, build.share)
                    end_if_asked()
            return build.total
    except (KeyboardInterrupt, SystemExit):
        console.print("stopped; the next start compiles the remaining kernels", highlight=False)
        raise


def warm_kernels(console: "Console", tell: Tell | None = None) -> None:
    """Compile the kernels that the first frames of a show need, if they are missing; say which code is used.

    What another show needs besides is compiled when it is first used. `tell`: called while kernels are compiled.
    """
    if is_warm():
        return
    from live.app.machine.kernel_build import first_kernels
    from live.base.disk.kernel_store import cache_root
    from live.base.jit import KERNEL_SET, KERNEL_STORE

    if find_spec(SHIPPED_PACKAGE) is not None:
        console.print(
            f"note: the kernels of {SHIPPED_PACKAGE} are for other processors, versions or sources than {KERNEL_SET}; "
            "this machine compiles its own",
            style="yellow", soft_wrap=True, markup=False,
        )  # fmt: skip
    if not _compile(first_kernels(), console, tell):
        return
    if not all(KERNEL_STORE.has(each.file_name) for each in first_kernels()):
        console.print(
            f"note: compiled kernels cannot be kept in {KERNEL_STORE.own}; every start compiles them again",
            style="yellow", soft_wrap=True, markup=False,
        )  # fmt: skip
    elif not KERNEL_STORE.own.is_relative_to(cache_root()):
        console.print(
            f"note: {cache_root()} cannot be written: compiled kernels are kept in {KERNEL_STORE.own}, "
            "often only until the machine starts again; LIVE_CACHE_DIR names another folder",
            style="yellow", soft_wrap=True, markup=False,
        )  # fmt: skip


def load_kernels() -> None:
    """Load every kernel into this process; wait while the engine's workers compile some of them.

    For processes that take over a show at once. Where nobody compiles, or nothing can be kept, compile here.
    """
    from live.base.jit import JIT_DISABLED

    if JIT_DISABLED:
        return
    from live.app.machine.kernel_build import all_kernels

    end = time.monotonic() + _PATIENCE_S
    while not is_warm() and time.monotonic() < end:
        time.sleep(_WAIT_S)
    for each in all_kernels():
        each.prepare()


def compile_all(console: "Console") -> int:
    """Compile all kernels that are missing, and say in the store that it is complete; return the number of all."""
    from live.app.machine.kernel_build import all_kernels
    from live.base.jit import JIT_DISABLED, KERNEL_STORE

    kernels = [] if JIT_DISABLED else all_kernels()
    if kernels and not is_warm():
        _compile(kernels, console)
        KERNEL_STORE.mark_complete(each.file_name for each in kernels)
        KERNEL_STORE.drop_old()
    return len(kernels)


def compile_between_shows() -> None:
    """Compile this machine's own kernels beside everything else, where shipped ones have been used.

    Ends as soon as a show begins; a later call goes on from there.
    """
    from live.app.machine.kernel_build import KernelBuild, all_kernels
    from live.base.disk.kernel_store import ShowLock
    from live.base.jit import KERNEL_STORE

    kernels = all_kernels()
    with defer_signals() as end_if_asked, KernelBuild(kernels, workers=1, background=True) as build:
        finished = False
        while not finished:
            if ShowLock.is_taken():
                return
            finished = build.update(_WAIT_S)
            end_if_asked()
    KERNEL_STORE.mark_complete(each.file_name for each in kernels)
    KERNEL_STORE.drop_old()


def start_native_build() -> None:
    """After a show with shipped kernels: leave a process behind that compiles this machine's own, see `live warm`."""
    if find_spec(SHIPPED_PACKAGE) is None:
        return
    quiet, environment = subprocess.DEVNULL, {**os.environ, "LIVE_KERNEL_TARGET": "native"}
    subprocess.Popen(
        [sys.executable, "-m", "live", "warm", "--background"],
        stdin=quiet, stdout=quiet, stderr=quiet, env=environment, **own_session(),
    )  # fmt: skip


def clear_caches() -> None:
    """Delete what shows keep in the user's cache, and say so; PersonError while a show runs, or if it is another's."""
    from live.base.disk.kernel_store import clear_cache

    try:
        cleared = clear_cache()
    except BlockingIOError:
        raise PersonError("a show runs, and uses the compiled kernels", "end it first") from None
    except OSError as error:
        raise PersonError(f"{error.filename}: {error.strerror}", "delete it as the user who owns it") from None
    for path in cleared:
        print(f"deleted: {path}")
    if not cleared:
        print("nothing to delete")


def warm(
    stamp: Annotated[
        Path | None,
        typer.Option(help="Write into this file the path of the mark of complete kernels.", dir_okay=False),
    ] = None,
    background: Annotated[
        bool,
        typer.Option("--background", help="Compile on one core at the lowest priority, silently, until a show begins."),
    ] = False,
    clear: Annotated[
        bool,
        typer.Option("--clear", help="Delete compiled kernels and all else in the cache, as before an uninstallation."),
    ] = False,
) -> None:
    """Compile and keep all kernels, so that no show compiles."""
    if clear:
        clear_caches()
        return
    from rich.console import Console

    from live.base.jit import KERNEL_SET, KERNEL_STORE

    if background:
        if not is_warm():
            compile_between_shows()
        return
    console = Console(stderr=True)
    start = time.perf_counter()
    count = compile_all(console)
    console.print(f"{count} kernels ready in {time.perf_counter() - start:.1f} s ({KERNEL_SET})", highlight=False)
    if stamp is not None:
        stamp.write_text(f"{KERNEL_STORE.complete_mark}\n", encoding="utf-8")
    if count and not is_warm():
        sys.exit(1)
