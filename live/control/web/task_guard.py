"""Tasks of a server's loop: an exception in one is counted and the task begun again; it never ends the server."""

import asyncio
from collections.abc import Awaitable, Callable

from live.base.fault_isolation import FAULTS, FIRST_PAUSE, LONGEST_PAUSE


def keep_task(name: str, work: Callable[[], Awaitable[None]]) -> "asyncio.Task[None]":
    """A task that does `work` until it returns or is cancelled; where it ends in an exception it is begun again."""
    return asyncio.get_running_loop().create_task(_keep(name, work), name=name)


async def _keep(name: str, work: Callable[[], Awaitable[None]]) -> None:
    pause = FIRST_PAUSE
    while True:
        try:
            await work()
            return
        except Exception as error:
            FAULTS.note(name, error)
        await asyncio.sleep(pause)
        pause = min(2.0 * pause, LONGEST_PAUSE)


def guarded(name: str, act: Callable[[], None]) -> Callable[[], None]:
    """A callback of the loop whose exceptions are counted and go no further."""

    def call() -> None:
        try:
            act()
        except Exception as error:
            FAULTS.note(name, error)

    return call
