"""Waits for a condition with a deadline."""

import time
from collections.abc import Callable

BUSY = 4.0
"""On a machine with other work to do things may take so many times as long."""


def wait_for(what: Callable[[], bool], seconds: float) -> bool:
    """Whether the condition became true within `seconds` of an idle machine."""
    deadline = time.monotonic() + BUSY * seconds
    while time.monotonic() < deadline:
        if what():
            return True
        time.sleep(0.01)
    return what()
