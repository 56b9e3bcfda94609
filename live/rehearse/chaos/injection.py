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
from live.rehearse.chaos.call_sites import Injected, Injector, Site, replace_method
from live.rehearse.chaos.fault_page import FaultPage, Word
from live.show.journal.journal_writer import WholeWrites
from live.supervisor.supervisor_link import Lifeline

PAGE: Final = "page"
SITES: Final = "sites.json"
ROLES: Final = "roles"
"""A folder with a file for each engine process, which contains its start role."""
THREADS: Final = "threads.txt"
"""Names of threads in which an exception was raised, one per line."""
SPARED: Final = ("MainThread", "Thread-")


class PageInjector(Injector):
    """An `Injector` that is armed through the page. Thread: the one that runs the show."""

    def __init__(self, page: FaultPage, sites: list[Site]) -> None:
        super().__init__()
        self._page, self._sites = page, sites
        self._armed = 0

    def look(self) -> None:
        """Read the requested fault from the page."""
        which = self._page[Word.SITE]
        if not 0 < which <= len(self._sites):
            self.site, self.left = None, 0
            return
        self.site, self.left = self._sites[which - 1], self._page[Word.LEFT]
        self.since = self._page[Word.SINCE] / 64.0

    def note(self) -> None:
        """Count the exception in the page, which all processes share."""
        self._page[Word.LEFT] -= 1
        self._page[Word.RAISED] += 1


def install_in_engine(folder: Path) -> None:
    """Install all faults in an engine's process, before it starts."""
    page = FaultPage(folder / PAGE)
    with contextlib.suppress(OSError, ValueError):
        _install_ticks(page, [Site(*row) for row in json.loads((folder / SITES).read_text(encoding="utf-8"))])
    _install_progress(page, folder)
    _install_calls(page)
    _install_lifeline(page, folder)
    _install_clock(page)


def _install_ticks(page: FaultPage, sites: list[Site]) -> None:
    from live.show.show import Show

    injector, was = PageInjector(page, sites), Show.tick

    def tick(show: Show, seconds: float) -> bool:
        if not page[Word.SITE]:
            return was(show, seconds)
        injector.look()
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
        now, last = time.monotonic_ns(), page[Word.LAST]
        if last and now - last > page[Word.GAP]:
            page[Word.GAP] = now - last
        page[Word.BACK] += before + 1 < page[Word.TICK] and page[Word.PID] == os.getpid()
        page[Word.FRAMES] += 1
        page[Word.LAST], page[Word.TICK], page[Word.PID] = now, engine.ticks.index, os.getpid()
        if page[Word.THREAD] != page[Word.THREAD_DONE]:
            page[Word.THREAD_DONE] = page[Word.THREAD]
            raise_in_thread(page[Word.THREAD_WHICH], folder)

    replace_method(Engine, "run_to", run_to)


def raise_in_thread(which: int, folder: Path) -> str:
    """Raise an exception in one of this process' threads except the main one; return its name, "" if there is none."""
    threads = sorted(
        (one for one in threading.enumerate() if not one.name.startswith(SPARED)), key=lambda one: one.name
    )
    if not threads:
        return ""
    thread = threads[which % len(threads)]
    if thread.ident is not None:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident), ctypes.py_object(Injected))
    with (folder / THREADS).open("a", encoding="utf-8") as file:
        file.write(f"{thread.name}\n")
    return thread.name


def _install_calls(page: FaultPage) -> None:
    """Raise requested exceptions in calls of services outside the show."""
    was = Bulkhead.call
    turn = [0]

    def fails(*arguments: Any) -> None:
        page[Word.CALLS_RAISED] += 1
        raise Injected("injected in a callback")

    def call(self: Bulkhead, part: str, act: Callable[..., Any], *arguments: Any) -> Any:
        if page[Word.CALLS] > 0 and threading.current_thread() is threading.main_thread():
            turn[0] += 1
            if turn[0] % 13 == page[Word.CALLS_WHICH] % 13:
                page[Word.CALLS] -= 1
                return was(self, part, fails)
        return was(self, part, act, *arguments)

    replace_method(Bulkhead, "call", call)


def _install_lifeline(page: FaultPage, folder: Path) -> None:
    """Write the role of this process, and cut its channel to the supervisor when requested."""
    brief, frame = Lifeline.brief, Lifeline.frame

    def said(lifeline: Lifeline) -> Any:
        told = brief(lifeline)
        with contextlib.suppress(OSError):
            (folder / ROLES / str(os.getpid())).write_text(told.role, encoding="utf-8")
        return told

    def after(lifeline: Lifeline, tick: int) -> None:
        if page[Word.CUT] == os.getpid():
            page[Word.CUT] = 0
            with contextlib.suppress(OSError):
                lifeline.wire.socket.shutdown(socket.SHUT_RDWR)
        frame(lifeline, tick)

    replace_method(Lifeline, "brief", said)
    replace_method(Lifeline, "frame", after)


def _install_clock(page: FaultPage) -> None:
    """Falsify the system clock, which people and NTP set; the show must not depend on it."""
    was, was_ns = time.time, time.time_ns
    time.time = lambda: was() + page[Word.CLOCK] / 1e3
    time.time_ns = lambda: was_ns() + page[Word.CLOCK] * 1_000_000


def install_disk(folder: Path) -> None:
    """Let every write of a journal fail with the error number in the page."""
    page = FaultPage(folder / PAGE)
    add = WholeWrites.add

    def refused(self: WholeWrites, data: bytes) -> None:
        number = page[Word.DISK]
        if number:
            raise OSError(number, os.strerror(number))
        add(self, data)

    replace_method(WholeWrites, "add", refused)
    _install_clock(page)
