"""Detection of score entries that claim a dancer twice at a time, and of calls with unknown names, before it runs."""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from live.base.errors import PersonError, error_context
from live.control.events.groups import DefineFormation
from live.control.registry.registry import FIRST_NAMES, REGISTRY
from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence import parse_sequence
from live.show.group.casting import EVERYONE, Casting
from live.show.patch.patch import Patch
from live.show.patch.section_score import RegroupSection, SegmentSection
from live.show.patch_checks.score_checks import CallEntry, calls_of
from live.show.score.improviser import EntrySpan
from live.show.score.score import Score
from live.show.score.step_names import UnknownStep, check_connected, find_step


class DancerSelections:
    """Resolves the dancer selections of a score to bit sets, a bit for each dancer; 0 if they depend on positions."""

    def __init__(self, patch: Patch, casting: Casting) -> None:
        self._casting = casting
        self._groups = {section.name.casefold(): 1 << index for index, section in enumerate(patch.group)}
        self._groups_change = bool(patch.regroup)
        self._known: dict[str, int] = {}
        self._dummy_positions = np.zeros((len(casting.group), 2))

    def bits(self, words: str) -> int:
        """Return the dancers that `words` select at any position; PersonError if they select none."""
        folded = words.casefold().strip()
        if folded not in self._known:
            self._known[folded] = self._resolve(words, folded)
        return self._known[folded]

    def _resolve(self, words: str, folded: str) -> int:
        who = self._casting.select(words, self._dummy_positions)
        if self._groups_change:  # dancers change groups, so that other selections depend on the time
            return (1 << len(self._groups)) - 1 if folded in EVERYONE else self._groups.get(folded, 0)
        if self._casting.depends_on_places(words):
            return 0
        return int.from_bytes(np.packbits(who, bitorder="little").tobytes(), "little")


def check_segments(segments: Sequence[SegmentSection], score: Score, claims: DancerSelections) -> None:
    """Raise PersonError for two segments that claim a dancer at the same time; selections by position are skipped."""
    running: dict[int, list[tuple[int, int, int, int]]] = {}
    for index, segment in enumerate(segments):
        place = score.place_of(segment.section, segment.measure)
        if place is None:
            continue
        bits = claims.bits(segment.group)
        running.setdefault(place[0], []).append((place[1], place[1] + segment.measures, index, bits))
    for rows in running.values():
        rows.sort()
        active: list[tuple[int, int, int, int]] = []
        for row in rows:
            active = [other for other in active if other[1] > row[0]]
            clash = next((other for other in active if other[3] & row[3]), None)
            if clash is not None:
                mine, other = segments[row[2]], segments[clash[2]]
                of = "" if mine.section is None else f" of section {mine.section!r}"
                until = clash[1] - row[0] + mine.measure - 1  # counted in the measures of this segment
                where = "" if mine.section == other.section else f" ({place_text(other.section, other.measure)})"
                raise PersonError(
                    f"segment {row[2] + 1} begins in measure {mine.measure}{of} with dancers whom segment "
                    f"{clash[2] + 1}{where} has until the end of measure {until}",
                    f"measures = {row[0] - clash[0]} for the other one, or another group"
                    if row[0] > clash[0]
                    else "leave one of them out, or give it another group",
                    ("segment", row[2], "measure"),
                )
            active.append(row)


