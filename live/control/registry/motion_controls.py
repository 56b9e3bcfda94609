"""Controls of motion variation and correction, and of the choice of steps."""

from collections.abc import Callable
from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import DANCERS, GROUP, MEASURES, Argument, Control


def _motion(parameter: str) -> Callable[..., ControlEvent]:
    """Return the event constructor of one motion parameter; switches are 0 or 1."""

    def make(*, time: float, source: str, value: float, group: str) -> ControlEvent:
        return events.SetMotion(time=time, source=source, parameter=parameter, value=float(value), group=group)

    return make


_SHARE = Argument("value", "float", "from none to all", "", 0, 1)
_MOTION: Final = (
    (
        "/dance/motion/warp", "warp_beats", Argument("value", "float", "maximum lead or lag", "beats", 0, 1),
        "Each dancer drifts ahead of the beat or behind it in a different way, from the next decided measure on.",
    ),
    (
        "/dance/motion/warp_sequence", "warp_sequence",
        Argument("value", "bool", "1: over several measures, 0: within each"),
        "Whether this drift runs over several measures, or returns to the beat at every measure line.",
    ),
    (
        "/dance/motion/larger", "larger", Argument("value", "float", "0 is as recorded", "", -0.7, 0.5),
        "The upper body moves more or less than recorded, for all dancers alike.",
    ),
    (
        "/dance/motion/amplitude", "amplitude", Argument("value", "float", "maximum change", "", 0, 0.5),
        "The upper body moves more or less than recorded, differently for each dancer.",
    ),
    (
        "/dance/motion/amplitude_sequence", "amplitude_sequence",
        Argument("value", "bool", "1: over several measures, 0: new for each"),
        "Whether that amplitude changes slowly over several measures, or is new for each.",
    ),
    ("/dance/motion/mix", "mix", _SHARE, "Maximum share of another take of the same step that is mixed into the body."),
    ("/dance/motion/arms", "arms", _SHARE, "Share of the dancers whose upper body dances another take of the step."),
    (
        "/dance/motion/texture", "texture", Argument("value", "float", "steps to recorded dancers", "", 0, 1),
        "How far upper bodies follow the recordings in [texture], chosen beat by beat to match the legs.",
    ),
    ("/dance/motion/head", "head", _SHARE, "How far heads turn to the public, within the neck's limits."),
    (
        "/dance/motion/obedience", "obedience", Argument("value", "float", "faithful steps to obedient path", "", 0, 1),
        "How far a dancer's path is corrected from their steps to the group's target; the status shows the cost.",
    ),
    (
        "/dance/motion/foot_lock", "lock", Argument("value", "bool", "1: hold them, 0: let them slide"),
        "Whether supporting feet stay in place.",
    ),
    (
        "/dance/motion/turn_on_support", "on_support", Argument("value", "bool", "1: on that foot, 0: evenly"),
        "Whether dancers turn on the supporting foot, or evenly over the measure.",
    ),
    (
        "/dance/motion/face_average", "face_average", Argument("value", "bool", "1: on the average, 0: at their ends"),
        "Whether dancers face the wanted direction on average over a measure, or at its end.",
    ),
    (
        "/dance/motion/mirror", "mirror", Argument("value", "float", "-1: never, 0: both, 1: only", "", -1, 1),
        "Whether steps are danced as recorded, mirrored, or both.",
    ),
)  # fmt: skip
"""Address, parameter of SetMotion, its argument, description."""
_START: Final[dict[str, tuple[float | bool]]] = {"lock": (True,), "on_support": (True,), "obedience": (0.5,)}
"""Defaults other than 0."""
MOTION_PARAMETERS: Final = {address: (parameter, argument) for address, parameter, argument, _ in _MOTION}
"""Parameter of SetMotion and its argument by address."""


def _why(*, time: float, source: str, dancer: float) -> ControlEvent:
    return events.AskWhy(time=time, source=source, dancer=round(dancer))


_OTHERS: Final = (
    Control(
        "/dance/facing", events.SetFacing,
        (
            Argument("facing", "text", "public, path, centre, attractor, degrees as `30`, `dancer 3`, or a group"),
            GROUP,
        ),
        "The direction that dancers face when their measures end; a turn takes three measures.", "musician",
    ),
    Control(
        "/dance/why", _why,
        (Argument("dancer", "float", "the dancer's number from 1; 0: none", "", 0, 100000, default=0.0),),
        "Shows in status and overlay the dancer's targets, the chosen step and the runners-up.", "operator",
    ),
)  # fmt: skip

MOTION_CONTROLS: Final = (
    tuple(
        Control(
            address, _motion(parameter), (argument, GROUP), description, "operator", "continuous", 1,
            _START.get(parameter, (False if argument.type == "bool" else 0.0,)),
        )
        for address, parameter, argument, description in _MOTION
    )
    + _OTHERS
)  # fmt: skip
"""The controls under /dance/motion, facing, and the explanation of a dancer's choice."""


STEP_CONTROLS: Final = (
    Control(
        "/dance/clear", events.Clear, (),
        "Ends all elements and evolutions; the patch chooses the steps again.", "operator",
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
            DANCERS,
            Argument(
                "measures", "float", "how long whole groups keep dancing it after the current measure",
                "measures", 0.0, 1024, 1.0,
            ),
        ),
        "Dancers change to this step at the next half beat, without losing the beat.", "musician",
    ),
    Control(
        "/dance/sequence", events.SetSequence,
        (
            Argument("steps", "text", 'names separated by commas, as "couru, couru left, echappe x2, *"'),
            GROUP,
        ),
        "Dancers repeat these steps in order until /dance/clear; refused, with the dance unchanged, if no transitions "
        "connect them.", "musician",
    ),
    Control(
        "/dance/regroup", events.Regroup,
        (
            Argument("dancers", "text", DANCERS.description),
            Argument("group", "name", "the group of the patch whose steps they dance from their next measure on"),
        ),
        "Dancers leave their group and dance the steps of another.", "musician",
    ),
)  # fmt: skip
