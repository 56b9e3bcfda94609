"""Controls of the parameters, made from their rows (`live.base.parameter`)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, Literal

from live.base.motion_parameters import MOOD_NAMES, MOTION_PARAMETERS, MOTION_PREFIX
from live.base.parameter import Parameter
from live.base.picture_parameters import GROUP_PARAMETERS, PARAMETERS
from live.control.events.event import ControlEvent
from live.control.events.parameters import SetParameter
from live.control.registry.command import DANCERS
from live.control.registry.control import Argument, ArgumentValue, Control

_MEASURES: Final = Argument("measures", "float", "how long it takes; 0 is at once", "measures", 0, 1024, 0.0)
_GROUP: Final = replace(DANCERS, name="group", default="*")


def value_arguments(row: Parameter) -> tuple[Argument, ...]:
    """Return the arguments for the numbers of a parameter."""
    if row.kind == "names":
        form = f"one of {', '.join(row.choices)}, or several with + between them"
        kept = row.address.rpartition("/")[2]
        return (Argument(kept, "name", row.components[0], convert=row.number_of_names, form=form, names=kept),)
    kind: Literal["bool", "float"] = "bool" if row.kind == "switch" else "float"
    return tuple(
        Argument(name, kind, words, row.unit, row.low, row.high)
        for name, words in zip(row.names, row.components, strict=False)
    )


def _maker(address: str) -> Callable[..., ControlEvent]:
    def make(*, time: float, source: str, group: str = "*", measures: float = 0.0, **numbers: float) -> ControlEvent:
        value = tuple(float(number) for number in numbers.values())
        return SetParameter(time=time, source=source, address=address, value=value, group=group, measures=measures)

    return make


def parameter_control(row: Parameter) -> Control:
    """Return the control of a parameter: its numbers, the group if each has a value, and how long the fade takes."""
    values = value_arguments(row)
    start: tuple[ArgumentValue, ...] = row.start
    if row.kind == "switch":
        start = (bool(row.start[0]),)
    elif row.kind == "names":
        start = (row.names_of_number(row.start[0]),)
    rest = (*((_GROUP,) if row.per_group else ()), *((_MEASURES,) if row.fades else ()))
    return Control(
        row.address, _maker(row.address), (*values, *rest), row.description, "operator", "continuous",
        row.size, start,
    )  # fmt: skip


def _make_mood(*, time: float, source: str, group: str, name: str, value: float, measures: float) -> ControlEvent:
    address = f"{MOTION_PREFIX}mood_{name.strip().lower()}"
    return SetParameter(time=time, source=source, address=address, value=(value,), group=group, measures=measures)


MOOD_CONTROL: Final = Control(
    "/dance/mood", _make_mood,
    (
        replace(DANCERS, name="group"),
        Argument("name", "name", f"the mood: {', '.join(MOOD_NAMES)}"),
        Argument("value", "float", "from one end to the other", "", -1, 1),
        _MEASURES,
    ),
    "The mood of dancers: any step, recorded or sketched, is danced lighter or stronger, shyer or prouder (T143).",
    "operator",
)  # fmt: skip
"""The moods with one address: the same as `/dance/motion/mood_...`."""

PARAMETER_CONTROLS: Final = (
    *map(parameter_control, (*MOTION_PARAMETERS, *PARAMETERS, *GROUP_PARAMETERS.values())), MOOD_CONTROL,
)  # fmt: skip
"""Controls of all parameters."""
