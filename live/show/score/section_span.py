"""Span of a score entry: its section and measures, whether counted in the section or in the whole score; and the length
of the score."""

from dataclasses import dataclass
from math import inf

from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import SegmentSection


@dataclass(frozen=True, slots=True)
class SectionSpan:
    """Span of an entry within its section."""

    section: int
    """Index of the section; -1 in a score without sections."""
    begin: int
    """First measure within the section, from 0."""
    end: float
    """Measure after the last, at most the section's end; inf if there is none."""
    size: int | None
    """Measures of the section; None if it has no end."""
    first: int
    """First measure of the section in the written score, from 0."""


def span_of(patch: Patch, section: str | None, measure: float, measures: float | None) -> SectionSpan:
    """Return the span of an entry that begins in `measure` (from 1) of `section`, or of the written score if None."""
    if not patch.section:
        return _make_span(-1, int(measure) - 1, measures, patch.loop_measures, 0)
    first = 0
    for index, one in enumerate(patch.section):
        if section is None:
            here = first < measure < first + one.measures + 1
        else:
            here = one.name.casefold() == section.casefold()
        if here:
            begin = int(measure) - 1 - (first if section is None else 0)
            return _make_span(index, begin, measures, one.measures, first)
        first += one.measures
    return _make_span(len(patch.section), int(measure) - 1, measures, None, first)


def _make_span(section: int, begin: int, measures: float | None, size: int | None, first: int) -> SectionSpan:
    end = min(inf if measures is None else begin + measures, inf if size is None else float(size))
    return SectionSpan(section, begin, end, size, first)


def entry_span(patch: Patch, entry: SegmentSection | ElementSection) -> tuple[float, float]:
    """Return the beginning and the end of a segment or an element, in measures of the written score, from 0."""
    span = span_of(patch, entry.section, entry.measure, entry.measures)
    begin = span.first + span.begin + float(entry.measure) % 1.0
    return begin, begin + float(entry.measures)


def score_length(patch: Patch) -> int | None:
    """Return the number of measures of the whole written score; None if it has no end."""
    return sum(section.measures for section in patch.section) if patch.section else patch.loop_measures
