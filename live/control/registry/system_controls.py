"""What is asked over a port, by its sender and for it: values, subscriptions.

The machines of a show.
"""

from typing import Final

from live.control.events.system import ResetBreaker, TakeOver
from live.control.registry.control import Argument, Control, Request


def _get(*, time: float, source: str, address: str) -> Request:
    return Request("get", address)


def _subscribe(*, time: float, source: str, address: str, seconds: float, port: float) -> Request:
    return Request("subscribe", address, seconds, round(port))


def _unsubscribe(*, time: float, source: str, port: float) -> Request:
    return Request("unsubscribe", port=round(port))


_PORT: Final = Argument("port", "float", "where you hear OSC; 0: at the port that you send from", "", 0, 65535, 0.0)

ASKING_CONTROLS: Final = (
    Control(
        "/dance/get", _get,
        (Argument("address", "text", "a control with a present value, a figure under /dance/status, or a pattern"),),
        "Answers with the message that would set it to what it is now, to the sender only.", "audience",
    ),
    Control(
        "/dance/subscribe", _subscribe,
        (
            Argument("address", "text", "all values at and under this address", default="/dance"),
            Argument("seconds", "float", "how long; say it again before", "s", 1, 3600, 60.0),
            _PORT,
        ),
        "Sends you the present values, and then each that changes, unless you set it.", "musician",
    ),
    Control("/dance/unsubscribe", _unsubscribe, (_PORT,), "Ends that.", "musician"),
)  # fmt: skip
"""What answers with values; `/dance/ping` is among those of the clock."""


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
