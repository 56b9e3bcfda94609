"""History of the steps wanted from each group and subgroup in the last measures, for limits and for call and
response."""

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
    """Wanted step per group and measure, with the measures of that step already over.

    Groups have their index, subgroups a larger number of their own.
    """

    def __init__(self, capacity: int = MIN_CAPACITY) -> None:
        """`capacity`: the number of measures kept."""
        self.capacity = capacity
        self._steps: dict[int, OrderedDict[int, tuple[int, int]]] = {}

    def record(self, group: int, measure: int, step: int, into: int) -> None:
        """Record the step wanted from `group` in `measure`; a later record of the same measure replaces it."""
        said = self._steps.setdefault(group, OrderedDict())
        said[measure] = step, into
        while len(said) > self.capacity:
            said.popitem(last=False)

    def step_at(self, group: int, measure: int) -> tuple[int, int] | None:
        """Return the step wanted from `group` in `measure`; None if it is not recorded."""
        said = self._steps.get(group)
        return None if said is None else said.get(measure)

    def copy_steps(self, group: int, other: int) -> None:
        """Give `other` the recorded steps of `group`."""
        if group in self._steps:
            self._steps[other] = self._steps[group].copy()

    def forget(self, group: int) -> None:
        """Forget the steps of a subgroup that has ended."""
        self._steps.pop(group, None)
