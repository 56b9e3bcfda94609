"""Queries and subscriptions of a sender, and controls of the machines of a show."""

from typing import Final

from live.control.events.system import ResetBreaker, TakeOver
from live.control.registry.control import Argument, Control, Request


def _get(*, time: float, source: str, address: str) -> Request:
    return Request("get", address)


def _subscribe(*, time: float, source: str, address: str, seconds: float, port: float) -> Request:
    return Request("subscribe", address, seconds, round(port))


def _unsubscribe(*, time: float, source: str, port: float) -> Request:
    return Request("unsubscribe", port=round(port))


_PORT: Final = Argument("port", "float", "your receiving port; 0: the port that you send from", "", 0, 65535, 0.0)

QUERY_CONTROLS: Final = (
    Control(
        "/dance/get", _get,
        (Argument("address", "text", "a control with a current value, a figure under /dance/status, or a pattern"),),
        "Answers with the message that would set the current value, to the sender only.", "audience",
    ),
    Control(
        "/dance/subscribe", _subscribe,
        (
            Argument("address", "text", "all values at and under this address", default="/dance"),
            Argument("seconds", "float", "duration; renew it in time", "s", 1, 3600, 60.0),
            _PORT,
        ),
        "Sends you the current values, and then each that changes, unless you set it.", "musician",
    ),
    Control("/dance/unsubscribe", _unsubscribe, (_PORT,), "Ends the subscription.", "musician"),
)  # fmt: skip
"""Queries and subscriptions; `/dance/ping` is in `clock_controls`."""


MACHINE_CONTROLS: Final = (
    Control(
        "/dance/takeover", TakeOver, (),
        "For a standby machine (`live play --standby`): it becomes the leader, and the old leader goes dark.",
        "operator",
    ),
    Control(
        "/dance/breaker/reset", ResetBreaker,
        (Argument("name", "name", "its name in the overlay and the status; left out: all", default=""),),
        "Re-enables a stage of the show that was disabled because it failed repeatedly.",
        "operator",
    ),
)  # fmt: skip
