"""Formations and evolutions, who enters and leaves, and what stands on the stage."""

from typing import Final

from live.control.events import events
from live.control.registry.control import GROUP, NEXT, POINTS, WHO, X2, Z2, Argument, Control, X, Z

_WHOLE: Final = Argument("measures", "float", "how many measures it takes", "measures", 0.25, 64, 4.0)
_FORMATION: Final = Argument(
    "formation", "text", "a formation of the patch, or words for one: circle, star:6, text:LIVE, `circle poisson`"
)
_GATE: Final = Argument("gate", "name", "its name; left, right and back if the patch has none; * any", default="*")
_NAME: Final = Argument("name", "name", "what it is called")
_RADIUS: Final = Argument("radius", "float", "how far it reaches", "m", 0.05, 20, 0.5)

GROUP_CONTROLS: Final = (
    Control(
        "/dance/formation", events.Evolve,
        (
            _FORMATION, _WHOLE, WHO, NEXT,
            Argument("match", "name", "squared, shortest, equal, both, bottleneck, number", default="squared"),
            Argument("ripple", "float", "beats from the first who starts to the last", "beats", 0, 64, 0.0),
        ),
        "Dancers go to a formation and arrive together, exactly on a measure.", "musician",
    ),
    Control(
        "/dance/formation/define", events.DefineFormation,
        (Argument("name", "name", "what the formation is called from now on"), _FORMATION),
        "Makes or changes a formation by name; whoever is in it goes to its new places.", "operator",
    ),
    Control(
        "/dance/travel", events.Travel,
        (
            POINTS, _WHOLE, WHO, NEXT,
            Argument("single_file", "bool", "1: one behind another on the line, 0: all as they stand", default=False),
        ),
        "Dancers travel along a drawn line and keep their formation.", "musician",
    ),
    Control(
        "/dance/pause", events.Pause, (_WHOLE, WHO, NEXT), "Dancers stay where they are for a while.", "musician",
    ),
    Control(
        "/dance/release", events.Release, (WHO,),
        "Dancers leave their formation and evolution; elements alone move them.", "musician",
    ),
    Control(
        "/dance/ripple", events.SetRipple,
        (
            Argument("beats", "float", "from the first who begins a step to the last; 0: all together", "beats", 0, 16),
            Argument(
                "begins", "text", "where: left, right, front, back, centre, or x z [m] as in `0 -2`", default="left"
            ),
            GROUP,
        ),
        "Dancers begin their steps one after another, as a wave runs over the group.", "musician",
    ),
    Control(
        "/dance/enter", events.Enter,
        (
            Argument("count", "float", "how many", "", 1, 1000, 1.0),
            Argument("group", "name", "the group whose steps they dance; * the one they danced with last", default="*"),
            _GATE,
        ),
        "Dancers who wait in the wings enter at the next measure line.", "operator",
    ),
    Control(
        "/dance/leave", events.Leave, (Argument("dancers", "text", WHO.description), _GATE),
        "Dancers leave the stage.", "operator",
    ),
    Control(
        "/dance/obstacle", events.PlaceObstacle, (_NAME, X, Z, _RADIUS),
        "Puts something round on the stage, or moves what has this name: dancers go around it.", "operator",
    ),
    Control(
        "/dance/wall", events.PlaceWall, (_NAME, X, Z, X2, Z2),
        "Puts up a wall between two points, or moves the one of this name.", "operator",
    ),
    Control(
        "/dance/obstacle/remove", events.RemoveObstacle, (_NAME,), "Takes away what has this name.", "operator",
    ),
    Control(
        "/dance/stage", events.SetStage,
        (
            Argument("width", "float", "from side to side", "m", 2, 400),
            Argument("depth", "float", "from back to front", "m", 2, 400),
        ),
        "Makes the stage larger or smaller about its centre: its border moves there in two measures or more, dancers "
        "outside walk in. At most 4 m more than the patch's each way, and at most twice as much.",
        "operator", "continuous", 2,
    ),
    Control(
        "/dance/performer", events.Performer, (_NAME, X, Z),
        "Where a real dancer is, as often as she is tracked: virtual ones give way; forgotten after two seconds.",
        "musician", "continuous",
    ),
)  # fmt: skip
