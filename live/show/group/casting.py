"""Groups and attributes of the dancers, and selection of dancers by expressions (T104)."""

import numpy as np
import numpy.typing as npt

from live.agents.groups.group_expression import depends_on_positions, select_dancers
from live.agents.groups.roster import Roster
from live.base.arrays import Bool, Int32
from live.base.errors import error_context
from live.show.patch.patch import Patch

SOLOIST = "soloist"
"""The attribute of dancers who have the right of way."""
EVERYONE = ("", "*")


class Casting:
    """The groups of A dancers. The patch's reserve comes last and belongs to the first group."""

    def __init__(self, patch: Patch) -> None:
        """Create the casting of a patch; `check` validates its selections."""
        count = patch.dancer_count + patch.reserve
        sizes = [section.dancers for section in patch.group]
        self.group: Int32 = np.zeros(count, np.int32)
        """Group of each dancer, shape (A,): it determines steps and colour."""
        self.group[: sum(sizes)] = np.repeat(np.arange(len(sizes)), sizes)
        self.names = tuple(section.name.casefold() for section in patch.group)
        self.half = (patch.stage.width / 2, patch.stage.depth / 2)
        """Half the stage's width and depth [m], for expressions with places."""
        own: list[frozenset[str]] = []
        for section, size in zip(patch.group, sizes, strict=True):
            words = frozenset(word.casefold() for word in section.attributes)
            own += [words | {SOLOIST} if dancer < section.soloists else words for dancer in range(size)]
        self._attributes = (*own, *[frozenset[str]()] * (count - len(own)))
        """Attributes of each dancer besides the group, A long."""
        self._named = {name.casefold(): words.casefold() for name, words in patch.selections.items()}
        self.roster = self._build_roster()
        """All attributes of each dancer, for selections."""

    def check(self) -> None:
        """Raise a PersonError if a selection of the patch has unknown words, or refers to itself."""
        for name in self._named:
            with error_context(f"selections: {name}", ("selections", name)):
                select_dancers(name, self.roster, np.zeros((len(self.group), 2)), self.half)

    def apply_patch(self, fresh: "Casting") -> None:
        """Apply the group names, attributes and selections of another patch. The dancers' groups stay."""
        self.names, self._attributes, self._named = fresh.names, fresh._attributes, fresh._named
        self.roster = self._build_roster()

    def _build_roster(self) -> Roster:
        words = (frozenset({*own, self.names[g]}) for own, g in zip(self._attributes, self.group.tolist(), strict=True))
        return Roster(tuple(words), self._named, frozenset(self.names))

    @property
    def soloists(self) -> Bool:
        """Whether each dancer has the right of way, shape (A,)."""
        return np.array([SOLOIST in own for own in self._attributes], np.bool_)

    def index_of(self, name: str) -> int | None:
        """Return the index of the group with this name, None if there is none."""
        folded = name.casefold().strip()
        return self.names.index(folded) if folded in self.names else None

    def groups_of(self, words: str) -> list[int] | None:
        """Return the indices of the groups that `words` name as a whole, all for "" and "*"; None for a selection."""
        if words.strip() in EVERYONE:
            return list(range(len(self.names)))
        index = self.index_of(words)
        return None if index is None else [index]

    def select(self, words: str, position: npt.NDArray[np.floating]) -> Bool:
        """Return a mask (A,) of the dancers that `words` select, who are at `position` (A, 2) [m].

        `words` is "" or "*" for all, a group's name, or an expression of groups, attributes, numbers and places on the
        stage. Raises PersonError for words without a meaning.
        """
        if words.strip() in EVERYONE:
            return np.ones(len(self.group), np.bool_)
        index = self.index_of(words)
        if index is not None:
            return np.asarray(self.group == index)
        return select_dancers(words.casefold(), self.roster, position, self.half)

    def possible(self, words: str) -> Bool:
        """Return the dancers that `words` select at one place or another, (A,). PersonError as from `select`."""
        corners = [(x, z) for x in (-0.25, 0.25, -0.75, 0.75) for z in (-0.25, 0.25, -0.75, 0.75)]
        places = (np.multiply(corner, 2.0 * np.array(self.half)) for corner in corners)
        found = [self.select(words, np.tile(place, (len(self.group), 1))) for place in places]
        return np.asarray(np.any(found, axis=0))

    def depends_on_places(self, words: str) -> bool:
        """Whether the selection depends on where the dancers stand; for words that `select` has accepted."""
        if words.strip() in EVERYONE or self.index_of(words) is not None:
            return False
        return depends_on_positions(words.casefold(), self.roster)

    def regroup(self, who: Bool, index: int) -> None:
        """Move the dancers in the mask `who` (A,) to group `index`."""
        self.group[who] = index
        self.roster = self._build_roster()
