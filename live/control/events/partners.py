"""Events of partner responses: parameters, leaders, followers and paths."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPartner(ControlEvent):
    """Sets one parameter of the response, of one partner or (`*`) of all."""

    parameter: str
    """`on`, `amount`, `hands`, or `window`: the largest shift of units from the beat [s]."""
    value: float
    partner: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class PairPartner(ControlEvent):
    """Changes the leader or the followers."""

    role: str
    """`leader` or `follower`."""
    who: str
    """A group, or groups, attributes and numbers; `path` as the leader: a drawn path."""
    partner: str


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkOn(ControlEvent):
    """Adds the point (x, z) [m] to the path of a dancer that is led by a path."""

    x: float
    z: float
    partner: str = "*"
    anew: bool = False
    """Whether a new path starts, without the earlier points."""
