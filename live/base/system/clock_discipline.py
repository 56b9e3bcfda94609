"""What disciplines this machine's clock: whether NTP or PTP keeps its rate right, as far as the system says.

The monotonic clock is not stepped, but disciplined clocks run at the right rate, so two of them do not drift apart.
"""

import ctypes
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

STA_UNSYNC: Final = 0x0040
"""Flag of adjtimex(2): nothing keeps the clock synchronised."""
PROGRAMS: Final = {
    "ptp4l": "PTP (linuxptp)", "phc2sys": "PTP (linuxptp)", "chronyd": "NTP (chrony)", "ntpd": "NTP (ntpd)",
    "systemd-timesyn": "NTP (systemd-timesyncd)", "systemd-timesyncd": "NTP (systemd-timesyncd)",
}  # fmt: skip
"""What a running program is; the kernel cuts names to 15 letters."""


class _Timex(ctypes.Structure):
    """The beginning of `struct timex` of adjtimex(2), and room for the rest."""

    _fields_ = (
        ("modes", ctypes.c_uint), ("offset", ctypes.c_long), ("freq", ctypes.c_long), ("maxerror", ctypes.c_long),
        ("esterror", ctypes.c_long), ("status", ctypes.c_int), ("rest", ctypes.c_char * 256),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Discipline:
    """What is known of it."""

    programs: tuple[str, ...]
    """Programs that run and discipline clocks."""
    synchronised: bool | None
    """Whether the kernel takes the clock for synchronised; None: it does not say."""

    def __str__(self) -> str:
        """In words, for a table."""
        words = ", ".join(self.programs) or "none"
        return words + {True: ", synchronised", False: ", not synchronised", None: ""}[self.synchronised]


def clock_discipline(names: Iterable[str] | None = None) -> Discipline:
    """Return what disciplines the clock. `names`: of the running programs; None: ask the system."""
    if names is None:
        import psutil

        names = [process.info["name"] or "" for process in psutil.process_iter(["name"])]
    found = sorted({PROGRAMS[name] for name in names if name in PROGRAMS})
    return Discipline(tuple(found), _is_synchronised())


def _is_synchronised() -> bool | None:
    """Ask adjtimex(2), without changing anything."""
    if sys.platform != "linux":
        return None
    told = _Timex()
    try:
        code = ctypes.CDLL(None).adjtimex(ctypes.byref(told))
    except (OSError, AttributeError):
        return None
    return None if code < 0 else not told.status & STA_UNSYNC
