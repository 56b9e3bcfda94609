"""Controls of formations and evolutions, entrances and exits, and objects on the stage."""

from typing import Final

from live.control.events import events
from live.control.registry.control import DANCERS, GROUP, NEXT, POINTS, X2, Z2, Argument, Control, X, Z

_DURATION: Final = Argument("measures", "float", "duration", "measures", 0.25, 64, 4.0)
_FORMATION: Final = Argument(
    "formation", "text", "a formation of the patch, or words for one: circle, star:6, text:LIVE, `circle poisson`"
)
_GATE: Final = Argument("gate", "name", "gate's name; left, right and back if the patch has none; * any", default="*")
_NAME: Final = Argument("name", "name", "its name")
_RADIUS: Final = Argument("radius", "float", "its radius", "m", 0.05, 20, 0.5)

GROUP_CONTROLS: Final = (
    Control(
        "/dance/formation", events.Evolve,
        (
            _FORMATION, _DURATION, DANCERS, NEXT,
            Argument("match", "name", "squared, shortest, equal, both, bottleneck, number", default="squared"),
            Argument("ripple", "float", "beats from the first dancer's start to the last one's", "beats", 0, 64, 0.0),
        ),
        "Dancers go to a formation and arrive together, exactly on a measure line.", "musician",
    ),
    Control(
        "/dance/formation/define", events.DefineFormation,
        (Argument("name", "name", "the formation's name"), _FORMATION),
        "Defines or changes a formation by name; dancers in it go to its new places.", "operator",
    ),
    Control(
        "/dance/travel", events.Travel,
        (
            POINTS, _DURATION, DANCERS, NEXT,
            Argument("single_file", "bool", "1: in single file on the line, 0: as they stand", default=False),
        ),
        "Dancers travel along a drawn line and keep their formation.", "musician",
    ),
    Control(
        "/dance/pause", events.Pause, (_DURATION, DANCERS, NEXT),
        "Dancers stay where they are for a while.", "musician",
    ),
    Control(
        "/dance/release", events.Release, (DANCERS,),
        "Dancers leave their formation and evolution; only elements move them.", "musician",
    ),
    Control(
        "/dance/ripple", events.SetRipple,
        (
            Argument("beats", "float", "from the first dancer's start to the last's; 0: together", "beats", 0, 16),
            Argument(
                "begins", "text", "its start: left, right, front, back, centre, or x z [m] as in `0 -2`", default="left"
            ),
            GROUP,
        ),
        "Dancers start their steps one after another, as a wave over the group.", "musician",
    ),
    Control(
        "/dance/enter", events.Enter,
        (
            Argument("count", "float", "how many", "", 1, 1000, 1.0),
            Argument("group", "name", "the group whose steps they dance; *: their last group", default="*"),
            _GATE,
        ),
        "Dancers waiting in the wings enter at the next measure line.", "operator",
    ),
    Control(
        "/dance/leave", events.Leave, (Argument("dancers", "text", DANCERS.description), _GATE),
        "Dancers leave the stage.", "operator",
    ),
    Control(
        "/dance/obstacle", events.PlaceObstacle, (_NAME, X, Z, _RADIUS),
        "Places or moves a round obstacle; dancers go around it.", "operator",
    ),
    Control(
        "/dance/wall", events.PlaceWall, (_NAME, X, Z, X2, Z2),
        "Places or moves a wall between two points.", "operator",
    ),
    Control(
        "/dance/obstacle/remove", events.RemoveObstacle, (_NAME,), "Removes an obstacle or a wall.", "operator",
    ),
    Control(
        "/dance/stage", events.SetStage,
        (
            Argument("width", "float", "from side to side", "m", 2, 400),
            Argument("depth", "float", "from back to front", "m", 2, 400),
        ),
        "Resizes the stage about its centre: its border moves in two measures or more, dancers outside walk in. Each "
        "size may be at most 4 m more than the patch's, and at most twice as much.",
        "operator", "continuous", 2,
    ),
    Control(
        "/dance/performer", events.Performer, (_NAME, X, Z),
        "Position of a tracked real dancer, sent repeatedly: virtual dancers give way. It expires after two seconds.",
        "musician", "continuous",
    ),
)  # fmt: skip
