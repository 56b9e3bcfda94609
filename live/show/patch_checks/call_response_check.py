"""Checks of call and response in a score: errors if no group calls or answers, and notes on doubtful phrases (T015)."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

from live.show.patch.patch import Patch
from live.show.patch.section_base import InvalidEntry
from live.show.patch.section_score import ImproviseSection
from live.show.score.section_span import SectionSpan, span_of


@dataclass(frozen=True, slots=True)
class _GroupPart:
    """One group in one `[[improvise]]`."""

    index: int
    group: str
    section: ImproviseSection
    span: SectionSpan

    @property
    def caller(self) -> str | None:
        """Name of the group that it answers, casefolded."""
        return None if self.section.answers is None else self.section.answers.casefold()

    @property
    def only_repeats(self) -> bool:
        """Whether it dances nothing of its own: it listens, and answers with the same steps."""
        return self.section.listening is not None and self.section.answer == "same"

    def covers(self, other: "_GroupPart") -> bool:
        """Whether it lasts at least over all measures of the other one."""
        here, there = self.span, other.span
        return here.section == there.section and here.begin <= there.begin and here.end >= there.end


def check_call_response(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error if no group calls, or if an improvisation ends before its first answer."""
    for index, entry in enumerate(patch.improvise):
        if entry.answers is None:
            continue
        stay = span_of(patch, entry.section, entry.measure, entry.measures)
        lasts = stay.end - stay.begin
        if lasts <= entry.phrase:
            words = (
                f"phrase {entry.phrase}: every second phrase is an answer, but it ends after {lasts:g} measures: "
                f"{f'{int(lasts) // 2} at most' if lasts >= 2 else 'at least 2 measures are needed'}"
            )
            yield InvalidEntry(words, "improvise", index, "phrase")
    for circle in _answer_cycles(patch):
        if all(voice.only_repeats for voice in circle):
            names = " and ".join(repr(voice.group) for voice in circle)
            words = (
                f"nobody calls: {names} listen{'s' if len(circle) == 1 else ''} and "
                f"repeat{'s' if len(circle) == 1 else ''} what was danced while listening; leave answers out of one"
                if len(circle) > 1
                else f"nobody calls: every group answers {names}, and so does that group itself; "
                "write an [[improvise]] for each group"
            )
            yield InvalidEntry(words, "improvise", circle[-1].index, "answers")


def call_response_warnings(patch: Patch) -> list[str]:
    """Return notes on calls that overlap, phrases of different length, and a last call without an answer."""
    notes = []
    for circle in _answer_cycles(patch):
        if len(circle) == 1:
            notes.append(f'group {circle[0].group!r} answers itself: `group = "*"` means it, too')
            continue
        names = " and ".join(repr(voice.group) for voice in circle)
        notes.append(
            f"groups {names} answer each other: they call at the same time, and then each repeats the other; leave "
            "answers out of one of them to let them take turns"
        )
    of_group = _by_group(_group_parts(patch))
    for voice in (voice for voices in of_group.values() for voice in voices if voice.caller is not None):
        notes += _phrase_mismatches(voice, of_group.get(voice.caller or "", []))
    return list(dict.fromkeys(notes))


def _phrase_mismatches(voice: _GroupPart, callers: list[_GroupPart]) -> Iterator[str]:
    """Notes on phrases of an answering group that do not fit those of its callers."""
    size = voice.section.phrase
    where = f"improvise {voice.index + 1}"
    for other in callers:
        theirs, here, there = other.section.phrase, voice.span, other.span
        meet = here.section == there.section and here.begin < there.end and there.begin < here.end
        written = "phrase" in other.section.model_fields_set or other.section.motion or other.section.answers
        if meet and written and theirs % size and size % theirs:
            yield (
                f"{where}: {voice.group!r} answers in phrases of {size} measures, and {other.group!r} calls in "
                f"phrases of {theirs}: answers begin in the middle of its phrases; phrase = {theirs} for both"
            )
    lasts = voice.span.end - voice.span.begin
    if isfinite(lasts) and 0 < (left := int(lasts) % (2 * size)) <= size:
        yield (
            f"{where}: it ends after {int(lasts)} measures, and the call of its last {left} has no answer: "
            f"phrases of {size} measures fit into a multiple of {2 * size}"
        )


def _group_parts(patch: Patch) -> list[_GroupPart]:
    voices = []
    for index, entry in enumerate(patch.improvise):
        stay = span_of(patch, entry.section, entry.measure, entry.measures)
        names = [group.name.casefold() for group in patch.group] if entry.group == "*" else [entry.group.casefold()]
        voices += [_GroupPart(index, name, entry, stay) for name in names]
    return voices


def _by_group(voices: list[_GroupPart]) -> dict[str, list[_GroupPart]]:
    found: dict[str, list[_GroupPart]] = {}
    for voice in voices:
        found.setdefault(voice.group, []).append(voice)
    return found


def _answer_cycles(patch: Patch) -> Iterator[list[_GroupPart]]:
    """Cycles of groups over the same measures in which each answers the next, and the last answers the first."""
    of_group = _by_group(_group_parts(patch))
    told: set[frozenset[tuple[int, str]]] = set()
    for voice in (voice for voices in of_group.values() for voice in voices if voice.caller is not None):
        circle = [voice]
        while circle[-1].caller is not None:
            here = circle[-1]
            there = next((one for one in of_group.get(here.caller or "", []) if one.covers(here)), None)
            if there is None or there.section.answers is None:
                break
            if there is circle[0]:
                members = frozenset((one.index, one.group) for one in circle)
                if members not in told:
                    told.add(members)
                    yield circle
                break
            if any(there is one for one in circle):
                break
            circle.append(there)
