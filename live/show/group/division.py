"""Division of the groups into parts: dancers with values of their own for motion and look (T026, T104).

Values stand in rows, one for each part. The first parts are the groups themselves; a selection that gets a value of its
own becomes a part of each group that it reaches into, and a part can be divided again. Rows are few: a part ends when
it has no dancers, or when its row is needed and its values are those of its group.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from live.base.arrays import Bool, Int32
from live.base.errors import PersonError
from live.base.picture_parameters import PART_COUNT

FREE: Final = -1
"""Group of a row that is no part."""


class Division:
    """The parts of one show's groups. Thread: the show's."""

    def __init__(self, group: Int32, group_count: int) -> None:
        """`group` (A,) is shared with the show."""
        self._group, self.group_count = group, group_count
        self.part: Int32 = group.copy()
        """Part of each dancer, shape (A,)."""
        self.group_of: Int32 = np.full(PART_COUNT, FREE, np.int32)
        """Group of each part, or FREE, shape (PART_COUNT,)."""
        self.group_of[:group_count] = np.arange(group_count)

    @property
    def is_divided(self) -> bool:
        """Whether there are parts besides the groups."""
        return bool((self.group_of[self.group_count :] != FREE).any())

    def parts_of(self, groups: list[int]) -> list[int]:
        """Return all parts of these groups."""
        return np.flatnonzero(np.isin(self.group_of, groups)).tolist() if groups else []

    def follow_groups(self) -> None:
        """Let dancers who have changed their group leave their part."""
        moved = self.group_of[self.part] != self._group
        self.part[moved] = self._group[moved]

    def divide(self, who: Bool, copy: Callable[[int, int], None], is_like: Callable[[int, int], bool]) -> list[int]:
        """Return the parts that are exactly the dancers `who` (A,), after dividing others where necessary.

        `copy(old, new)` gives a new part the values of the old one; `is_like(part, other)` compares values. PersonError
        if there would be too many parts; then nothing changes.
        """
        self.follow_groups()
        needed = len(self._divided(who))
        free = np.flatnonzero(self.group_of == FREE)
        if len(free) < needed:
            self._end_parts(is_like)
            needed, free = len(self._divided(who)), np.flatnonzero(self.group_of == FREE)
        if len(free) < needed:
            raise PersonError(
                f"the groups have {PART_COUNT - len(free)} parts with values of their own already",
                "set the value of a whole group",
            )
        for old, new in zip(self._divided(who), free.tolist(), strict=False):
            self.group_of[new] = self.group_of[old]
            copy(old, new)
            self.part[who & (self.part == old)] = new
        parts: list[int] = np.unique(self.part[who]).tolist()
        return parts

    def _divided(self, who: Bool) -> list[int]:
        """Return the parts of which `who` (A,) would take only some dancers, and the groups' own rows, which stay."""
        touched = np.unique(self.part[who]).tolist()
        return [part for part in touched if part < self.group_count or (~who & (self.part == part)).any()]

    def _end_parts(self, is_like: Callable[[int, int], bool]) -> None:
        """End the parts without dancers, and those with the values of their group."""
        for part in np.flatnonzero(self.group_of != FREE).tolist()[self.group_count :]:
            group = int(self.group_of[part])
            if is_like(part, group):
                self.part[self.part == part] = group
            if not (self.part == part).any():
                self.group_of[part] = FREE


def dancer_words(dancers: list[int]) -> str:
    """Return the selection of dancers by their numbers, from 1 and ascending: `1-3 + 7`."""
    words: list[str] = []
    first = last = dancers[0]
    for dancer in (*dancers[1:], 0):
        if dancer == last + 1:
            last = dancer
            continue
        words.append(f"{first}" if first == last else f"{first}-{last}")
        first = last = dancer
    return " + ".join(words)
