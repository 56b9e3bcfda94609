"""Stays: in which section an entry of the score is, and from where to where, whichever way its measures are counted."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Protocol

from live.show.patch.section_score import ScoreSection


class Sectioned(Protocol):
    """What is looked at of a patch."""

    @property
    def loop_measures(self) -> int | None: ...
    @property
    def section(self) -> Sequence[ScoreSection]: ...


@dataclass(frozen=True, slots=True)
class Stay:
    """Where an entry is."""

    section: int
    """Index of its section; -1 in a score without sections."""
    begin: int
    """Its first measure there, from 0."""
    end: float
    """The measure after its last, at the latest that after the section's; inf if it has none."""
    size: int | None
    """Measures of the section; None if it has no end."""
    first: int
    """The section's first measure in the written score, from 0."""


def stay_of(patch: Sectioned, section: str | None, measure: float, measures: float | None) -> Stay:
    """Where an entry is that begins in `measure` (from 1) of `section`, or of the written score if that is None."""
    if not patch.section:
        return _stay(-1, int(measure) - 1, measures, patch.loop_measures, 0)
    first = 0
    for index, one in enumerate(patch.section):
        if section is None:
            here = first < measure < first + one.measures + 1
        else:
            here = one.name.casefold() == section.casefold()
        if here:
            begin = int(measure) - 1 - (first if section is None else 0)
            return _stay(index, begin, measures, one.measures, first)
        first += one.measures
    return _stay(len(patch.section), int(measure) - 1, measures, None, first)


def _stay(section: int, begin: int, measures: float | None, size: int | None, first: int) -> Stay:
    end = min(inf if measures is None else begin + measures, inf if size is None else float(size))
    return Stay(section, begin, end, size, first)
