"""Thread scheduling for threads that must wake on time, with or without the right to real-time priority."""

import contextlib
import ctypes
import os
import platform
import threading
from typing import Final

from live.base.system.features import LINUX

PRIORITY: Final = 10
"""Real-time priority, below that of audio."""

NICE: Final = -15
"""Nice value where real-time priority is not allowed (limits.conf, nice)."""

SLICE_NS: Final = 100_000
"""Requested time slice [ns].

From Linux 6.12 on, a thread with a short slice is scheduled before one with a long slice. No privilege is needed
(sched_setattr(2), sched_runtime of SCHED_OTHER).
"""

PR_SET_TIMERSLACK: Final = 29
SCHED_SETATTR: Final = {"x86_64": 314, "aarch64": 274}
"""Number of the system call; neither Python nor the C library has a function for it."""


class _Attributes(ctypes.Structure):
    """struct sched_attr, first version."""

    _fields_ = (
        ("size", ctypes.c_uint32), ("policy", ctypes.c_uint32), ("flags", ctypes.c_uint64), ("nice", ctypes.c_int32),
        ("priority", ctypes.c_uint32), ("runtime", ctypes.c_uint64), ("deadline", ctypes.c_uint64),
        ("period", ctypes.c_uint64),
    )  # fmt: skip


def request_realtime() -> bool:
    """Give this thread real-time priority where allowed (Linux: limits.conf, rtprio); return whether it was.

    Otherwise all permitted means of waking on time are used.
    """
    thread = threading.get_native_id()
    try:
        os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError):
        with contextlib.suppress(AttributeError, OSError):  # not allowed: keep the default share
            os.setpriority(os.PRIO_PROCESS, thread, NICE)
        if LINUX:
            _request_short_slices(thread)
        return False
    return True


def _request_short_slices(thread: int) -> None:
    """Request short slices and 1 µs timer slack (timers may otherwise be 50 µs late); refusals are ignored."""
    number = SCHED_SETATTR.get(platform.machine())
    with contextlib.suppress(AttributeError, OSError):
        system = ctypes.CDLL(None)
        system.prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)
        if number is not None:
            nice = os.getpriority(os.PRIO_PROCESS, thread)
            wish = _Attributes(size=ctypes.sizeof(_Attributes), nice=nice, runtime=SLICE_NS)
            system.syscall(number, 0, ctypes.byref(wish), 0)
