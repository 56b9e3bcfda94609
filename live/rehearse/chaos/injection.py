"""Fault injection inside the processes of a show, for faults that signals and full disks cannot produce.

Methods of the program are replaced in the process before it starts; the program itself is unchanged. The faults are
requested through the shared page (`FaultPage`).
"""

import contextlib
import ctypes
import json
import os
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from live.base.fault_isolation import Bulkhead
from live.rehearse.chaos.call_sites import CallSite, ExceptionInjector, InjectedError, replace_method
from live.rehearse.chaos.fault_page import FaultPage, PageWord
from live.show.journal.line_writer import AtomicAppendFile
from live.supervisor.supervisor_link import SupervisorLink

PAGE_FILE: Final = "page"
SITES_FILE: Final = "sites.json"
ROLES_FOLDER: Final = "roles"
"""A folder with a file for each engine process, which contains its start role."""
THREADS_FILE: Final = "threads.txt"
"""Names of threads in which an exception was raised, one per line."""
EXCLUDED_THREADS: Final = ("MainThread", "Thread-")


class PageInjector(ExceptionInjector):
    """An `ExceptionInjector` that is armed through the page. Thread: the one that runs the show."""

    def __init__(self, page: FaultPage, sites: list[CallSite]) -> None:
        super().__init__()
        self._page, self._sites = page, sites

    def read_page(self) -> None:
        """Read the requested fault from the page."""
        which = self._page[PageWord.SITE]
        if not 0 < which <= len(self._sites):
            self.site, self.remaining = None, 0
            return
        self.site, self.remaining = self._sites[which - 1], self._page[PageWord.LEFT]
        self.since = self._page[PageWord.SINCE] / 64.0

    def on_raise(self) -> None:
        """Count the exception in the page, which all processes share."""
        self._page[PageWord.LEFT] -= 1
        self._page[PageWord.RAISED] += 1


def install_in_engine(folder: Path) -> None:
    """Install all faults in an engine's process, before it starts."""
    page = FaultPage(folder / PAGE_FILE)
    with contextlib.suppress(OSError, ValueError):
        _install_ticks(page, [CallSite(*row) for row in json.loads((folder / SITES_FILE).read_text(encoding="utf-8"))])
    _install_progress(page, folder)
    _install_calls(page)
    _install_link(page, folder)
    _install_clock(page)


def _install_ticks(page: FaultPage, sites: list[CallSite]) -> None:
    from live.show.show import Show

    injector, was = PageInjector(page, sites), Show.tick

    def tick(show: Show, seconds: float) -> bool:
        if not page[PageWord.SITE]:
            return was(show, seconds)
        injector.read_page()
        return injector.run(was, show, seconds)

    replace_method(Show, "tick", tick)


def _install_progress(page: FaultPage, folder: Path) -> None:
    """Report the progress of the active engine, and raise requested exceptions in threads."""
    from live.show.engine import Engine

    was = Engine.run_to

    def run_to(engine: Engine, target: float) -> None:
        before = engine.ticks.index
        was(engine, target)
        if engine.ticks.index == before:
            return
        now, last = time.monotonic_ns(), page[PageWord.LAST]
        if last and now - last > page[PageWord.GAP]:
            page[PageWord.GAP] = now - last
        page[PageWord.REPEATED_TICKS] += before + 1 < page[PageWord.TICK] and page[PageWord.PID] == os.getpid()
        page[PageWord.FRAMES] += 1
        page[PageWord.LAST], page[PageWord.TICK], page[PageWord.PID] = now, engine.ticks.index, os.getpid()
        if page[PageWord.THREAD] != page[PageWord.THREAD_DONE]:
            page[PageWord.THREAD_DONE] = page[PageWord.THREAD]
            raise_in_thread(page[PageWord.THREAD_WHICH], folder)

    replace_method(Engine, "run_to", run_to)


def raise_in_thread(which: int, folder: Path) -> str:
    """Raise an exception in one of this process' threads except the main one; return its name, "" if there is none."""
    threads = sorted(
        (one for one in threading.enumerate() if not one.name.startswith(EXCLUDED_THREADS)), key=lambda one: one.name
    )
    if not threads:
        return ""
    thread = threads[which % len(threads)]
    if thread.ident is not None:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident), ctypes.py_object(InjectedError))
    with (folder / THREADS_FILE).open("a", encoding="utf-8") as file:
        file.write(f"{thread.name}\n")
    return thread.name


def _install_calls(page: FaultPage) -> None:
    """Raise requested exceptions in calls of services outside the show."""
    was = Bulkhead.call
    turn = [0]

    def fails(*arguments: Any) -> None:
        page[PageWord.CALLS_RAISED] += 1
        raise InjectedError("injected in a callback")

    def call(self: Bulkhead, part: str, act: Callable[..., Any], *arguments: Any) -> Any:
        if page[PageWord.CALLS] > 0 and threading.current_thread() is threading.main_thread():
            turn[0] += 1
            if turn[0] % 13 == page[PageWord.CALLS_WHICH] % 13:
                page[PageWord.CALLS] -= 1
                return was(self, part, fails)
        return was(self, part, act, *arguments)

    replace_method(Bulkhead, "call", call)


def _install_link(page: FaultPage, folder: Path) -> None:
    """Write the role of this process, and cut its channel to the supervisor when requested."""
    brief, frame = SupervisorLink.receive_brief, SupervisorLink.end_frame

    def said(lifeline: SupervisorLink) -> Any:
        told = brief(lifeline)
        with contextlib.suppress(OSError):
            (folder / ROLES_FOLDER / str(os.getpid())).write_text(told.role, encoding="utf-8")
        return told

    def after(lifeline: SupervisorLink, tick: int) -> None:
        if page[PageWord.CUT] == os.getpid():
            page[PageWord.CUT] = 0
            with contextlib.suppress(OSError):
                lifeline.channel.socket.shutdown(socket.SHUT_RDWR)
        frame(lifeline, tick)

    replace_method(SupervisorLink, "brief", said)
    replace_method(SupervisorLink, "frame", after)


def _install_clock(page: FaultPage) -> None:
    """Falsify the system clock, which people and NTP set; the show must not depend on it."""
    was, was_ns = time.time, time.time_ns
    time.time = lambda: was() + page[PageWord.CLOCK] / 1e3
    time.time_ns = lambda: was_ns() + page[PageWord.CLOCK] * 1_000_000


def install_disk(folder: Path) -> None:
    """Let every write of a journal fail with the error number in the page."""
    page = FaultPage(folder / PAGE_FILE)
    add = AtomicAppendFile.append

    def refused(self: AtomicAppendFile, data: bytes) -> None:
        number = page[PageWord.DISK]
        if number:
            raise OSError(number, os.strerror(number))
        add(self, data)

    replace_method(AtomicAppendFile, "add", refused)
    _install_clock(page)
