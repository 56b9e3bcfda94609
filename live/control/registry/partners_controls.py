"""Who answers whom."""

from collections.abc import Callable
from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import Argument, Control, X, Z

_PARTNER: Final = Argument("partner", "name", "the partner's name in the patch; a single * is every one", default="*")


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
        "/dance/partner/on", _set("on"), (Argument("value", "bool", "1: answer, 0: dance your own steps"), _PARTNER),
        "Dancers answer their leader, or go back to their own steps, over one measure.", "musician", "continuous", 1,
    ),
    Control(
        "/dance/partner/amount", _set("amount"),
        (Argument("value", "float", "from their own steps to the answer", "", 0, 1), _PARTNER),
        "How far the answer is in.", "operator", "continuous", 1,
    ),
    Control(
        "/dance/partner/stretch", _set("window"),
        (Argument("value", "float", "from the beat at most; the patch's `stretch` bounds it", "s", 0, 0.4), _PARTNER),
        "How much earlier or later than the beat units of an answer may begin and end.", "operator", "continuous", 1,
    ),
    Control(
        "/dance/partner/hands", _set("hands"),
        (Argument("value", "float", "from hands as they are danced to hands that are held", "", 0, 1), _PARTNER),
        "How far hands are held where the examples' are, within reach.", "operator", "continuous", 1,
    ),
    Control(
        "/dance/partner/leader", _pair("leader"), (Argument("who", "text", f"{_WHO}; `path`: nobody"), _PARTNER),
        "Somebody else leads; who answered leaves her leader over a measure and answers the new one then.", "operator",
    ),
    Control(
        "/dance/partner/follower", _pair("follower"), (Argument("who", "text", _WHO), _PARTNER),
        "Others answer: as many as lead, or all of them one leader.", "operator",
    ),
    Control(
        "/dance/partner/path", events.WalkOn,
        (
            X, Z, _PARTNER,
            Argument("anew", "bool", "1: points before do not count any more", default=False),
        ),
        "Who is led by her own way walks on to this point, after those before: a path, point by point as it is drawn.",
        "musician",
    ),
)  # fmt: skip
"""The addresses under /dance/partner."""
