"""Values of groups, and of selected dancers that differ from those of their group (T026, T104)."""

from collections.abc import Iterator, Mapping
from typing import Any, Final, Generic, TypeVar

import numpy as np

from live.base.arrays import Bool, Int32, Int64

Value = TypeVar("Value")

OWN: Final = -1
"""Key of the dancers' own values among those that can be edited."""


class GroupValues(Generic[Value]):
    """A value of each group, and values that selected dancers have instead."""

    def __init__(self, groups: list[Value]) -> None:
        self.groups = groups
        """Value of each group, by index."""
        self.own: list[tuple[Bool, Value]] = []
        """Dancers (A,) with a value of their own, and the value; each dancer is in one mask at most."""

    def set_group(self, index: int, value: Value, group: Int32) -> None:
        """Set the value of a group and of all its dancers; `group` (A,) of each dancer."""
        self.groups[index] = value
        self._take_away(group == index)

    def set_dancers(self, who: Bool, value: Value) -> None:
        """Set the value of the dancers `who` (A,), whatever their groups have."""
        self._take_away(who)
        self.own.append((who, value))

    def _take_away(self, who: Bool) -> None:
        rest = [(mask & ~who, value) for mask, value in self.own]
        self.own = [(mask, value) for mask, value in rest if mask.any()]

    def parts(self, group: Int32) -> Iterator[tuple[Int64, Value]]:
        """Yield the dancers who share a value, by index, and the value; `group` (A,) of each dancer."""
        which = group
        for place, (mask, _) in enumerate(self.own):
            which = np.where(mask, len(self.groups) + place, which)
        values = [*self.groups, *(value for _, value in self.own)]
        for index, value in enumerate(values):
            members = np.flatnonzero(which == index)
            if len(members):
                yield members, value

    def any(self, value: Value) -> bool:
        """Whether anything differs from this value."""
        return any(one != value for one in self.groups) or any(one != value for _, one in self.own)

    def by_key(self) -> dict[int, Any]:
        """Return the values of the groups, and under `OWN` those of dancers with their indices."""
        own = tuple((tuple(np.flatnonzero(mask).tolist()), value) for mask, value in self.own)
        return {**dict(enumerate(self.groups)), OWN: own}

    def restore(self, values: Mapping[int, Any], count: int) -> None:
        """Restore values of `by_key`; there are `count` dancers."""
        for index, value in values.items():
            if index != OWN:
                self.groups[index] = value
                continue
            self.own = []
            for dancers, own in value:
                who = np.zeros(count, np.bool_)
                who[list(dancers)] = True
                self.own.append((who, own))