def check_subgroups(entries: Sequence[tuple[str, EntrySpan]], claims: DancerSelections) -> None:
    """Raise PersonError for unknown words of a selection with steps, and where two selections give steps to a dancer at
    the same time and neither is part of the other. Selections by position are skipped: the smaller one counts.

    `entries`: words, and span of each entry.
    """
    running: dict[int, list[tuple[float, float, int, str, tuple[str | int, ...]]]] = {}
    for words, (section, begin, end, where) in entries:
        with error_context(f"{where[0]} of {words!r}", (*where, "group")):
            running.setdefault(section, []).append((begin, end, claims.bits(words), words, where))
    for rows in running.values():
        rows.sort(key=lambda row: (row[0], row[1], str(row[4])))
        active: list[tuple[float, float, int, str, tuple[str | int, ...]]] = []
        for begin, end, bits, words, where in rows:
            active = [other for other in active if other[1] > begin]
            for _, other_end, other_bits, other_words, other in active:
                shared = bits & other_bits
                part = bits != other_bits and shared in (bits, other_bits)
                if shared and not part and words != other_words:
                    raise PersonError(
                        f"{where[0]} {int(where[1]) + 1} gives {words!r} steps, and {other[0]} {int(other[1]) + 1} "
                        f"gives {other_words!r} others until the end of measure {other_end:g}; dancer "
                        f"{(shared & -shared).bit_length()} is in both, and neither is part of the other",
                        f"{words} - ({other_words})",
                        (*where, "group"),
                    )
            active.append((begin, end, bits, words, where))


def place_text(section: str | None, measure: float) -> str:
    """Return the place of an entry, in words."""
    return f"measure {measure:g}" + (" of the whole score" if section is None else f" of section {section!r}")


def check_regroups(regroups: Iterable[RegroupSection], score: Score, casting: Casting) -> None:
    """Raise PersonError if two groups claim a dancer in the same measure."""
    claimed: dict[tuple[int, int], list[tuple[np.ndarray, str]]] = {}
    somewhere = np.zeros((len(casting.group), 2))
    for index, section in enumerate(regroups):
        place = score.place_of(section.section, section.measure)
        if place is None or casting.depends_on_places(section.dancers):
            continue
        who = casting.select(section.dancers, somewhere)
        for other, group in claimed.setdefault(place, []):
            twice = np.flatnonzero(other & who)
            if len(twice) and group != section.group.casefold():
                raise PersonError(
                    f"groups {group!r} and {section.group!r} both claim dancer {int(twice[0]) + 1} in measure "
                    f"{section.measure}",
                    "leave the dancer out of one of them",
                    ("regroup", index, "dancers"),
                )
        claimed[place].append((who, section.group.casefold()))


def check_step_calls(patch: Patch, graph: MotionGraph) -> None:
    """Raise PersonError for an unknown step in a call of the score, the music, a cue or a MIDI mapping."""
    for called in step_calls(patch):
        check_step_call(graph, called)


def check_step_call(graph: MotionGraph, called: CallEntry) -> None:
    """Raise PersonError if a call of `step_calls` names a step that is unknown, or connects to no other."""
    call, values, place = called
    with error_context(f"call {call}", place):
        if REGISTRY[call].arguments[0].name == "steps":
            check_connected(graph, parse_sequence(str(values[0]), graph.library))
            return
        try:
            find_step(graph, str(values[0]))
        except UnknownStep as error:
            raise PersonError(str(error)) from None


def step_calls(patch: Patch) -> Iterator[CallEntry]:
    """Yield the calls of a patch that name steps; see `calls_of`."""
    for called in calls_of(patch):
        if FIRST_NAMES.get(called[0]) == "step":
            yield called
    for index, line in enumerate(patch.midi.map):
        if FIRST_NAMES.get(line.control) == "step":
            name = line.values.get(REGISTRY[line.control].arguments[0].name)
            if name is not None:
                yield line.control, (name,), ("midi", "map", index, "values")


def check_group_calls(patch: Patch, claims: DancerSelections, find: Callable[[str], object]) -> None:
    """Raise PersonError for an unknown group or formation in a call of the score or of a cue.

    `find` resolves a formation's name or words. Formations that a call of the patch defines are known.
    """
    texts = [row for row in calls_of(patch) if any(isinstance(value, str) for value in row[1])]  # names are texts
    made = [(REGISTRY.call(call, values, 0.0, "patch"), call, place) for call, values, place in texts]
    defined = {event.name.casefold().strip() for event, _, _ in made if isinstance(event, DefineFormation)}
    for event, call, place in made:
        group, formation = getattr(event, "group", None), getattr(event, "formation", None)
        with error_context(f"call {call}", place):
            if isinstance(group, str):
                claims.bits(group)
            if isinstance(formation, str) and formation.casefold().strip() not in defined:
                find(formation)
