"""Urgency: what a thread that must wake on time may ask of the system, with and without the right to real time."""

import contextlib
import ctypes
import os
import platform
import sys
import threading
from typing import Final

PRIORITY: Final = 10
"""Real-time priority, below that of sound."""

NICE: Final = -15
"""Where only a better share is allowed (limits.conf, nice)."""

SLICE: Final = 100_000
"""Nanoseconds that the thread wants the processor for at a time: from Linux 6.12 on one who asks for little is let in
before one who asks for much, and nobody needs a right for it (sched_setattr(2), sched_runtime of SCHED_OTHER)."""

PR_SET_TIMERSLACK: Final = 29
SCHED_SETATTR: Final = {"x86_64": 314, "aarch64": 274}
"""The number of the system call, for which neither Python nor the C library has a function."""


class _Attributes(ctypes.Structure):
    """struct sched_attr, first version."""

    _fields_ = (
        ("size", ctypes.c_uint32), ("policy", ctypes.c_uint32), ("flags", ctypes.c_uint64), ("nice", ctypes.c_int32),
        ("priority", ctypes.c_uint32), ("runtime", ctypes.c_uint64), ("deadline", ctypes.c_uint64),
        ("period", ctypes.c_uint64),
    )  # fmt: skip


def hurry() -> bool:
    """Give this thread real-time priority, where the system lets us (Linux: limits.conf, rtprio); whether it did.

    Without it: as much of everything else that makes it wake on time as is allowed.
    """
    thread = threading.get_native_id()
    try:
        os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError):
        with contextlib.suppress(AttributeError, OSError):  # not allowed: the usual share
            os.setpriority(os.PRIO_PROCESS, thread, NICE)
        if sys.platform == "linux":
            _ask_for_little(thread)
        return False
    return True


def _ask_for_little(thread: int) -> None:
    """Short slices, and timers to the microsecond (they may be 50 µs late otherwise); refusals change nothing."""
    number = SCHED_SETATTR.get(platform.machine())
    with contextlib.suppress(AttributeError, OSError):
        system = ctypes.CDLL(None)
        system.prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)
        if number is not None:
            nice = os.getpriority(os.PRIO_PROCESS, thread)
            wish = _Attributes(size=ctypes.sizeof(_Attributes), nice=nice, runtime=SLICE)
            system.syscall(number, 0, ctypes.byref(wish), 0)
