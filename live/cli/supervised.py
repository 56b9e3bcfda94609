"""Whether a show is supervised, and by which processes; they are started here."""

import os
import signal
import sys
from typing import Final

from rich.console import Console

from live.alive.orders import Orders
from live.alive.supervisor import Supervisor
from live.base.errors import PersonError
from live.cli.played import Played

SHORT: Final = 60.0
"""A run of so few seconds [s] is a try-out: nobody waits to take over."""
SHARE: Final = 0.6
"""Share of the machine's memory that an engine may come to need."""


def is_supervised(played: Played, *, alone: bool) -> bool:
    """Whether to watch over this show: one on a screen or without a picture that runs for longer than a try-out.

    Films are made by one process: half a film is of no use to who would take over.
    """
    wish = played.wish
    screen = played.headless or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    short = wish.seconds is not None and wish.seconds < SHORT
    return sys.platform == "linux" and screen and wish.record is None and not short and not alone


def supervise(played: Played) -> None:
    """Run the show with everything that keeps it alive; ends with the engine's exit code."""
    from live.control.osc import CannotListen, bound_socket

    console = Console(stderr=True, highlight=False)
    try:
        osc = bound_socket(*played.wish.osc)
    except CannotListen as error:
        raise PersonError(str(error)) from None
    python = [sys.executable, "-m"]
    silent = played.wish.audio is None and played.wish.bpm is not None
    orders = Orders(
        engine=[*python, "live.cli.engine_process"],
        show=played.packed(),
        audio=[] if silent else [*python, "live.cli.audio_process"],
        guard=() if played.headless else [*python, "live.cli.guard_process"],
        screen=(played.fullscreen, played.monitor),
        osc=osc,
        journal=played.wish.journal,
        budget=int(SHARE * _memory()),
    )
    supervisor = Supervisor(
        orders, lambda line: console.print(f"note: {line}", style="yellow", soft_wrap=True, markup=False)
    )
    code = supervisor.run()
    if code == 128 + signal.SIGINT:
        raise KeyboardInterrupt
    if code:
        raise SystemExit(code)


def _memory() -> int:
    """Bytes of memory that the machine has."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
