"""Events of picture parameters, passes, camera, spots, backgrounds, looks and scenes."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPicture(ControlEvent):
    """Sets or fades a parameter of the picture: a number, a colour or a place (`picture_parameters`)."""

    parameter: str
    """Address of the parameter."""
    x: float
    y: float = 0.0
    z: float = 0.0
    """Second and third number of a colour or place."""
    measures: float = 0.0
    group: str = "*"
    """The group, for parameters of groups."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPass(ControlEvent):
    """Sets the amount of a pass (0 is off), or one of its parameters."""

    name: str
    amount: float
    measures: float = 0.0
    parameter: str = ""
    """Empty: the amount of the pass itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecallView(ControlEvent):
    """Moves the camera to a view of the patch, or cuts to it if `measures` is 0."""

    name: str
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Accompany(ControlEvent):
    """The camera follows dancers, or stops following."""

    whom: str
    """A group, or an expression for dancers, or `off`."""
    along: float = -1.0
    """How far the camera moves with them, 0 to 1; below 0: unchanged."""
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowSpot(ControlEvent):
    """A follow spot follows dancers."""

    whom: str
    """A group, or an expression for dancers."""
    spot: float = 1.0
    """Number of the spot, from 1."""
    level: float = 1.0
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowBackground(ControlEvent):
    """Shows one of the patch's backgrounds instead of the others."""

    name: str
    """Name of the background, or `none`."""
    measures: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RecallLook(ControlEvent):
    """Changes the light to a look of the patch."""

    name: str
    measures: float = -1.0
    """Below 0: the look's own duration."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecallScene(ControlEvent):
    """Recalls all values of a scene."""

    name: str
    measures: float = -1.0
    """Below 0: the scene's own duration."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreScene(ControlEvent):
    """Stores all current values, or the targets of running fades, as a scene of this name."""

    name: str
