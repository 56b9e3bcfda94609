"""Commands of formations, groups, entrances and exits, and objects on the stage."""

from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import DANCERS, X2, Z2, Dancers, Next, Points, X, Z, command
from live.control.registry.control import Argument

Duration = Annotated[float, Argument.number("duration", 0.25, 64, "measures")]
Formation = Annotated[
    str,
    Argument.text(
        "a formation of the patch, or words for one: circle, star:6, text:LIVE, `circle poisson`", "formation"
    ),
]
Gate = Annotated[str, Argument.label("gate's name; left, right and back if the patch has none; * any", "gate")]
ItemName = Annotated[str, Argument.label("its name", "obstacle")]
SelectedDancers = Annotated[str, Argument.text(DANCERS.description, "group")]


@command("/dance/formation", "musician")
class Evolve(ControlEvent):
    """Dancers go to a formation and arrive together, exactly on a measure line.

    (T096; assignment of dancers to places T097-T100.)
    """

    formation: Formation
    """A name in the patch, or a description (`live.agents.formations.formation_notation`)."""
    measures: Duration = 4.0
    group: Dancers = "*"
    next: Next = False
    match: Annotated[str, Argument.label("squared, shortest, equal, both, bottleneck, number")] = "squared"
    ripple: Annotated[
        float, Argument.number("beats from the first dancer's start to the last one's", 0, 64, "beats")
    ] = 0.0


@command("/dance/formation/define", "operator", edits="formations")
class DefineFormation(ControlEvent):
    """Defines or changes a formation by name; dancers in it go to its new places.

    (T087)
    """

    name: Annotated[str, Argument.label("the formation's name")]
    formation: Formation


@command("/dance/travel", "musician")
class Travel(ControlEvent):
    """Dancers travel along a drawn line and keep their formation.

    (T103)
    """

    points: Points
    measures: Duration = 4.0
    group: Dancers = "*"
    next: Next = False
    single_file: Annotated[bool, Argument.switch("1: in single file on the line, 0: as they stand")] = False


@command("/dance/pause", "musician")
class Pause(ControlEvent):
    """Dancers stay where they are for a while.

    (T103)
    """

    measures: Duration = 4.0
    group: Dancers = "*"
    next: Next = False


@command("/dance/release", "musician")
class Release(ControlEvent):
    """Dancers leave their formation and evolution; only elements move them."""

    group: Dancers = "*"


@command("/dance/ripple", "musician", edits="ripples")
class SetRipple(ControlEvent):
    """Dancers start their steps one after another, as a wave over the group.

    (T051)
    """

    beats: Annotated[float, Argument.number("from the first dancer's start to the last's; 0: together", 0, 16, "beats")]
    begins: Annotated[str, Argument.text("its start: left, right, front, back, centre, or x z [m] as in `0 -2`")] = (
        "left"
    )
    group: Dancers = "*"


@command("/dance/enter", "operator")
class Enter(ControlEvent):
    """Dancers waiting in the wings enter at the next measure line."""

    count: Annotated[float, Argument.number("how many", 1, 1000)] = 1.0
    group: Annotated[str, Argument.label("the group whose steps they dance; *: their last group", "group")] = "*"
    gate: Gate = "*"


@command("/dance/leave", "operator")
class Leave(ControlEvent):
    """Dancers leave the stage."""

    dancers: SelectedDancers
    gate: Gate = "*"


@command("/dance/obstacle", "operator", edits="set")
class PlaceObstacle(ControlEvent):
    """Places or moves a round obstacle; dancers go around it."""

    name: ItemName
    x: X
    z: Z
    radius: Annotated[float, Argument.number("its radius", 0.05, 20, "m")] = 0.5


@command("/dance/wall", "operator", edits="set")
class PlaceWall(ControlEvent):
    """Places or moves a wall between two points."""

    name: ItemName
    x: X
    z: Z
    x2: X2
    z2: Z2


@command("/dance/obstacle/remove", "operator", edits="set")
class RemoveObstacle(ControlEvent):
    """Removes an obstacle or a wall."""

    name: ItemName


@command("/dance/stage", "operator", value=2)
class SetStage(ControlEvent):
    """Resizes the stage about its centre: its border moves in two measures or more, dancers outside walk in. Each size
    may be at most 4 m more than the patch's, and at most twice as much."""

    width: Annotated[float, Argument.number("from side to side", 2, 400, "m")]
    depth: Annotated[float, Argument.number("from back to front", 2, 400, "m")]


@command("/dance/performer", "musician", continuous=True)
class Performer(ControlEvent):
    """Position of a tracked real dancer, sent repeatedly: virtual dancers give way. It expires after two seconds."""

    name: Annotated[str, Argument.label("its name")]
    x: X
    z: Z


@command("/dance/regroup", "musician")
class Regroup(ControlEvent):
    """Dancers leave their group and dance the steps of another.

    (T104; from their next measure on.)
    """

    dancers: SelectedDancers
    group: Annotated[
        str, Argument.label("the group of the patch whose steps they dance from their next measure on", "group")
    ]
