"""Memory: how much of the machine's this process holds."""

from collections.abc import Callable

import psutil


def resident_megabytes() -> Callable[[], float]:
    """A function that tells this process' resident memory [MB]."""
    process = psutil.Process()
    return lambda: float(process.memory_info().rss / 1e6)
