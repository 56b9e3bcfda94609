"""Events of live motion capture: who is seen moving, how, and what becomes of her on the stage."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class MocapFrame(ControlEvent):
    """A real dancer, whose whole body is captured, stands like this now."""

    performer: str
    """Her name, as in the patch's `[[mocap]]`."""
    pose: str
    """Hips [m] and rotations on the engine's skeleton, as `live.motion.packed_pose` packs them: quantised when
    it was received, so that live and replayed shows see the same bits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CastMocap(ControlEvent):
    """A captured performer is this dancer from now on."""

    performer: str
    dancer: str
    """Words as in `live.show.group.casting`: the first of whom they mean; "none": nobody."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowMocap(ControlEvent):
    """A captured performer is seen, or her dancer goes back to dancing herself."""

    performer: str
    shown: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MirrorMocap(ControlEvent):
    """A captured performer is seen as in a mirror, or as she is."""

    performer: str
    mirrored: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceMocap(ControlEvent):
    """Where the middle of a captured performer's floor lies on the stage."""

    performer: str
    x: float
    z: float
    turn: float = 0.0
    """Degrees, towards +x."""
    scale: float = 1.0
    """How long her ways become."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CanonMocap(ControlEvent):
    """Dancers repeat a captured performer, one after another; "none": nobody does any more."""

    performer: str
    group: str
    beats: float = 2.0
    """From one to the next."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockMocap(ControlEvent):
    """A captured performer is somebody real on the stage, whom dancers go out of the way of, or only a picture."""

    performer: str
    obstacle: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawMocap(ControlEvent):
    """A captured performer draws dancers to her; with a strength below 0 she drives them away, with 0 neither."""

    performer: str
    strength: float
    group: str = "*"
    """Whom; "": whom she did."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerMoved(ControlEvent):
    """A tracker is here now, in the tracking system's own axes [m]."""

    tracker: str
    """What it is called there, or its number."""
    x: float
    y: float
    z: float
