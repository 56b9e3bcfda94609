"""Compilation of kernels by several processes: those of a first show before it, the others behind it.

A worker is asked for one kernel at a time, over a pipe; the compiled kernels meet in `jit.KERNEL_STORE`. The kernels
that take longest begin first, and a kernel waits for those that it calls.
"""

import contextlib
import dis
import gc
import importlib
import selectors
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

import psutil

from live.base.disk.kernel_store import kernel_files
from live.base.jit import KERNEL_STORE, Kernel, kernels
from live.base.system.process_control import own_session, processor_count, yield_priority

FIRST_KERNELS: Final = Path(__file__).with_name("first_kernels.txt")
"""Names of the kernels that the default show uses, written by `tools/write_first_kernels.py`."""
MEMORY_EACH: Final = 1 << 30
"""Memory that a worker may need [bytes]."""
LOW_PRIORITY: Final = 19
_WORK: Final = "from live.app.machine.kernel_build import work; work()"


def kernel_modules() -> list[str]:
    """Return the names of all modules with kernels."""
    package = Path(importlib.import_module("live").__path__[0])
    return [".".join(path.relative_to(package.parent).with_suffix("").parts) for path in kernel_files()]


def all_kernels() -> list[Kernel]:
    """Import every module with kernels and return the kernels of the package, which are not compiled by that."""
    for name in kernel_modules():
        importlib.import_module(name)
    return [each for each in kernels if each.py_func.__module__.startswith("live.")]


def kernel_name(kernel: Kernel) -> str:
    """Return the module and the function of a kernel: `live.base.scalar_kernels.damper`."""
    return f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}"


def first_kernels() -> list[Kernel]:
    """Return the kernels that the default show needs from its first frame on."""
    names = set(FIRST_KERNELS.read_text(encoding="utf-8").split())
    return [each for each in all_kernels() if kernel_name(each) in names]


def _calls(function: Callable[..., Any]) -> Iterable[Any]:
    """Yield the compiled or inlined functions that a function names, once for each place."""
    for each in dis.get_instructions(function):
        if each.opname == "LOAD_GLOBAL":
            named = function.__globals__.get(each.argval)
            if hasattr(named, "py_func"):
                yield named


def _callees(function: Callable[..., Any]) -> set[Kernel]:
    """Return the kernels that a function calls, itself or by what is inlined into it."""
    found: set[Kernel] = set()
    for each in _calls(function):
        found |= {each} if isinstance(each, Kernel) else _callees(each.py_func)
    return found


def _size(function: Callable[..., Any]) -> int:
    """Return the length of a function's bytecode with all that is inlined: the time to compile it goes with that."""
    inlined = (each.py_func for each in _calls(function) if not isinstance(each, Kernel))
    return len(function.__code__.co_code) + sum(_size(each) for each in inlined)


class _Worker:
    """A process that compiles; `kernel`: what it compiles now."""

    def __init__(self, *, background: bool) -> None:
        self.kernel: Kernel | None = None
        self.process = subprocess.Popen(
            [sys.executable, "-c", _WORK, *(["background"] if background else [])],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, bufsize=1,
            **own_session(),
        )  # fmt: skip

    def order(self, kernel: Kernel) -> None:
        """Ask for a kernel; a worker that has died answers by the end of its output."""
        self.kernel = kernel
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.write(f"{kernel.py_func.__module__} {kernel.py_func.__name__}\n")

    def close(self) -> None:
        """End the process, in the middle of a kernel if need be."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()


def worker_count() -> int:
    """Return how many processes may compile at once: one for each core, as far as the memory goes."""
    cores = processor_count()
    return max(1, min(cores, int(psutil.virtual_memory().available) // MEMORY_EACH))


class KernelBuild:
    """Compiles those of some kernels that are not on disk yet."""

    def __init__(self, wanted: Iterable[Kernel], *, workers: int | None = None, background: bool = False) -> None:
        """`workers`: number of processes; `background`: at the lowest priority."""
        self._calls: dict[Kernel, set[Kernel]] = {}
        waiting = list(wanted)
        while waiting:
            kernel = waiting.pop()
            if kernel not in self._calls and not KERNEL_STORE.has(kernel.file_name):
                self._calls[kernel] = _callees(kernel.py_func)
                waiting += self._calls[kernel]
        self._sizes = {kernel: _size(kernel.py_func) for kernel in self._calls}
        self.total = len(self._calls)
        self.done = 0
        self.share = 0.0
        """How much of the work is done, 0 to 1, as far as the lengths of the kernels tell."""
        self.last = ""
        """Name of the kernel compiled last."""
        self.failed: list[str] = []
        """Names of kernels that no worker could compile."""
        self._left = self._in_order()
        self._workers: list[_Worker] = []
        self._selector = selectors.DefaultSelector()
        for _ in range(min(workers or worker_count(), self.total)):
            worker = _Worker(background=background)
            self._workers.append(worker)
            self._selector.register(worker.process.stdout, selectors.EVENT_READ, worker)  # type: ignore[arg-type]
        self._give_orders()

    def _in_order(self) -> list[Kernel]:
        """Return the kernels, those first that with all that waits for them take longest."""
        urgency = dict(self._sizes)
        for _ in range(len(urgency)):  # at most so deep; two or three rounds in effect
            before = dict(urgency)
            for kernel, called in self._calls.items():
                for each in called & urgency.keys():
                    urgency[each] = max(urgency[each], self._sizes[each] + urgency[kernel])
            if urgency == before:
                break
        return sorted(urgency, key=lambda kernel: (-urgency[kernel], kernel.file_name))

    def _give_orders(self) -> None:
        for worker in self._workers:
            if worker.kernel is None:
                unfinished = {*self._left, *(each.kernel for each in self._workers)}
                ready = (each for each in self._left if not self._calls[each] & unfinished)
                kernel = next(ready, None)
                if kernel is not None:
                    self._left.remove(kernel)
                    worker.order(kernel)

    @property
    def finished(self) -> bool:
        """Whether nothing is left to wait for."""
        return self.done + len(self.failed) >= self.total or not self._workers

    def update(self, timeout: float) -> bool:
        """Wait for a compiled kernel, at most `timeout` [s]; return whether all are compiled or have failed."""
        if not self.finished:
            for key, _ in self._selector.select(timeout):
                self._take_answer(key.data)
            self._give_orders()
        return self.finished

    def _take_answer(self, worker: _Worker) -> None:
        assert worker.process.stdout is not None
        if worker.kernel is None or not worker.process.stdout.readline():
            self._selector.unregister(worker.process.stdout)
            self._workers.remove(worker)
            worker.close()
            if worker.kernel is not None:
                self.failed.append(kernel_name(worker.kernel))
            return
        self.share += self._sizes[worker.kernel] / sum(self._sizes.values())
        self.last, worker.kernel = worker.kernel.py_func.__name__, None
        self.done += 1

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.close()
        self._workers.clear()
        self._selector.close()

    def __enter__(self) -> "KernelBuild":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def work() -> None:
    """Compile what the lines of standard input name, `MODULE FUNCTION`; answer each with a line, end with the input."""
    if "background" in sys.argv:
        yield_priority(LOW_PRIORITY)
    gc.freeze()  # what is here stays
    for line in sys.stdin:
        module, function = line.split()
        importlib.import_module(module)
        for each in kernels:
            if (each.py_func.__module__, each.py_func.__name__) == (module, function):
                each.prepare()
        print(flush=True)
