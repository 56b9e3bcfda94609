"""Events about partners: who answers whom, and how far."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPartner(ControlEvent):
    """How dancers answer their leader: one parameter, of one partner or (`*`) of all."""

    parameter: str
    """`on`, `amount`, or `window`: how much earlier or later than the beat units may begin [s]."""
    value: float
    partner: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class PairPartner(ControlEvent):
    """Others lead or answer from now on."""

    role: str
    """`leader` or `follower`."""
    who: str
    """A group, or groups, attributes and numbers; `path` as the leader: nobody."""
    partner: str


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkOn(ControlEvent):
    """Who walks along a way goes on to (x, z) [m], after all points before."""

    x: float
    z: float
    partner: str = "*"
    anew: bool = False
    """A new way begins: points before do not count any more."""
