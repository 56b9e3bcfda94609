"""History of the steps wanted from each group in the last measures, for limits and for call and response."""

from collections import OrderedDict
from collections.abc import Sequence
from typing import Final

from live.show.patch.section_score import ImproviseSection

MIN_CAPACITY: Final = 128
"""Default number of measures kept per group; long phrases need more."""


def required_capacity(sections: Sequence[ImproviseSection]) -> int:
    """Return the number of measures of history that these sections need."""
    longest = max((section.phrase for section in sections), default=0)
    limits = [section.most for section in sections if section.most < 1000]
    return max(MIN_CAPACITY, 2 * longest + 64, 16 * max(limits, default=0))


class StepHistory:
    """Wanted step per group and measure, with the measures of that step already over."""

    def __init__(self, groups: int, capacity: int = MIN_CAPACITY) -> None:
        """`capacity`: the number of measures kept."""
        self.capacity = capacity
        self._steps: list[OrderedDict[int, tuple[int, int]]] = [OrderedDict() for _ in range(groups)]

    def record(self, group: int, measure: int, step: int, into: int) -> None:
        """Record the step wanted from `group` in `measure`; a later record of the same measure replaces it."""
        said = self._steps[group]
        said[measure] = step, into
        while len(said) > self.capacity:
            said.popitem(last=False)

    def step_at(self, group: int, measure: int) -> tuple[int, int] | None:
        """Return the step wanted from `group` in `measure`; None if it is not recorded."""
        return self._steps[group].get(measure)
