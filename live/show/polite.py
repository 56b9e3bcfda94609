"""Polite: long work in a thread that leaves the interpreter to the frame loop.

Python's interpreter is one for all threads: who waits for it while another computes is let in only after
`sys.getswitchinterval()`, 5 ms, and a frame asks for it anew after every kernel. While somebody works politely
it is let in after a tenth of a millisecond.
"""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

LETS_IN_S: Final = 0.0001
"""Seconds after which a thread that waits is let in meanwhile, but for single calls of compiled code."""

_lock = threading.Lock()
_working: list[float] = []


@contextmanager
def polite() -> Iterator[None]:
    """What the calling thread does within is done politely; all threads share that. Thread: any, several at a time."""
    with _lock:
        _working.append(sys.getswitchinterval())
        sys.setswitchinterval(min(LETS_IN_S, _working[0]))
    try:
        yield
    finally:
        with _lock:
            before = _working[0]
            _working.pop()
            if not _working:
                sys.setswitchinterval(before)
