"""Which steps are danced."""

from typing import Final

from live.control.events import events
from live.control.registry.arguments import GROUP, MEASURES, WHO
from live.control.registry.control import Argument, Control

STEP_CONTROLS: Final = (
    Control(
        "/dance/clear", events.Clear, (),
        "All elements end, evolutions are forgotten, and the patch chooses the steps again.", "operator",
    ),
    Control(
        "/dance/step", events.CallStep,
        (Argument("name", "name", "the step's name in the show's library"), MEASURES, GROUP),
        "Dancers dance this step from the next free measure on.", "musician",
    ),
    Control(
        "/dance/now", events.StepNow,
        (
            Argument("name", "name", "the step's name in the show's library"),
            WHO,
            Argument(
                "measures", "float", "how long after the measure that runs it is danced by groups that are meant whole",
                "measures", 0.0, 1024, 1.0,
            ),
        ),
        "Dancers leave what they dance for this step at the next half beat, without losing the beat.", "musician",
    ),
    Control(
        "/dance/sequence", events.SetSequence,
        (
            Argument("steps", "text", 'names with commas between them, as "couru, couru left, echappe x2, *"'),
            GROUP,
        ),
        "Dancers dance these steps in order, again and again, until /dance/clear; refused, and the present dance "
        "goes on, if they cannot be joined.", "musician",
    ),
    Control(
        "/dance/regroup", events.Regroup,
        (
            Argument("dancers", "text", WHO.description),
            Argument("group", "name", "the group of the patch whose steps they dance from their next measure on"),
        ),
        "Dancers leave their group for another one's steps.", "musician",
    ),
)  # fmt: skip
