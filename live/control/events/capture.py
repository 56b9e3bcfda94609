"""Events of live motion capture: poses, tracker positions, and settings of captured performers."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class MocapFrame(ControlEvent):
    """Current full-body pose of a captured performer."""

    performer: str
    """The name in the patch's `[[mocap]]`."""
    pose: str
    """Hip position [m] and rotations on the engine's skeleton, as packed by `live.motion.packed_pose`; quantised on
    receipt, so that live and replayed shows get the same bits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CastMocap(ControlEvent):
    """A captured performer drives this dancer from now on."""

    performer: str
    dancer: str
    """An expression as in `live.show.group.casting`, of which the first dancer counts; "none": no dancer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowMocap(ControlEvent):
    """Shows a captured performer, or lets the dancer dance by themselves again."""

    performer: str
    shown: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MirrorMocap(ControlEvent):
    """Mirrors a captured performer, or shows them as captured."""

    performer: str
    mirrored: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceMocap(ControlEvent):
    """Places the centre of a performer's capture floor on the stage."""

    performer: str
    x: float
    z: float
    turn: float = 0.0
    """Degrees, towards +x."""
    scale: float = 1.0
    """Scale of the performer's paths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CanonMocap(ControlEvent):
    """Dancers repeat a captured performer in canon; "none": no dancers."""

    performer: str
    group: str
    beats: float = 2.0
    """Delay from one dancer to the next."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockMocap(ControlEvent):
    """Whether dancers avoid a captured performer as an obstacle on the stage."""

    performer: str
    obstacle: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawMocap(ControlEvent):
    """A captured performer attracts dancers; repels them if strength is below 0; no effect at 0."""

    performer: str
    strength: float
    group: str = "*"
    """The group; "": unchanged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerMoved(ControlEvent):
    """Position of a tracker in the tracking system's own axes [m]."""

    tracker: str
    """Its name in that system, or its number."""
    x: float
    y: float
    z: float
