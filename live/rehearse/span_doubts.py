"""Doubts about where entries of a score end: segments and elements that go on after their section."""

from collections.abc import Iterator
from typing import Any, Final

from live.show.patch.patch import Patch
from live.show.score.section_span import Stay, stay_of

TOLD: Final = 6
"""Doubts of this kind at most."""


def span_doubts(patch: Patch) -> list[str]:
    """Segments and elements that are longer than what is left of their section when they begin.

    They go on into what comes then. One that is written in measures of the whole score means that, where the next
    section follows as it is written.
    """
    notes = [*_longer(patch, "segment"), *_longer(patch, "element")]
    more = len(notes) - TOLD
    return notes if more <= 0 else [*notes[:TOLD], f"... and {more} more that are longer than their sections"]


def _longer(patch: Patch, kind: str) -> Iterator[str]:
    for index, entry in enumerate(getattr(patch, kind)):
        stay = stay_of(patch, entry.section, entry.measure, entry.measures)
        if stay.size is None or stay.begin + int(entry.measures) <= stay.size or _meant(patch, entry, stay):
            continue
        before = 0 if entry.section is not None else stay.first
        end = f"section {patch.section[stay.section].name!r}" if patch.section else "the score"
        default = "" if "measures" in entry.model_fields_set else " (measures is left out)"
        yield (
            f"{kind} {index + 1} begins in measure {entry.measure:g}"
            + ("" if entry.section is None else f" of {entry.section!r}")
            + f" and lasts {entry.measures:g} measures{default}, but {end} ends with measure {before + stay.size}: "
            f"it goes on into what comes then; measures = {stay.size - stay.begin} ends it there"
        )


def _meant(patch: Patch, entry: Any, stay: Stay) -> bool:
    """Whether it is written over sections that follow one another as they are written."""
    if entry.section is not None or not patch.section:
        return False
    last, measure = stay.section, stay.begin + int(entry.measures)
    while last < len(patch.section):
        section = patch.section[last]
        measure -= section.measures
        if measure <= 0:
            return True
        if section.repeat != 1 or section.wait or section.then is not None:
            return False
        last += 1
    return False
