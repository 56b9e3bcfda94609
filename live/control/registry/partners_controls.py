"""Controls of partner responses: leaders, followers and amounts."""

from collections.abc import Callable
from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import Argument, Control, X, Z

_PARTNER: Final = Argument("partner", "name", "the partner's name in the patch; a single * is all", default="*")


def _set(parameter: str) -> Callable[..., ControlEvent]:
    def make(*, time: float, source: str, value: float, partner: str) -> ControlEvent:
        return events.SetPartner(time=time, source=source, parameter=parameter, value=float(value), partner=partner)

    return make


def _pair(role: str) -> Callable[..., ControlEvent]:
    def make(*, time: float, source: str, who: str, partner: str) -> ControlEvent:
        return events.PairPartner(time=time, source=source, role=role, who=who, partner=partner)

    return make


_WHO: Final = "a group, or groups, attributes and numbers as in `ember & 1`"

PARTNER_CONTROLS: Final = (
    Control(
        "/dance/partner/on", _set("on"), (Argument("value", "bool", "1: respond, 0: own steps"), _PARTNER),
        "Dancers respond to their leader, or return to their own steps, over one measure.", "musician", "continuous", 1,
    ),
    Control(
        "/dance/partner/amount", _set("amount"),
        (Argument("value", "float", "from own steps to response", "", 0, 1), _PARTNER),
        "Blend from the dancers' own steps to the response.", "operator", "continuous", 1,
    ),
    Control(
        "/dance/partner/stretch", _set("window"),
        (Argument("value", "float", "largest shift, up to the patch's `stretch`", "s", 0, 0.4), _PARTNER),
        "How far from the beat units of a response may start and end.", "operator", "continuous", 1,
    ),
    Control(
        "/dance/partner/hands", _set("hands"),
        (Argument("value", "float", "from free hands to held hands", "", 0, 1), _PARTNER),
        "How far hands are held as in the examples, within reach.", "operator", "continuous", 1,
    ),
    Control(
        "/dance/partner/leader", _pair("leader"), (Argument("who", "text", f"{_WHO}; `path`: a drawn path"), _PARTNER),
        "Changes the leader; followers leave the old leader over one measure, then respond to the new one.", "operator",
    ),
    Control(
        "/dance/partner/follower", _pair("follower"), (Argument("who", "text", _WHO), _PARTNER),
        "Changes the followers: one per leader, or all for one leader.", "operator",
    ),
    Control(
        "/dance/partner/path", events.WalkOn,
        (
            X, Z, _PARTNER,
            Argument("anew", "bool", "1: start a new path", default=False),
        ),
        "Adds a point to the path of a dancer that is led by a path, after the earlier points.",
        "musician",
    ),
)  # fmt: skip
"""The controls under /dance/partner."""
