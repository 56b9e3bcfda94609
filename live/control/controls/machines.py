"""The machines of a show."""

from typing import Final

from live.control.control import Control
from live.control.machine_events import TakeOver

MACHINE_CONTROLS: Final = (
    Control(
        "/dance/takeover", TakeOver, (),
        "To a machine that stands by (`live play --standby`): it leads from now on, and the old leader goes dark.",
        "operator",
    ),
)  # fmt: skip
