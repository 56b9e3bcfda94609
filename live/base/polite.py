"""Polite: long work in a thread that leaves the interpreter to the frame loop.

Python's interpreter is one for all threads: who waits for it is let in only after `sys.getswitchinterval()` (5 ms), and
a frame asks for it anew after every kernel. A polite thread gives it away itself, often, and then rests: a frame waits
for a fraction of a millisecond now and then, and the work takes some times as long.
"""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

RUNS_S: Final = 0.0003
"""Seconds for which the thread keeps the interpreter at a stretch, but for single calls of compiled code ..."""
RESTS_S: Final = 0.0009
"""... and for which it rests then."""


@contextmanager
def polite() -> Iterator[None]:
    """What the calling thread does within is done politely. Looks at the clock at every call of a function."""
    since = time.perf_counter()

    def called(_frame: Any, _event: str, _argument: Any) -> None:
        nonlocal since
        if time.perf_counter() - since > RUNS_S:
            time.sleep(RESTS_S)
            since = time.perf_counter()

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        yield
    finally:
        sys.setprofile(before)
