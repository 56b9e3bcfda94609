"""Exit codes, termination signals, error output and garbage collection shared by all processes of `live`."""

import atexit
import gc
import signal
from typing import Final

from live.base.errors import PersonError

EXIT_PERSON_ERROR: Final = 2
EXIT_INTERRUPTED: Final = 130


def show_person_error(error: PersonError) -> None:
    """Print the error on stderr: one line, or one for each of several faults, and one more for the remedy; its text is
    not parsed as markup."""
    from rich.console import Console
    from rich.text import Text

    console = Console(stderr=True, soft_wrap=True, highlight=False)
    if error.faults:
        console.print(Text.assemble(("error: ", "bold red"), "several things are wrong"))
        for fault in error.faults:
            console.print(Text.assemble(("  - ", "bold red"), " ".join(fault.split())))
    else:
        console.print(Text.assemble(("error: ", "bold red"), " ".join(error.message.split())))
    if error.remedy is not None:
        console.print(Text.assemble(("  try: ", "bold"), error.remedy))


OBJECTS_PER_COLLECTION: Final = 500_000
"""New containers after which Python looks for reference cycles; 700 by default."""


def collect_garbage_rarely() -> None:
    """Look for reference cycles rarely while the process starts, and not at all when it ends.

    Modules and shows are made of a million objects that stay. Collections among them cost 0.3 s of processor time until
    the first frame, and another 0.3 s at the end. A running show collects garbage itself (`live.app.session`).
    """
    gc.set_threshold(OBJECTS_PER_COLLECTION, 10, 10)
    atexit.register(gc.freeze)


def install_signal_handlers() -> None:
    """Install signal handlers that end the process in order, so that film and journal are completed.

    They cover closed terminals, `kill` and a second Ctrl-C. Shells start background jobs with SIGINT ignored; here it
    is always handled.
    """

    def interrupt(_number: int, _frame: object) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C must not interrupt the closing
        raise KeyboardInterrupt

    def leave(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_IGN)
        raise SystemExit(128 + number)

    signal.signal(signal.SIGINT, interrupt)
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), leave)
