"""History of the steps wanted from each group in the last measures, for limits and for call and response."""

from collections import OrderedDict
from collections.abc import Sequence
from typing import Final

from live.show.patch.section_score import ImproviseSection

REMEMBERED: Final = 128
"""Default number of measures kept per group; long phrases need more."""


def remembered(sections: Sequence[ImproviseSection]) -> int:
    """Return the number of measures of history that these sections need."""
    longest = max((section.phrase for section in sections), default=0)
    limits = [section.most for section in sections if section.most < 1000]
    return max(REMEMBERED, 2 * longest + 64, 16 * max(limits, default=0))


class Ledger:
    """Wanted step per group and measure, with the measures of that step already over."""

    def __init__(self, groups: int, kept: int = REMEMBERED) -> None:
        """`kept`: the number of measures kept."""
        self.kept = kept
        self._of: list[OrderedDict[int, tuple[int, int]]] = [OrderedDict() for _ in range(groups)]

    def note(self, group: int, measure: int, step: int, into: int) -> None:
        """Record the step wanted from `group` in `measure`; a later record of the same measure replaces it."""
        said = self._of[group]
        said[measure] = step, into
        while len(said) > self.kept:
            said.popitem(last=False)

    def said(self, group: int, measure: int) -> tuple[int, int] | None:
        """Return the step wanted from `group` in `measure`; None if it is not recorded."""
        return self._of[group].get(measure)
