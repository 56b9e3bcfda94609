"""Lint for the music of a show: what of the score does not fit its measures (T007; Schulz 2011, 5.2).

A musician may replace the music: the score counts measures, so sections keep theirs, and what no longer fits is named
at its place.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Final

from live.clock.measure_map import MeasureMap
from live.show.patch.patch import Patch

ENTRIES: Final = ("segment", "sequence", "improvise", "element", "regroup", "at", "signal", "curve")
"""Lists whose entries lie in measures."""
MAX_WARNINGS: Final = 6
"""Maximum number of warnings in words."""


@dataclass(frozen=True, slots=True)
class MusicNote:
    """Something that does not fit the music."""

    what: str
    key_path: tuple[str | int, ...]
    """Its place in the patch."""
    measure: int | None = None
    """The measure of the music, from 1."""
    remedy: str = ""


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Measures of the music to which a section, or a whole score without sections, is danced."""

    section: int
    """Index of the section; -1: the whole score."""
    first: int
    """First measure, from 0."""
    size: int | None
    """Measures; None: without end."""
    written: int
    """First measure in the written score, from 0."""


def music_notes(patch: Patch) -> list[MusicNote]:
    """Return what of a patch does not fit the measure lines of its music, in the order of measures."""
    measures = patch.music.measures
    if measures is None:
        return []
    stretches, has_end = _stretches(patch)
    notes = [
        *_metre_notes(patch, measures),
        *_end_notes(patch, measures, stretches, has_end=has_end),
        *_entry_notes(patch, measures, stretches),
        *_phrase_notes(patch, measures, stretches),
    ]
    return sorted(notes, key=lambda note: note.measure or 0)


def music_warnings(patch: Patch) -> list[str]:
    """Return the first notes in words."""
    notes = [note.what + (f": {note.remedy}" if note.remedy else "") for note in music_notes(patch)]
    more = len(notes) - MAX_WARNINGS
    return notes if more <= 0 else [*notes[:MAX_WARNINGS], f"... and {more} more that do not fit the music"]


def _stretches(patch: Patch) -> tuple[list[_Stretch], bool]:
    """Return where each section is danced, as far as its order is known before, and whether that is the whole score."""
    if not patch.section:
        return [_Stretch(-1, 0, patch.loop_measures, 0)], False
    found: list[_Stretch] = []
    first = written = 0
    for index, section in enumerate(patch.section):
        if section.wait or not section.repeat:
            return [*found, _Stretch(index, first, section.measures, written)], False
        for _ in range(section.repeat):
            found.append(_Stretch(index, first, section.measures, written))
            first += section.measures
        if section.then is not None:
            return found, False
        written += section.measures
    return found, True


def _metre_notes(patch: Patch, measures: MeasureMap) -> Iterator[MusicNote]:
    beats = patch.clock.beats_per_measure
    if patch.clock.follow_metre:
        return
    for wanted, group in groupby(enumerate(measures.lines), key=lambda one: one[1].beats):
        rows = list(group)
        if wanted != beats:
            first, last = rows[0][0] + 1, rows[-1][0] + 1
            where = f"measure {first} has" if first == last else f"measures {first} to {last} have"
            what = f"{where} {wanted} beats, and the show dances measures of {beats}"
            remedy = "follow_metre = true in [clock] follows them"
            yield MusicNote(what, ("music", "line", rows[0][0]), first, remedy)


def _end_notes(patch: Patch, measures: MeasureMap, stretches: list[_Stretch], *, has_end: bool) -> Iterator[MusicNote]:
    count = len(measures.lines)
    for one in stretches:
        if one.section >= 0 and one.size is not None and one.first + one.size > count:
            name, last = patch.section[one.section].name, one.first + one.size
            yield MusicNote(
                f"section {name!r} lasts from measure {one.first + 1} to {last} of the music, which has {count}",
                ("section", one.section), max(count + 1, one.first + 1),
            )  # fmt: skip
    end = max(one.first + (one.size or 0) for one in stretches)
    if has_end and end < count:
        yield MusicNote(
            f"the score ends with measure {end}, and the music has {count}",
            ("section", len(patch.section) - 1),
            end + 1,
        )


def _entry_notes(patch: Patch, measures: MeasureMap, stretches: list[_Stretch]) -> Iterator[MusicNote]:
    """Yield the entries that begin after the music, or on a beat that their measure does not have."""
    count = len(measures.lines)
    for kind in ENTRIES:
        for index, entry in enumerate(getattr(patch, kind)):
            if entry.measure is None:
                continue
            starts = [start for one in stretches if (start := _begin(patch, entry, one)) is not None]
            words = f"{kind} {index + 1}" + (f" of section {entry.section!r}" if entry.section is not None else "")
            if starts and starts[0] >= count:
                what = f"{words} begins in measure {starts[0] + 1}, after the music's last measure {count}"
                yield MusicNote(what, (kind, index), starts[0] + 1, "an earlier measure, or longer music")
                continue
            beat = getattr(entry, "beat", 1.0)
            for start in starts:
                if start < count and patch.clock.follow_metre and beat >= measures.lines[start].beats + 1.0:
                    what = (
                        f"{words} is at beat {beat:g} of measure {start + 1}, which has {measures.lines[start].beats}"
                    )
                    yield MusicNote(what, (kind, index, "beat"), start + 1)
                    break


def _begin(patch: Patch, entry: Any, stretch: _Stretch) -> int | None:
    """Return the measure of the music (from 0) in which an entry begins in a stretch; None if it is not in it."""
    measure = int(entry.measure) - 1
    if entry.section is None:
        measure -= stretch.written
    elif patch.section[stretch.section].name.casefold().strip() != entry.section.casefold().strip():
        return None
    inside = measure >= 0 and (stretch.size is None or measure < stretch.size)
    return stretch.first + measure if inside else None


def _phrase_notes(patch: Patch, measures: MeasureMap, stretches: list[_Stretch]) -> Iterator[MusicNote]:
    """Yield the sections that begin within a phrase."""
    offset = measures.lines[0].measure - 1
    begins = [phrase.measure - offset for phrase in measures.phrases]
    for one in stretches:
        before = [k for k, begin in enumerate(begins) if begin <= one.first + 1]
        if one.section < 0 or not before or one.first >= len(measures.lines):
            continue
        phrase, begin = measures.phrases[before[-1]], begins[before[-1]]
        if begin != one.first + 1:
            name = f"the phrase {phrase.name!r}" if phrase.name else "the phrase"
            what = f"section {patch.section[one.section].name!r} begins in measure {one.first + 1}, within {name}"
            yield MusicNote(f"{what} that begins in measure {begin}", ("section", one.section), one.first + 1)
