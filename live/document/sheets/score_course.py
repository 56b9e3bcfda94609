"""Course of a score without anybody at the controls: which measure of which section comes when, and where it waits."""

from dataclasses import dataclass
from math import ceil
from typing import Final

from live.show.patch.patch import Patch
from live.show.score.playhead import END, Playhead
from live.show.score.score import section_timings

FREE_MEASURES: Final = 32
"""Measures of a show whose score has neither entries nor an end."""
MAX_MEASURES: Final = 400
"""Most measures of a course."""


@dataclass(frozen=True, slots=True)
class CourseMeasure:
    """One measure of a course."""

    section: str
    """Name of the section; empty in a score without sections."""
    number: int
    """Its number as it is counted, from 1: within its section, or in the score if that has none."""
    time: int = 1
    """1 when the section is danced for the first time, 2 for the second."""
    begins: bool = False
    """Whether a section begins with it."""
    waits: bool = False
    """Whether the score waits after it."""


@dataclass(frozen=True, slots=True)
class ScoreCourse:
    """The measures of a score in the order in which they are danced. A waiting section is danced once."""

    measures: tuple[CourseMeasure, ...]
    ending: str
    """How it goes on after the last measure, as a sentence."""

    def label(self, measure: int) -> str:
        """Return the number of a measure (from 0), with the section if the score has sections."""
        one = self.measures[measure]
        return f"{one.section} {one.number}".strip()


def course_of(patch: Patch, most: int | None = None) -> ScoreCourse:
    """Return the course of a score, of at most `most` measures: until it ends, or begins something again."""
    limit = min(most or MAX_MEASURES, MAX_MEASURES)
    if not patch.section:
        return _plain_course(patch, limit)
    playhead = Playhead(section_timings(patch))
    found: list[CourseMeasure] = []
    visited: set[int] = set()
    section = END
    while len(found) < limit:
        measure = len(found)
        playhead.begin_measure(measure)
        place = playhead.place(measure)
        if place.section == END:
            return ScoreCourse(tuple(found), "After the last measure the score is over.")
        begins = place.measure == 0
        if begins and playhead.passes == 1:
            if place.section in visited:
                return ScoreCourse(
                    tuple(found),
                    f"After the last measure the score goes on with {patch.section[place.section].name!r}.",
                )
            visited.add(place.section)
        section = place.section
        last = place.measure + 1 == patch.section[section].measures
        waits = last and playhead.waiting
        if waits:
            playhead.advance()
        found.append(CourseMeasure(patch.section[section].name, place.measure + 1, place.turn + 1, begins, waits))
    return ScoreCourse(tuple(found), f"The score goes on; its first {len(found)} measures are on these pages.")


def _plain_course(patch: Patch, limit: int) -> ScoreCourse:
    length, ending = (
        patch.loop_measures,
        "After the last measure the score begins again; everybody goes on from where they are.",
    )
    if length is None:
        ends = [_end(entry) for entry in (*patch.segment, *patch.element, *patch.sequence, *patch.at)]
        length = max([FREE_MEASURES, *ends])
        ending = f"The show has no end; its first {min(length, limit)} measures are on these pages."
    if length > limit:
        length, ending = limit, f"The score goes on; its first {limit} measures are on these pages."
    return ScoreCourse(tuple(CourseMeasure("", number + 1) for number in range(length)), ending)


def _end(entry: object) -> int:
    """Return the measures until the entry is over."""
    first = float(getattr(entry, "measure", 1) or 1)
    return ceil(first - 1.0 + float(getattr(entry, "measures", None) or 1.0))
