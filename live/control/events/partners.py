"""Commands of partner responses: values, styles, leaders, followers and paths."""

from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import X, Z, command
from live.control.registry.control import Argument

_WHO = "a group, or groups, attributes and numbers as in `ember & 1`"
PartnerName = Annotated[str, Argument.label("the partner's name in the patch; a single * is all", "partner")]


@command(
    "/dance/partner/on", "musician", value=1, fixed={"parameter": "on"},
    description="Dancers respond to their leader, or return to their own steps, over one measure.",
    arguments={"value": Argument.switch("1: respond, 0: own steps")},
)  # fmt: skip
@command(
    "/dance/partner/amount", "operator", value=1, fixed={"parameter": "amount"},
    description="Blend from the dancers' own steps to the response.",
    arguments={"value": Argument.number("from own steps to response", 0, 1)},
)  # fmt: skip
@command(
    "/dance/partner/stretch", "operator", value=1, fixed={"parameter": "window"},
    description="How far from the beat units of a response may start and end.",
    arguments={"value": Argument.number("largest shift, up to the patch's `stretch`", 0, 0.4, "s")},
)  # fmt: skip
@command(
    "/dance/partner/hands", "operator", value=1, fixed={"parameter": "hands"},
    description="How far hands are held as in the examples, within reach.",
    arguments={"value": Argument.number("from free hands to held hands", 0, 1)},
)  # fmt: skip
class SetPartner(ControlEvent):
    """Sets one value of the response, of one partner or (`*`) of all."""

    parameter: str
    """`on`, `amount`, `hands`, or `window`: the largest shift of units from the beat [s]."""
    value: Annotated[float, Argument.number("its value", 0, 1)]
    partner: PartnerName = "*"


@command("/dance/partner/style", "musician", value=1)
class StylePartner(ControlEvent):
    """Followers dance only as examples of this style do, and as those without one; "" is all examples."""

    style: Annotated[str, Argument.label("a style of the pairs in the examples; empty: all", default="")] = ""
    partner: PartnerName = "*"


@command(
    "/dance/partner/leader", "operator", fixed={"role": "leader"},
    description="Changes the leader; followers leave the old leader over one measure, then respond to the new one.",
    arguments={"who": Argument.text(f"{_WHO}; `path`: a drawn path")},
)  # fmt: skip
@command(
    "/dance/partner/follower", "operator", fixed={"role": "follower"},
    description="Changes the followers: one per leader, or all for one leader.",
)  # fmt: skip
class PairPartner(ControlEvent):
    """Changes the leader or the followers."""

    role: str
    """`leader` or `follower`."""
    who: Annotated[str, Argument.text(_WHO)]
    partner: PartnerName = "*"


@command("/dance/partner/path", "musician")
class WalkOn(ControlEvent):
    """Adds a point to the path of a dancer that is led by a path, after the earlier points."""

    x: X
    z: Z
    partner: PartnerName = "*"
    anew: Annotated[bool, Argument.switch("1: start a new path")] = False
