"""Controls of the parameters, made from their rows (`live.base.parameter`)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, Literal

from live.base.motion_parameters import MOTION_PARAMETERS
from live.base.parameter import Parameter
from live.base.picture_parameters import GROUP_PARAMETERS, PARAMETERS
from live.control.events.event import ControlEvent
from live.control.events.parameters import SetParameter
from live.control.registry.command import DANCERS
from live.control.registry.control import Argument, Control

_MEASURES: Final = Argument("measures", "float", "how long it takes; 0 is at once", "measures", 0, 1024, 0.0)
_GROUP: Final = replace(DANCERS, name="group", default="*")


def value_arguments(row: Parameter) -> tuple[Argument, ...]:
    """Return the arguments for the numbers of a parameter."""
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
    start = tuple(bool(number) for number in row.start) if row.kind == "switch" else row.start
    rest = (*((_GROUP,) if row.per_group else ()), *((_MEASURES,) if row.fades else ()))
    return Control(
        row.address, _maker(row.address), (*values, *rest), row.description, "operator", "continuous",
        row.size, start,
    )  # fmt: skip


PARAMETER_CONTROLS: Final = tuple(map(parameter_control, (*MOTION_PARAMETERS, *PARAMETERS, *GROUP_PARAMETERS.values())))
"""Controls of all parameters."""
