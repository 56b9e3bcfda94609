"""Ledger: what each group was asked to dance in the last measures, for limits, and for who answers whom."""

from collections import OrderedDict
from collections.abc import Sequence
from typing import Final

from live.show.patch.section_score import ImproviseSection

REMEMBERED: Final = 128
"""Measures kept of what each group has danced, unless phrases are long."""


def remembered(sections: Sequence[ImproviseSection]) -> int:
    """How many measures of a dance must be remembered for these."""
    longest = max((section.phrase for section in sections), default=0)
    limits = [section.most for section in sections if section.most < 1000]
    return max(REMEMBERED, 2 * longest + 64, 16 * max(limits, default=0))


class Ledger:
    """What each group was asked to dance in the last measures: step, and how many measures of it were over."""

    def __init__(self, groups: int, kept: int = REMEMBERED) -> None:
        """`kept`: how many measures are remembered."""
        self.kept = kept
        self._of: list[OrderedDict[int, tuple[int, int]]] = [OrderedDict() for _ in range(groups)]

    def note(self, group: int, measure: int, step: int, into: int) -> None:
        """`group` is asked to dance this in `measure`; the last word on a measure counts."""
        said = self._of[group]
        said[measure] = step, into
        while len(said) > self.kept:
            said.popitem(last=False)

    def said(self, group: int, measure: int) -> tuple[int, int] | None:
        """What `group` was asked to dance in `measure`; None if nobody remembers."""
        return self._of[group].get(measure)
