"""Commands: frozen dataclasses whose fields are their arguments, declared once.

A declaration makes the control (OSC, OSCQuery, MIDI, keys, web pages, tablet layouts), its line in `live docs osc`, the
event's form in the journal and its tests. The first paragraph of the docstring is the description; a field with an
`Argument` in its annotation is an argument, its default makes it optional.

    @command("/dance/step", "musician")
    class CallStep(ControlEvent):
        \"\"\"Dancers dance this step from the next free measure on.\"\"\"

        name: StepName
        measures: Measures = 4.0
        group: Dancers = "*"
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, fields, replace
from functools import partial
from typing import Annotated, Any, Final, TypeVar, dataclass_transform, get_args, get_type_hints

from live.control.registry.control import Argument, ArgumentValue, Control, Role, parse_points

Class = TypeVar("Class", bound=type)
_CONTROLS: Final = "controls"
"""Class attribute with the controls of a command."""


@dataclass_transform(frozen_default=True, kw_only_default=True)
def command(
    address: str,
    role: Role,
    description: str = "",
    *,
    value: int = 0,
    continuous: bool = False,
    start: tuple[ArgumentValue, ...] = (),
    named: bool = False,
    fixed: Mapping[str, ArgumentValue] | None = None,
    required: tuple[str, ...] = (),
    arguments: Mapping[str, Argument] | None = None,
    edits: str = "",
) -> Callable[[Class], Class]:
    """Declare the class as a command at `address`, for `role` and higher. Several addresses may stand above a class.

    `description`: for this address alone, instead of the docstring; `value`: number of leading arguments that form its
    current value, with the default `start`; `continuous`: of several messages at once only the last counts, as for
    every value; `named`: see `Control`; `fixed`: fields that this address sets, and which are no arguments of it;
    `required`: arguments that are required at this address, though the field has a default; `arguments`: those that
    differ from the class's at this address, by field; `edits`: what undo takes back, a part of
    `UndoHistory` by its name ("set", "scenes", "parameters" …).
    """

    def declare(cls: Any) -> Any:
        made: Any = cls
        if "__dataclass_fields__" not in vars(cls):  # by inheritance every event has them
            made = dataclass(frozen=True, slots=True, kw_only=True)(cls)
        preset, others = dict(fixed or {}), dict(arguments or {})
        found = [one for one in arguments_of(made, others) if one.name not in preset]
        control = Control(
            address,
            partial(made, **preset) if preset else made,
            tuple(replace(one, default=None) if one.name in required else one for one in found),
            description or first_paragraph(made),
            role,
            "continuous" if continuous or value else "event",
            value,
            start,
            named,
        )
        if edits:
            made.edits = edits
        setattr(made, _CONTROLS, (control, *controls_of(made)))
        return made

    return declare


def controls_of(cls: Any) -> tuple[Control, ...]:
    """Return the controls of a command, none for any other class."""
    return tuple(vars(cls).get(_CONTROLS, ()))


def arguments_of(cls: Any, others: Mapping[str, Argument] | None = None) -> tuple[Argument, ...]:
    """Return the fields of a command that are arguments, in their order; `others` replace those of the annotations."""
    hints = get_type_hints(cls, include_extras=True)
    found = []
    for each in fields(cls):
        kind, *marks = get_args(hints[each.name]) or (hints[each.name],)
        for mark in marks:
            if isinstance(mark, Argument):
                mark = (others or {}).get(each.name, mark)
                convert = round if kind is int else float if kind is float and mark.type == "bool" else mark.convert
                default = _default(each) if mark.default is None else mark.default
                found.append(replace(mark, name=each.name, default=default, convert=convert))
    return tuple(found)


def _default(field: Field[Any]) -> ArgumentValue | None:
    return None if field.default is MISSING else field.default


def first_paragraph(cls: type) -> str:
    """Return the first paragraph of a docstring as one line."""
    return " ".join(inspect.cleandoc(cls.__doc__ or "").partition("\n\n")[0].split())


DANCERS: Final = Argument.text(
    "the dancers: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`; * is all", "group"
)

Dancers = Annotated[str, DANCERS]
StepName = Annotated[str, Argument.label("the step's name in the show's library", "step")]
X = Annotated[
    float, Argument.number("to the right as seen by the audience, from the centre of the stage", -100, 100, "m")
]
Z = Annotated[float, Argument.number("towards the audience, from the centre of the stage", -100, 100, "m")]
X2 = Annotated[float, Argument.number("x of the second point", -100, 100, "m")]
Z2 = Annotated[float, Argument.number("z of the second point", -100, 100, "m")]
Strength = Annotated[float, Argument.number("how strongly it acts; 1 is the default strength", 0, 10)]
Measures = Annotated[float, Argument.number("how long it acts", 0.25, 1024, "measures")]
FadeMeasures = Annotated[float, Argument.number("how long it takes; 0 is at once", 0, 1024, "measures")]
OwnFadeMeasures = Annotated[
    float, Argument.number("how long it takes; 0 is at once, -1: its own duration", -1, 1024, "measures")
]
Next = Annotated[bool, Argument.switch("1: from the next measure line on, 0: now")]
MAX_POINTS_LENGTH: Final = 15_000
"""Maximum length of a drawn line [characters], within one OSC packet: 512 points with micrometres fit."""
Points = Annotated[
    tuple[tuple[float, float], ...],
    replace(
        Argument.text("x z of each point in order, as in `-3 0, 0 -2, 3 0`", longest=MAX_POINTS_LENGTH),
        convert=parse_points, form="x z of each in metres, as in -3 0, 0 -2.5, 3 0",
    ),
]  # fmt: skip
