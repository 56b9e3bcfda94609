"""Wait for something of a real part, with a deadline."""

import time
from collections.abc import Callable


def wait_for(what: Callable[[], bool], seconds: float) -> bool:
    """Whether `what` became true within `seconds`."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if what():
            return True
        time.sleep(0.01)
    return what()
