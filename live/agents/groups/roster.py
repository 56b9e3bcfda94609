"""Roster: the dancers, what each of them is, and the groups that have a name (T104)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

PLACE_WORDS = ("left", "right", "front", "back", "centre", "center")
"""Words that mean where a dancer stands at that moment, as the audience sees it, unless a group is called so."""
ALL_WORDS = ("all", "everyone")
"""Words that mean every dancer, unless a group is called so."""


@dataclass(frozen=True, slots=True)
class Roster:
    """The dancers of a show, numbered from 1 for people: what is known of each, and named groups.

    A group is an expression (see `selection`), so it can be divided and re-divided any number of times, and a group
    by place is another one at every moment (T104, Schulz 2011, 4.3.3).
    """

    attributes: tuple[frozenset[str], ...]
    """The words each dancer is described by, in the order of their numbers; length A."""
    groups: Mapping[str, str] = field(default_factory=dict)
    """Name of a group → expression that says who belongs to it."""
    known: frozenset[str] = frozenset()
    """Words that nobody has at present, but that mean something: nobody, then."""

    @staticmethod
    def of(count: int, attributes: Mapping[int, Sequence[str]] | None = None, **groups: str) -> "Roster":
        """`count` dancers; `attributes` maps a dancer's number (from 1) to her words, `groups` names expressions."""
        words = attributes or {}
        return Roster(tuple(frozenset(words.get(number, ())) for number in range(1, count + 1)), groups)

    @property
    def count(self) -> int:
        """Number of dancers A."""
        return len(self.attributes)

    def words(self) -> tuple[str, ...]:
        """All attributes that anybody has, sorted."""
        return tuple(sorted({word for words in self.attributes for word in words}))

    def having(self, word: str) -> Mask:
        """Who has this attribute, shape (A,)."""
        return np.array([word in words for words in self.attributes], np.bool_)
