"""How steps are varied and motion is mended.

Which steps are danced.
"""

from collections.abc import Callable
from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import GROUP, MEASURES, WHO, Argument, Control


def _motion(parameter: str) -> Callable[..., ControlEvent]:
    """The event of one parameter of the motion; switches are 0 or 1."""

    def make(*, time: float, source: str, value: float, group: str) -> ControlEvent:
        return events.SetMotion(time=time, source=source, parameter=parameter, value=float(value), group=group)

    return make


_SHARE = Argument("value", "float", "from none to all", "", 0, 1)
_MOTION: Final = (
    (
        "/dance/motion/warp", "warp_beats", Argument("value", "float", "ahead or behind at most", "beats", 0, 1),
        "Dancers are ahead of the beat or behind it, each in her own way, from the next decided measure on.",
    ),
    (
        "/dance/motion/warp_sequence", "warp_sequence",
        Argument("value", "bool", "1: over several measures, 0: within each"),
        "Whether they drift over several measures, or are back on the beat at every measure line.",
    ),
    (
        "/dance/motion/larger", "larger", Argument("value", "float", "0 is as recorded", "", -0.7, 0.5),
        "The upper body moves more or less than recorded, everybody's alike.",
    ),
    (
        "/dance/motion/amplitude", "amplitude", Argument("value", "float", "larger or smaller at most", "", 0, 0.5),
        "The upper body moves more or less than recorded, each dancer in her own way.",
    ),
    (
        "/dance/motion/amplitude_sequence", "amplitude_sequence",
        Argument("value", "bool", "1: over several measures, 0: anew for each"),
        "Whether that changes slowly over several measures, or anew for each.",
    ),
    ("/dance/motion/mix", "mix", _SHARE, "How far another take of the same step is mixed into the body at most."),
    ("/dance/motion/arms", "arms", _SHARE, "Share of the dancers whose upper body dances another take of the step."),
    (
        "/dance/motion/texture", "texture", Argument("value", "float", "steps to recorded dancers", "", 0, 1),
        "How far upper bodies are those of the recordings in [texture], chosen beat by beat by what legs do.",
    ),
    ("/dance/motion/head", "head", _SHARE, "How far heads turn to the public, as far as necks allow."),
    (
        "/dance/motion/obedience", "obedience", Argument("value", "float", "faithful steps to obedient path", "", 0, 1),
        "How far dancers are carried beyond their steps to where the group wants them; status says what that costs.",
    ),
    (
        "/dance/motion/foot_lock", "lock", Argument("value", "bool", "1: hold them, 0: let them slide"),
        "Whether feet that carry stay where they are.",
    ),
    (
        "/dance/motion/turn_on_support", "on_support", Argument("value", "bool", "1: on that foot, 0: evenly"),
        "Whether dancers turn on the foot that carries, or evenly over the measure.",
    ),
    (
        "/dance/motion/face_average", "face_average", Argument("value", "bool", "1: on the average, 0: at their ends"),
        "Whether measures face the wanted way on the average, or when they end.",
    ),
    (
        "/dance/motion/mirror", "mirror", Argument("value", "float", "-1: never, 0: both, 1: only", "", -1, 1),
        "Whether steps are danced as they were made, as mirror images, or both.",
    ),
)  # fmt: skip
"""Address, parameter of SetMotion, its argument, description."""
_START: Final[dict[str, tuple[float | bool]]] = {"lock": (True,), "on_support": (True,), "obedience": (0.5,)}
"""Where they are if a patch says nothing, if that is not 0."""
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
        "Where dancers look when their measures end; a turn takes three measures.", "musician",
    ),
    Control(
        "/dance/why", _why,
        (Argument("dancer", "float", "her number from 1; 0 is nobody any more", "", 0, 100000, default=0.0),),
        "Shows in status and overlay what the dancer was to dance, what was chosen and what nearly was.", "operator",
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
"""The addresses under /dance/motion, and who looks where, and why."""


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
