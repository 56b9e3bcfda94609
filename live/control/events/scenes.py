"""Events about the picture, and what is recalled by name: light, camera, looks, scenes."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPicture(ControlEvent):
    """A parameter of the picture goes to a new value: a number, a colour or a place (`picture_parameters`)."""

    parameter: str
    """Its address."""
    x: float
    y: float = 0.0
    z: float = 0.0
    """The second and third number of a colour or place."""
    measures: float = 0.0
    group: str = "*"
    """Whose colour it is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPass(ControlEvent):
    """A pass of the picture, by its name, is drawn with this amount: 0 is off. Or a parameter of it is set."""

    name: str
    amount: float
    measures: float = 0.0
    parameter: str = ""
    """Empty: the amount of the pass itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecallView(ControlEvent):
    """The camera goes to a view of the patch; a cut if it takes no time."""

    name: str
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Accompany(ControlEvent):
    """The camera follows somebody from now on, or nobody."""

    whom: str
    """A group, dancers' numbers and words for them, or `off`."""
    along: float = -1.0
    """How far it goes along, 0 to 1; below 0: as it did."""
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowSpot(ControlEvent):
    """A follow spot goes after somebody from now on."""

    whom: str
    """A group, dancers' numbers and words for them."""
    spot: float = 1.0
    """Which one, from 1."""
    level: float = 1.0
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowBackground(ControlEvent):
    """One of the patch's backgrounds is seen, and no other one."""

    name: str
    """Its name, or `none`."""
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RecallLook(ControlEvent):
    """The light changes to a look of the patch."""

    name: str
    measures: float = -1.0
    """Below 0: as many as the look says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecallScene(ControlEvent):
    """Everything that a scene holds goes to its value there."""

    name: str
    measures: float = -1.0
    """Below 0: as many as the scene says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreScene(ControlEvent):
    """A scene of this name keeps where everything is, or is going, now."""

    name: str
