"""Table of all parameters of a show, by the address of the control that sets them.

There are two families of rows: the picture's (`live.base.picture_parameters`), and the motion of each group's dancers
(`live.base.motion_parameters`). All values form one row of numbers: the picture's, then the motion of each part
(`live.show.group.division`), of which the groups are the first.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base import picture_parameters
from live.base.errors import PersonError
from live.base.motion_parameters import MOTION_PARAMETERS, MOTION_SIZE
from live.base.parameter import Parameter
from live.control.registry.parameter_controls import value_arguments
from live.control.registry.rejections import Reason

VIEW: Final = "/dance/camera"
LOOK: Final = "/dance/look"
WORLD: Final = "/dance/world"
"""In a scene these three hold the name of a view, look or world instead of a value."""
NAMED: Final = {VIEW: "view", LOOK: "look", WORLD: "world"}
"""What is named at each of these addresses."""


@dataclass(frozen=True, slots=True)
class Slot:
    """The places of a parameter in the row, for the whole stage (part -1), a group or a part of one."""

    parameter: Parameter
    part: int
    first: int

    @property
    def numbers(self) -> range:
        """Places in the row."""
        return range(self.first, self.first + self.parameter.size)


ROWS: Final = {row.address: row for row in (
    *picture_parameters.PARAMETERS, *picture_parameters.GROUP_PARAMETERS.values(), *MOTION_PARAMETERS,
)}  # fmt: skip
"""All parameters by address."""


NAME_CHOICES: Final = {
    row.address.rpartition("/")[2]: tuple(row.choices) for row in ROWS.values() if row.kind == "names"
}
"""The names that each parameter of names can have, by the last word of its address: costume, shoes, hair."""


def split_key(key: str) -> tuple[str, str]:
    """Return address and group of a key such as `/dance/motion/larger ember`; the group is "*" if there is none."""
    address, _, group = key.strip().partition(" ")
    return address, group.strip() or "*"


def check_setting(key: str, value: object) -> None:
    """Raise PersonError if `key` is no parameter, or `value` is invalid for it; group names are not checked."""
    address, group = split_key(key)
    if address in NAMED:
        if not isinstance(value, str) or group != "*":
            raise PersonError(f"{key!r} = {value!r}", f"the name of a {NAMED[address]} expected")
        return
    parse_value(address, value)
    if group != "*" and address in picture_parameters.BY_ADDRESS:
        raise PersonError(f"{key!r}: light and camera belong to no group", f"write {address!r}")


def parse_value(address: str, value: object) -> tuple[float, ...]:
    """Return the value of the parameter at `address` as numbers; PersonError states the allowed values."""
    row = ROWS.get(address)
    if row is None:
        raise PersonError(f"{address!r} has no value that can be set", f"there are: {', '.join(ROWS)}")
    if row.kind == "names":
        return (_number_of_names(row, value),)
    if isinstance(value, str) and value.casefold() in row.choices:
        value = row.choices[value.casefold()]
    parts: list[Any] = list(value) if isinstance(value, list | tuple) else [value]
    arguments = value_arguments(row)
    checked = [argument.check(part) for argument, part in zip(arguments, parts, strict=False)]
    if len(parts) != row.size or any(isinstance(each, Reason) for each in checked):
        many = "" if row.size == 1 else f"{row.size} numbers, each "
        expected = arguments[0].expected.removeprefix(f"{row.names[0]} ")
        raise PersonError(f"{address!r} = {value!r}", f"expected {many}{expected}")
    return tuple(float(part) for part in parts)


def _number_of_names(row: Parameter, value: object) -> float:
    """Return the number of names in a patch, a text or a list of texts, or in an event, which has the number."""
    words = value if isinstance(value, list | tuple) else (value,)
    number = words[0] if len(words) == 1 else None
    if isinstance(number, int | float) and number in range(int(row.low), int(row.high) + 1):
        return float(number)
    try:
        return row.number_of_names("+".join(map(str, words)))
    except ValueError as error:
        expected = 'expected one name, or several: ["a", "b"]'
        raise PersonError(f"{row.address!r} = {value!r}: {error}", expected) from None


class ParameterTable:
    """The parameters of a show with the given groups."""

    def __init__(self, groups: Sequence[str]) -> None:
        self._groups = tuple(name.casefold() for name in groups)
        self._by_address: dict[str, list[Slot]] = {}
        for row in picture_parameters.PARAMETERS:
            self._by_address[row.address] = [Slot(row, -1, row.first)]
        for address in (*picture_parameters.GROUP_PARAMETERS, *(row.address for row in MOTION_PARAMETERS)):
            self._by_address[address] = [self.slot(address, group) for group in range(len(groups))]
        self.size = picture_parameters.ROW_SIZE + picture_parameters.PART_COUNT * MOTION_SIZE
        """Numbers in the row."""
        self.switches = _SWITCHES
        """Places of numbers that cannot fade."""
        self.part_of = _PART_OF
        """Part of each number, -1 for those of the whole stage, shape (P,)."""

    def apply_patch(self, fresh: "ParameterTable") -> None:
        """Adopt the group names of an edited patch."""
        self._groups = fresh._groups

    @staticmethod
    def slot(address: str, part: int) -> Slot:
        """Return the parameter of one part at an address; for one of the whole stage `part` does not count."""
        row = ROWS[address]
        if not row.per_group:
            return Slot(row, -1, row.first)
        if address in picture_parameters.GROUP_PARAMETERS:
            return Slot(row, part, picture_parameters.group_parameter(address, part).first)
        return Slot(row, part, picture_parameters.ROW_SIZE + row.first + part * MOTION_SIZE)

    @staticmethod
    def part_places(part: int) -> npt.NDArray[np.intp]:
        """Return the places of all numbers of a part, in the same order for every part."""
        colours, styles = picture_parameters.COLOURS_START, picture_parameters.STYLES_START
        size, first = picture_parameters.STYLE_SIZE, picture_parameters.ROW_SIZE
        starts = (colours + 3 * part, 3), (styles + size * part, size), (first + MOTION_SIZE * part, MOTION_SIZE)
        return np.concatenate([np.arange(start, start + length) for start, length in starts])

    def find(self, address: str, group: str = "*") -> list[Slot]:
        """Return the parameters at an address, of one group or (`*`) of all; raises PersonError for an unknown
        group."""
        found = self._by_address[address]
        if group.strip() in ("", "*"):
            return found
        index = self.group_index(group)
        return [one for one in found if one.part == index]

    def slots(self) -> Iterator[tuple[str, list[Slot]]]:
        """Yield every address with its parameters: one for the stage, or one for each group."""
        yield from self._by_address.items()

    @property
    def group_names(self) -> tuple[str, ...]:
        """Names of the groups, by index."""
        return self._groups

    @property
    def groups(self) -> range:
        """Indices of all groups."""
        return range(len(self._groups))

    def has_group(self, group: str) -> bool:
        """Whether a group has this name."""
        return group.strip().casefold() in self._groups

    def group_index(self, name: str) -> int:
        """Return the index of a group; raises PersonError with the known names."""
        folded = name.strip().casefold()
        if folded not in self._groups:
            raise PersonError(f"no group is called {name!r}", f"there are: {', '.join(self._groups)}")
        return self._groups.index(folded)


def _row_of_parts() -> npt.NDArray[np.int32]:
    row = np.full(picture_parameters.ROW_SIZE + picture_parameters.PART_COUNT * MOTION_SIZE, -1, np.int32)
    for part in range(picture_parameters.PART_COUNT):
        row[ParameterTable.part_places(part)] = part
    return row


_PART_OF: Final = _row_of_parts()
_SWITCHES: Final = frozenset(
    ParameterTable.slot(address, part).first
    for address, row in ROWS.items()
    if not row.fades
    for part in range(picture_parameters.PART_COUNT if row.per_group else 1)
)
