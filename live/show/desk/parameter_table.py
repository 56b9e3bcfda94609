"""Table of all parameters of a show, by the address of the control that sets them.

There are two families: the picture's (`live.base.picture_parameters`), and the variation of each group's dancers
(`live.show.dancers.variation`). All values form one row of numbers: the picture's, then those of each group.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

from live.base import picture_parameters
from live.base.errors import PersonError
from live.control.registry.control import Argument
from live.control.registry.motion_controls import MOTION_PARAMETERS
from live.control.registry.rejections import Reason

VIEW: Final = "/dance/camera"
LOOK: Final = "/dance/look"
"""In a scene these two hold the name of a view or look instead of a value."""
_SWITCHES: Final = ("mirror",)
"""Fields with only a few valid values: they do not fade."""
FIELDS: Final = tuple(field for field, _ in MOTION_PARAMETERS.values())
"""Fields of Variety, in the order of the row."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of the whole stage (group -1) or of a group, with its places in the row."""

    address: str
    group: int
    first: int
    size: int
    switch: bool = False
    """Whether it cannot fade: it takes its new value when the fade begins."""

    @property
    def numbers(self) -> range:
        """Places in the row."""
        return range(self.first, self.first + self.size)


def addresses() -> list[str]:
    """Return all addresses that have a value."""
    return [
        *(known.address for known in picture_parameters.PARAMETERS),
        *picture_parameters.GROUP_PARAMETERS,
        *MOTION_PARAMETERS,
    ]


def split_key(key: str) -> tuple[str, str]:
    """Return address and group of a key such as `/dance/motion/larger ember`; the group is "*" if there is none."""
    address, _, group = key.strip().partition(" ")
    return address, group.strip() or "*"


def check_setting(key: str, value: object) -> None:
    """Raise PersonError if `key` is no parameter, or `value` is invalid for it; group names are not checked."""
    address, group = split_key(key)
    if address in (VIEW, LOOK):
        if not isinstance(value, str) or group != "*":
            raise PersonError(f"{key!r} = {value!r}", f"the name of a {'view' if address == VIEW else 'look'} expected")
        return
    parse_value(address, value)
    if group != "*" and address in picture_parameters.BY_ADDRESS:
        raise PersonError(f"{key!r}: light and camera belong to no group", f"write {address!r}")


@cache
def _argument(unit: str, low: float, high: float) -> Argument:
    """Return the argument that checks a number of the picture, one per range."""
    return Argument("value", "float", "", unit, low, high)


def parse_value(address: str, value: object) -> tuple[float, ...]:
    """Return the value of the parameter at `address` as numbers; PersonError states the allowed values."""
    if address in MOTION_PARAMETERS:
        argument = MOTION_PARAMETERS[address][1]
        checked = argument.check(value)
        if isinstance(checked, Reason):
            raise PersonError(f"{address!r} = {value!r}: {checked}", f"expected {argument.expected}")
        return (float(checked),)
    known = picture_parameters.GROUP_PARAMETERS.get(address) or picture_parameters.BY_ADDRESS.get(address)
    if known is None:
        raise PersonError(f"{address!r} has no value that can be set", f"there are: {', '.join(addresses())}")
    parts: list[Any] = list(value) if isinstance(value, list | tuple) else [value]
    argument = _argument(known.unit, known.low, known.high)
    if len(parts) != known.size or any(isinstance(argument.check(part), Reason) for part in parts):
        many = "" if known.size == 1 else f"{known.size} numbers, each "
        raise PersonError(f"{address!r} = {value!r}", f"expected {many}{argument.expected.removeprefix('value ')}")
    return tuple(float(part) for part in parts)


class ParameterTable:
    """The parameters of a show with the given groups."""

    def __init__(self, groups: Sequence[str]) -> None:
        self._groups = tuple(name.casefold() for name in groups)
        self._by_address: dict[str, list[Parameter]] = {}
        for known in picture_parameters.PARAMETERS:
            self._by_address[known.address] = [Parameter(known.address, -1, known.first, known.size)]
        for address, known in picture_parameters.GROUP_PARAMETERS.items():
            self._by_address[address] = [
                Parameter(address, group, picture_parameters.group_parameter(address, group).first, known.size)
                for group in range(len(groups))
            ]
        for address, (field, argument) in MOTION_PARAMETERS.items():
            switch = argument.type == "bool" or field in _SWITCHES
            place = picture_parameters.ROW_SIZE + FIELDS.index(field)
            self._by_address[address] = [
                Parameter(address, group, place + group * len(FIELDS), 1, switch) for group in range(len(groups))
            ]
        self.size = picture_parameters.ROW_SIZE + len(groups) * len(FIELDS)
        """Numbers in the row."""
        self.switches = frozenset(one.first for found in self._by_address.values() for one in found if one.switch)
        """Places of numbers that cannot fade."""

    def apply_patch(self, fresh: "ParameterTable") -> None:
        """Adopt the group names of an edited patch."""
        self._groups = fresh._groups

    def find(self, address: str, group: str = "*") -> list[Parameter]:
        """Return the parameters at an address, of one group or (`*`) of all; raises PersonError for an unknown
        group."""
        found = self._by_address[address]
        if group.strip() in ("", "*"):
            return found
        index = self.group_index(group)
        return [one for one in found if one.group == index]

    def places(self, address: str, group: str = "*") -> list[int]:
        """Return the places of these parameters in the row; empty for an unknown parameter or group."""
        found = self._by_address.get(address, ())
        if group.strip() not in ("", "*"):
            index = self.group_index(group) if self.has_group(group) else -2
            found = [one for one in found if one.group == index]
        return [place for one in found for place in one.numbers]

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
