"""Commands for captured performers, and live motion capture: poses and tracker positions."""

from dataclasses import dataclass
from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import Dancers, X, Z, command
from live.control.registry.control import Argument

PerformerName = Annotated[
    str,
    Argument.label(
        "the name in the patch; `live` if it has none. Also in the address: /dance/mocap/NAME/...", "performer"
    ),
]


@dataclass(frozen=True, slots=True, kw_only=True)
class MocapFrame(ControlEvent):
    """Current full-body pose of a captured performer."""

    performer: str
    """The name in the patch's `[[mocap]]`."""
    pose: str
    """Hip position [m] and rotations on the engine's skeleton, as packed by `live.motion.capture.packed_pose`;
    quantised on receipt, so that live and replayed shows get the same bits."""


@command("/dance/mocap/dancer", "operator", value=1, named=True, edits="mocap")
class CastMocap(ControlEvent):
    """A captured performer drives this dancer; the former one dances by themselves again."""

    performer: PerformerName
    dancer: Annotated[str, Argument.text("the dancer, or the first of `ember & 1` or a group; none: no dancer")]


@command("/dance/mocap/shown", "musician", value=1, named=True, edits="mocap")
class ShowMocap(ControlEvent):
    """Whether a captured performer is shown; the dancer changes over within a measure."""

    performer: PerformerName
    shown: Annotated[bool, Argument.switch("1: the dancer moves as the performer does, 0: by themselves")] = True


@command("/dance/mocap/mirrored", "musician", value=1, named=True, edits="mocap")
class MirrorMocap(ControlEvent):
    """Mirrors a captured performer."""

    performer: PerformerName
    mirrored: Annotated[bool, Argument.switch("1: left and right exchanged, 0: as captured")] = True


@command("/dance/mocap/place", "operator", value=4, named=True, edits="mocap")
class PlaceMocap(ControlEvent):
    """Place of the capture floor's centre on the stage."""

    performer: PerformerName
    x: X
    z: Z
    turn: Annotated[float, Argument.number("rotation of the floor on the stage, towards +x", -360, 360, "degrees")] = (
        0.0
    )
    scale: Annotated[float, Argument.number("scale of the paths; feet slide unless it is 1", 0, 10)] = 1.0


@command("/dance/mocap/canon", "musician", value=2, named=True, edits="mocap")
class CanonMocap(ControlEvent):
    """Other dancers repeat a captured performer in canon: the first by that delay, the second by twice as much."""

    performer: PerformerName
    group: Annotated[str, Argument.text("dancers that repeat: `ember` or `mist & 13-16`; none: nobody", "group")] = (
        "none"
    )
    beats: Annotated[float, Argument.number("delay from one dancer to the next", 0, 16, "beats")] = 2.0


@command("/dance/mocap/obstacle", "operator", value=1, named=True, edits="mocap")
class BlockMocap(ControlEvent):
    """Whether a captured performer is an obstacle for other dancers."""

    performer: PerformerName
    obstacle: Annotated[bool, Argument.switch("1: dancers avoid the performer as a real person, 0: not")] = True


@command("/dance/mocap/attract", "musician", value=2, named=True, edits="mocap")
class DrawMocap(ControlEvent):
    """A captured performer attracts dancers."""

    performer: PerformerName
    strength: Annotated[float, Argument.number("how strongly; below 0: repels, 0: no effect", -10, 10)] = 1.0
    group: Annotated[str, Argument.label("a group's name; * is all; left out: unchanged", "group")] = ""


@command("/dance/stage_camera/exchange", "operator")
class ExchangeSeen(ControlEvent):
    """Exchanges two performers whom a camera took for each other."""

    performer: Annotated[str, Argument.label("the name of one in the patch", "performer")]
    other: Annotated[str, Argument.label("the name of the other one", "performer")]


@command("/dance/gesture/learn", "operator")
class LearnGesture(ControlEvent):
    """The last beats of a captured performer become an example of this gesture, found about a second later and
    saved with the patch."""

    name: Annotated[str, Argument.label("the gesture's name, that of its signal", "gesture")]
    beats: Annotated[float, Argument.number("how many beats it took", 1, 16, "beats")] = 4.0
    performer: Annotated[str, Argument.label("the performer; left out: the one seen last", "performer")] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerMoved(ControlEvent):
    """Position of a tracker in the tracking system's own axes [m]."""

    tracker: str
    """Its name in that system, or its number."""
    x: float
    y: float
    z: float


@command("/dance/learn", "operator")
class LearnStep(ControlEvent):
    """Learns a step from a captured performer: what was danced becomes a step, which dancers dance at the next measure
    but one."""

    performer: PerformerName
    name: Annotated[str, Argument.label("the new step's name")]
    measures: Annotated[int, Argument.number("its length", 1, 4, "measures")] = 1
    group: Dancers = "*"
    when: Annotated[
        str, Argument.label("last: what was danced just now, next: what will be danced from the next line")
    ] = "last"
    repeats: Annotated[int, Argument.number("how often the dancers dance it", 0, 64)] = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class LearningFailed(ControlEvent):
    """What a performer danced could not become a step."""

    performer: str
    name: str
    """The step's name."""
    reason: str


AnswerName = Annotated[str, Argument.label("the answer's name in the patch; a single * is all", "answer")]


@command("/dance/answer/on", "musician", value=1)
class SwitchAnswer(ControlEvent):
    """Whether dancers answer the steps of a captured performer."""

    on: Annotated[bool, Argument.switch("1: they answer, 0: they do not")] = True
    answer: AnswerName = "*"


@command("/dance/answer/how", "musician", value=1)
class SetAnswerHow(ControlEvent):
    """How dancers answer the steps of a captured performer."""

    how: Annotated[str, Argument.label("same, next (a measure later), other, or map", default="same")]
    answer: AnswerName = "*"


@command("/dance/answer/group", "operator", value=1)
class SetAnswerGroup(ControlEvent):
    """Who answers the steps of a captured performer."""

    group: Dancers = "*"
    answer: AnswerName = "*"
