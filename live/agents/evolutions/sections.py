"""Sections: which dancers may stand on which slots, e.g. the soloist on the soloist's (T093, T104)."""

from collections.abc import Sequence, Set

import numpy as np
import numpy.typing as npt

Int32 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]

ANYBODY = 0
"""The section of slots without a mark, and of dancers whom no mark means."""


def sections(words: Sequence[Set[str]], marks: Sequence[str]) -> tuple[Int32, Int32]:
    """Section of each dancer (D,) and of each slot (S,), as numbers; `ANYBODY` where no mark means her.

    `words` are the attributes of each dancer, `marks` one word per slot ("" means anybody). A dancer belongs to the
    first mark, in the order of the slots, that is one of her attributes.
    """
    names = list(dict.fromkeys(mark for mark in marks if mark))
    number = {name: index + 1 for index, name in enumerate(names)}
    dancer = [next((number[name] for name in names if name in own), ANYBODY) for own in words]
    return np.array(dancer, np.int32), np.array([number.get(mark, ANYBODY) for mark in marks], np.int32)


def allowed(dancer: Int32, slot: Int32) -> Mask:
    """Who may stand where, shape (D, S): on slots of one's own section; on unmarked ones too if those are full."""
    own = dancer[:, None] == slot[None, :]
    overflow = np.zeros_like(own)
    for section in np.unique(dancer):
        members = dancer == section
        if section != ANYBODY and members.sum() > (slot == section).sum():
            overflow |= members[:, None] & (slot == ANYBODY)[None, :]
    return np.asarray(own | overflow)
