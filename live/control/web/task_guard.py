"""Fault isolation of asyncio tasks and callbacks: exceptions are counted and tasks restarted; the server continues."""

import asyncio
from collections.abc import Awaitable, Callable

from live.base.fault_isolation import FAULTS, FIRST_PAUSE, LONGEST_PAUSE


def keep_task(name: str, work: Callable[[], Awaitable[None]]) -> "asyncio.Task[None]":
    """Run `work` as a task until it returns or is cancelled; it is restarted after an exception."""
    return asyncio.get_running_loop().create_task(_keep(name, work), name=name)


async def _keep(name: str, work: Callable[[], Awaitable[None]]) -> None:
    pause = FIRST_PAUSE
    while True:
        try:
            await work()
            return
        except Exception as error:
            FAULTS.record(name, error)
        await asyncio.sleep(pause)
        pause = min(2.0 * pause, LONGEST_PAUSE)


def guarded(name: str, act: Callable[[], None]) -> Callable[[], None]:
    """Return a callback for the loop whose exceptions are counted and suppressed."""

    def call() -> None:
        try:
            act()
        except Exception as error:
            FAULTS.record(name, error)

    return call


def loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    """Return the faster event loop if it is installed."""
    try:
        import uvloop
    except ImportError:
        return asyncio.SelectorEventLoop  # the one that waits for sockets on every system
    made: Callable[[], asyncio.AbstractEventLoop] = uvloop.new_event_loop
    return made
