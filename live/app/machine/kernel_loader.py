"""Kernels behind a running show: what the first frames did not need is loaded, one kernel a frame, or compiled first.

The frame loop never compiles. While kernels are still being compiled, after the first start on a machine, input that
may need them waits (`Engine.holding`), and a rehearsal has made sure that the score needs none of them for a while.
"""

import importlib
import time
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from live.app.machine.kernel_build import KernelBuild, all_kernels, kernel_modules, worker_count
from live.app.machine.kernel_warmup import is_warm
from live.base.disk.kernel_store import ShowLock
from live.base.event_queue import EventQueue
from live.base.jit import JIT_DISABLED, KERNEL_STORE, kernels
from live.clock.time_source import ManualClock
from live.control.events.events import ControlEvent
from live.show.engine import Engine
from live.show.view.status import Status

if TYPE_CHECKING:
    from live.show.loader import LoadedShow

REHEARSAL_S: Final = 60.0
"""Length of a rehearsal [s of the show]: a cold machine needs about as long for the kernels it did not wait for."""
_REHEARSAL_WORK_S: Final = 3.0
"""A rehearsal of a large show ends after so long [s]; what compiling takes counts, too."""


def rehearse_show(loaded: "LoadedShow", seed: int | None) -> None:
    """Run the beginning of a show beside its clock, so that all kernels that it calls are compiled and loaded."""
    show = loaded.start(seed=seed)
    clock, inbox = ManualClock(), EventQueue[ControlEvent]()
    engine = Engine(show, clock=clock, inbox=inbox, status=Status(show, rejected=Counter, memory=lambda: 0.0))
    engine.refuse_failing = True
    end = time.monotonic() + _REHEARSAL_WORK_S
    for second in range(int(REHEARSAL_S)):
        clock.set(float(second))
        engine.run_to(clock.now())
        engine.frame(lambda view: None)
        if time.monotonic() > end:
            return


class KernelLoader:
    """Loads the kernels of the package behind a show.

    Thread: the main thread, between frames. Compiling is done by other processes at the lowest priority.
    """

    def __init__(self) -> None:
        """Begin to compile what is missing on disk."""
        self._lock = ShowLock()
        self._lock.take()
        self._build: KernelBuild | None = None
        if not is_warm():
            self._build = KernelBuild(all_kernels(), workers=max(1, worker_count() - 1), background=True)
        self._loading = self._load_each()

    @property
    def compiles(self) -> bool:
        """Whether kernels are still being compiled."""
        return self._build is not None

    @property
    def notice(self) -> str:
        """What the operator should know; empty if nothing."""
        build = self._build
        if build is None:
            return ""
        return f"first start here: input acts once all kernels are compiled ({build.done} of {build.total})"

    def frame(self) -> None:
        """Load one kernel, or look whether one has been compiled."""
        if self._build is not None:
            if not self._build.update(0.0):
                return
            self._end_build()
            KERNEL_STORE.mark_complete(each.file_name for each in all_kernels())
        next(self._loading, None)

    def close(self) -> None:
        """End the processes that compile; the next start goes on from there."""
        self._end_build()
        self._lock.release()

    def _end_build(self) -> None:
        if self._build is not None:
            self._build.close()
            self._build = None

    def _load_each(self) -> Iterator[None]:
        if JIT_DISABLED:
            return
        for name in kernel_modules():
            importlib.import_module(name)
            yield
        for each in kernels:
            if not each.ready and each.load():
                yield
