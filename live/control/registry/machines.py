"""The machines of a show."""

from typing import Final

from live.control.events.machine_events import ResetBreaker, TakeOver
from live.control.registry.control import Argument, Control

MACHINE_CONTROLS: Final = (
    Control(
        "/dance/takeover", TakeOver, (),
        "To a machine that stands by (`live play --standby`): it leads from now on, and the old leader goes dark.",
        "operator",
    ),
    Control(
        "/dance/breaker/reset", ResetBreaker,
        (Argument("name", "name", "which, as the overlay and the status name it; left out: all", default=""),),
        "Puts a stage of the show that is out of service, because it failed again and again, into service again.",
        "operator",
    ),
)  # fmt: skip
