"""Exit codes, termination signals and error output shared by all processes of `live`."""

import signal
from typing import Final

from rich.console import Console
from rich.text import Text

from live.base.errors import PersonError

EXIT_PERSON_ERROR: Final = 2
EXIT_INTERRUPTED: Final = 130


def show_person_error(error: PersonError) -> None:
    """Print the error on stderr: one line, and one more for the remedy; its text is not parsed as markup."""
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    console.print(Text.assemble(("error: ", "bold red"), " ".join(error.message.split())))
    if error.remedy is not None:
        console.print(Text.assemble(("  try: ", "bold"), error.remedy))


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
