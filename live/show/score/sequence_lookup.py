"""Sequences of the score, indexed by section and measure of a group (T009)."""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

from live.base.errors import PersonError, error_context
from live.graph.search.sequence import parse_sequence
from live.graph.search.sequence_spec import SequenceEntry
from live.show.patch.section_score import SequenceSection
from live.show.score.score import Score
from live.show.score.step_names import check_connected

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph


@dataclass(frozen=True, slots=True)
class ScoreSequence:
    """One sequence of the score for one group."""

    begin: int
    """First measure within its section, from 0."""
    end: int
    """Measure after the last."""
    entries: tuple[SequenceEntry, ...]
    """Steps of one pass, in order."""
    ends: tuple[int, ...]
    """Cumulative measures at the end of each step."""
    index: int
    """Index of the `[[sequence]]` in the patch, from 0."""

    def entry_at(self, measure: int) -> tuple[int, int]:
        """Return the entry index for `measure` of the section, and the measures of that entry already over."""
        into = (measure - self.begin) % self.ends[-1]
        index = bisect_right(self.ends, into)
        return index, into - (self.ends[index - 1] if index else 0)


class SequenceLookup:
    """Sequences of one group with `choose = "sequence"`; those with `choose = "random"` are improvised."""

    def __init__(
        self,
        sections: list[tuple[int, SequenceSection]],
        score: Score,
        graph: "MotionGraph",
        built: dict[int, tuple[int, ScoreSequence]] | None = None,
    ) -> None:
        """`sections` with their patch indices; `built`: sequences already built for other groups, by these indices,
        with their sections.

        Raises PersonError for an unknown step, a step that does not end with its sequence, and for sequences that
        overlap or exceed their section.
        """
        self._by_section: dict[int, list[ScoreSequence]] = {}
        known: dict[tuple[str, ...], tuple[SequenceEntry, ...]] = {}
        built = {} if built is None else built
        for index, section in sections:
            if index in built:
                self._by_section.setdefault(built[index][0], []).append(built[index][1])
                continue
            place = score.place_of(section.section, section.measure)
            if place is None:
                continue
            where = describe_place(section.section, section.measure, "sequence")
            if section.steps not in known:
                with error_context(where, ("sequence", index, "steps")):
                    known[section.steps] = tuple(parse_sequence(", ".join(section.steps), graph.library))
                    check_connected(graph, known[section.steps])
            with error_context(where, ("sequence", index, "measures")):
                sequence = _sequence(known[section.steps], section, place[1], graph, index)
                size = score.playhead.sections[place[0]].measures
                if size is not None and sequence.end > size:
                    before = (
                        section.measure - 1 - place[1]
                    )  # offset of the section if the entry counts measures of the whole score
                    its = f"its section {'ends with' if before else 'has'} {before + size}"
                    raise PersonError(
                        f"it goes on to measure {before + sequence.end}, and {its}", f"measures = {size - place[1]}"
                    )
            built[index] = place[0], sequence
            self._by_section.setdefault(place[0], []).append(sequence)
        for sequences in self._by_section.values():
            sequences.sort(key=lambda sequence: sequence.begin)
            _check_overlaps(sequences, dict(sections))
        self._begins = {index: [one.begin for one in sequences] for index, sequences in self._by_section.items()}

    def __bool__(self) -> bool:
        return bool(self._by_section)

    def spans(self) -> Iterator[tuple[int, float, float, tuple[str | int, ...]]]:
        """Yield section, first measure, measure after the last, and place in the patch of each sequence."""
        for section, sequences in self._by_section.items():
            yield from ((section, one.begin, one.end, ("sequence", one.index)) for one in sequences)

    def at(self, section: int, measure: int) -> ScoreSequence | None:
        """Return the sequence at `measure` (from 0) of a section, None if there is none."""
        sequences = self._by_section.get(section)
        if sequences is None:
            return None
        index = bisect_right(self._begins[section], measure) - 1
        return sequences[index] if index >= 0 and measure < sequences[index].end else None


def describe_place(section: str | None, measure: float, what: str) -> str:
    """Return the position of a score entry in words, for messages."""
    return f"{what} in measure {measure:g}" + ("" if section is None else f" of section {section!r}")


def _sequence(
    entries: tuple[SequenceEntry, ...], section: SequenceSection, begin: int, graph: "MotionGraph", number: int
) -> ScoreSequence:
    ends = tuple(accumulate(entry.measures for entry in entries))
    measures = ends[-1] if section.measures is None else section.measures
    rest = measures % ends[-1]
    if rest and rest not in ends:
        index = bisect_right(ends, rest)
        gap = rest - (ends[index - 1] if index else 0)
        entry = entries[index]
        name = "*" if entry.step is None else graph.library.steps[entry.step]
        raise PersonError(
            f"step {name!r} has {entry.measures} measures, and only {gap} of the {measures} are left for it",
            f"measures = {measures - gap} or {measures - gap + entry.measures}, or other steps",
        )
    return ScoreSequence(begin, begin + measures, entries, ends, number)


def _check_overlaps(sequences: list[ScoreSequence], written: dict[int, SequenceSection]) -> None:
    """Raise PersonError if two sequences of a group overlap; they are sorted by begin."""
    for before, after in pairwise(sequences):
        if after.begin < before.end:
            entry, other = written[after.index], written[before.index]
            where = (
                "" if entry.section == other.section else f" ({describe_place(other.section, other.measure, 'it is')})"
            )
            of = "" if entry.section is None else f" of section {entry.section!r}"
            last = before.end - after.begin + entry.measure - 1  # counted as the entry counts its measures
            raise PersonError(
                f"sequence {after.index + 1} begins in measure {entry.measure}{of}, and sequence {before.index + 1}"
                f"{where} of the same group lasts until the end of measure {last}",
                f"measures = {after.begin - before.begin} for that one"
                if after.begin > before.begin
                else "leave one out",
                ("sequence", after.index, "measure"),
            )
