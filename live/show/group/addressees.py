"""Addressees: for whom each element is, as bits of a mask per dancer (T104, T105: per subgroup)."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.elements.element_kinds import EVERYBODY
from live.base.errors import PersonError
from live.show.group.casting import EVERYONE, Casting

UInt64 = npt.NDArray[np.uint64]
Places = npt.NDArray[np.floating]

BITS: Final = 64


class Addressees:
    """Gives each wording of a group a bit, and each dancer the bits of the groups she belongs to.

    Words that mean places are answered once, when they are asked; all others follow who is in which group.
    """

    def __init__(self, casting: Casting) -> None:
        self._casting = casting
        self._words: list[str | None] = [None] * BITS
        self._lasting = [False] * BITS
        self.bits: UInt64 = np.zeros(len(casting.group), np.uint64)
        """The groups of each dancer, shape (A,)."""

    def mask(self, words: str, position: Places, used: int) -> int:
        """The mask of an element for the dancers that `words` mean; `used`: bits that elements in force have.

        Raises PersonError for words that mean nobody there is, and when there are too many groups at a time.
        """
        if words.strip() in EVERYONE:
            return EVERYBODY
        return 1 << self.bit(words, position, used)

    def bit(self, words: str, position: Places, used: int) -> int:
        """Number of the bit of these words; raises as `mask` does."""
        folded = words.casefold().strip()
        who = self._casting.select(words, position)
        lasting = not self._casting.means_places(words)
        if lasting and folded in self._words:
            return self._words.index(folded)
        free = next((n for n in range(BITS) if self._words[n] is None or not used >> n & 1), None)
        if free is None:
            raise PersonError(f"elements for more than {BITS} groups at a time", "let some of them end first")
        self._words[free], self._lasting[free] = folded, lasting
        if not lasting:
            self._words[free] = f"{folded}, when it was asked"
        self._write(free, who)
        return free

    def regrouped(self, position: Places) -> None:
        """Answer all words anew that do not mean places."""
        for number, words in enumerate(self._words):
            if words is not None and self._lasting[number]:
                self._write(number, self._casting.select(words, position))

    def _write(self, number: int, who: npt.NDArray[np.bool_]) -> None:
        bit = np.uint64(1 << number)
        self.bits[who] |= bit
        self.bits[~who] &= ~bit
