"""Casting: which group each dancer dances with, what else she is, and who is meant by a few words (T104)."""

import numpy as np
import numpy.typing as npt

from live.agents.groups.group_expression import needs_places, selection
from live.agents.groups.roster import Roster
from live.base.errors import named
from live.show.patch.patch import Patch

Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

SOLOIST = "soloist"
"""The attribute of those who have the right of way."""
EVERYONE = ("", "*")


class Casting:
    """The groups of A dancers. Those that the patch holds in reserve come last and belong to the first group."""

    def __init__(self, patch: Patch) -> None:
        """Raises PersonError if one of the patch's selections means nobody there is."""
        count = patch.dancer_count + patch.reserve
        sizes = [section.dancers for section in patch.group]
        self.group: Int32 = np.zeros(count, np.int32)
        """Group of each dancer, shape (A,): whose steps she dances and whose colour she wears."""
        self.group[: sum(sizes)] = np.repeat(np.arange(len(sizes)), sizes)
        self.names = tuple(section.name.casefold() for section in patch.group)
        self.half = (patch.stage.width / 2, patch.stage.depth / 2)
        """Half the stage's width and depth [m], for words that name places on it."""
        own: list[frozenset[str]] = []
        for section, size in zip(patch.group, sizes, strict=True):
            words = frozenset(word.casefold() for word in section.attributes)
            own += [words | {SOLOIST} if dancer < section.soloists else words for dancer in range(size)]
        self._own = (*own, *[frozenset[str]()] * (count - len(own)))
        """What each dancer is beside her group, A long."""
        self._named = {name.casefold(): words.casefold() for name, words in patch.selections.items()}
        self.roster = self._made()
        """What each dancer is, for selections."""

    def check(self) -> None:
        """Raise a PersonError if a selection of the patch names nobody there is, or itself."""
        for name in self._named:
            with named(f"selections: {name}", ("selections", name)):
                selection(name, self.roster, np.zeros((len(self.group), 2)), self.half)

    def take_patch(self, fresh: "Casting") -> None:
        """Take over what groups are called and who is what; who dances with which group stays."""
        self.names, self._own, self._named = fresh.names, fresh._own, fresh._named
        self.roster = self._made()

    def _made(self) -> Roster:
        words = (frozenset({*own, self.names[g]}) for own, g in zip(self._own, self.group.tolist(), strict=True))
        return Roster(tuple(words), self._named, frozenset(self.names))

    @property
    def soloists(self) -> Bool:
        """Who has the right of way, shape (A,)."""
        return np.array([SOLOIST in own for own in self._own], np.bool_)

    def index_of(self, name: str) -> int | None:
        """Index of a group of the patch, None if none is called so."""
        folded = name.casefold().strip()
        return self.names.index(folded) if folded in self.names else None

    def select(self, words: str, position: npt.NDArray[np.floating]) -> Bool:
        """Who is meant, shape (A,): "" and "*" are all, a group's name its dancers, or an expression of groups,
        attributes, numbers and places on the stage, where the dancers are at `position` (A, 2) [m].

        Raises PersonError for words that mean nobody.
        """
        if words.strip() in EVERYONE:
            return np.ones(len(self.group), np.bool_)
        index = self.index_of(words)
        if index is not None:
            return np.asarray(self.group == index)
        return selection(words.casefold(), self.roster, position, self.half)

    def means_places(self, words: str) -> bool:
        """Whether who is meant depends on where the dancers stand; words that were selected once already."""
        if words.strip() in EVERYONE or self.index_of(words) is not None:
            return False
        return needs_places(words.casefold(), self.roster)

    def regroup(self, who: Bool, index: int) -> None:
        """The dancers `who` (A,) dance with another group from now on."""
        self.group[who] = index
        self.roster = self._made()
