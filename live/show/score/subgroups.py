"""Subgroups: dancers of a group who have steps of their own, from the score or on request.

Steps belong to groups, subgroups or single dancers (T026; Schulz 2011, 2.4.3), and a group may be divided again and
again (T104). A selection that covers several groups is a subgroup of each. Where subgroups share a dancer, requested
ones count before written ones, and smaller ones before larger ones.
"""

import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Int32
from live.base.errors import PersonError

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph
    from live.graph.search.sequence_spec import SequenceEntry
    from live.show.score.canon import StepSource
    from live.show.score.part import ScoreEntry
    from live.show.score.step_program import StepProgram

    RequestedSequence = tuple[str, int, tuple[int, ...], tuple[SequenceEntry, ...]]

MAX_SUBGROUPS: Final = 64
"""Maximum number of subgroups that dance at a time."""
MAX_REQUESTED: Final = 32
"""Maximum number of requested ones among them."""
MAX_SELECTIONS: Final = 256
"""Maximum number of different selections with steps in a score."""
GROUP_ONLY: Final = -1
"""Subgroup of a dancer who has none."""

Select = Callable[[str], Bool]
"""Returns the dancers that words select now, (A,)."""


@dataclass(slots=True, eq=False)
class Subgroup:
    """Dancers of one group with a program of their own."""

    words: str
    """Selection, as written or requested."""
    group: int
    """Index of their group."""
    program: "StepProgram"
    chosen: Bool
    """The dancers selected when the entry began, or when it was requested; those of other groups do not count, (A,)."""
    entry: "ScoreEntry | None" = None
    """Entry of the score for which they were selected."""


def subgroup_number(words: str, group: str) -> int:
    """Return the number of a written subgroup, for random numbers: the same wherever it stands in the score."""
    return (1 << 32) | zlib.crc32(f"{words} {group}".encode())


_REQUESTED: Final = 1 << 33
"""Numbers of requested subgroups begin here."""


class Subgroups:
    """The subgroups of one show's groups."""

    def __init__(
        self, group: Int32, programs: "list[StepSource]", written: list[list[Subgroup]], idle: "list[StepProgram]"
    ) -> None:
        """`group` (A,) is shared with the show, `programs` are those of the groups.

        `written`: those of the score, for each selection one of each group; `idle`: for each group a program without
        entries, which requested subgroups begin with.
        """
        self._group, self._programs, self._idle = group, programs, idle
        self.written = written
        self.requested: list[Subgroup] = []
        """Those that were requested and still count, the newest last."""
        self.active: list[Subgroup] = []
        """Those that dance in the measure that was assigned last."""
        self.of_dancer: Int32 = np.full(len(group), GROUP_ONLY, np.int32)
        """Index of each dancer's subgroup in `active` in that measure, or GROUP_ONLY, shape (A,)."""
        self._count = 0
        self._assigned: int | None = None
        self._before: list[tuple[Bool, ScoreEntry | None]] = []

    def _all(self) -> Iterable[Subgroup]:
        yield from (each for row in self.written for each in row)
        yield from self.requested

    # -- measures ----------------------------------------------------------------------------------------------

    def assign(self, measure: int, select: Select) -> None:
        """Find the subgroups that dance in `measure` (from 0), and their dancers. Ask for measures in order."""
        if not self.written and not self.requested:
            self.active.clear()
            self.of_dancer[:] = GROUP_ONLY
            return
        if self._assigned != measure:
            self._assigned = measure
            self._before = [(each.chosen, each.entry) for row in self.written for each in row]
        found: list[tuple[int, Subgroup, Bool]] = []
        for row in self.written:
            entry = row[0].program.part.entry(measure) if row[0].program.part is not None else None
            if entry is not None:
                self._begin(row, entry, measure, select)
                for each in row:
                    members = each.chosen & (self._group == each.group)
                    if members.any() and not self._programs[each.group].is_asked:
                        found.append((int(members.sum()), each, members))
        found.sort(key=lambda one: -one[0])  # a stable sort: among equals the later one counts
        self._drop_finished()
        found += [(0, each, each.chosen & (self._group == each.group)) for each in self.requested]
        which: Int32 = np.full(len(self._group), GROUP_ONLY, np.int32)
        for index, (_, _, members) in enumerate(found):
            which[members] = index
        danced = np.unique(which[which >= 0])[-MAX_SUBGROUPS:]
        self.active = [found[index][1] for index in danced.tolist()]
        self.of_dancer[:] = GROUP_ONLY
        for place, index in enumerate(danced.tolist()):
            self.of_dancer[which == index] = place

    @staticmethod
    def _begin(row: list[Subgroup], entry: "ScoreEntry", measure: int, select: Select) -> None:
        """Select the dancers of an entry that begins; places count then."""
        part = row[0].program.part
        if row[0].entry == entry and (part is None or not part.begins(measure, entry)):
            return
        who = select(row[0].words)
        for each in row:
            each.chosen, each.entry = who, entry

    def _drop_finished(self) -> None:
        for each in [one for one in self.requested if not one.program.is_asked or not one.chosen.any()]:
            self.requested.remove(each)
            if each.program.part is not None:
                each.program.part.forget()

    def undo(self, measure: int) -> None:
        """Undo the assignment and the answers for `measure`, which has not begun."""
        for each in self._all():
            each.program.undo(measure)
        if self._assigned == measure:
            written = (each for row in self.written for each in row)
            for each, (chosen, entry) in zip(written, self._before, strict=False):
                each.chosen, each.entry = chosen, entry
            self._assigned = None

    # -- requests ----------------------------------------------------------------------------------------------

    def request(self, words: str, who: Bool) -> "list[StepProgram]":
        """Return the programs of the dancers `who` (A,), which no other dancer shares; new ones where necessary.

        PersonError if there would be too many.
        """
        if not self.has_room(who):
            raise PersonError(
                f"{words!r}: more than {MAX_REQUESTED} subgroups would have steps of their own",
                "give the steps to a whole group, or end them with /dance/clear",
            )
        return [self._part(words, *part) for part in self._parts(who)]

    def has_room(self, who: Bool) -> bool:
        """Whether a request for the dancers `who` (A,) can be kept."""
        divided = [old for old, members, _ in self._parts(who) if old is None or (old.chosen & ~members).any()]
        return len(self.requested) + len(divided) <= MAX_REQUESTED

    def _parts(self, who: Bool) -> list[tuple[Subgroup | None, Bool, int]]:
        """Return `who` (A,) by the requested subgroup that they are in, and by group."""
        parts: list[tuple[Subgroup | None, Bool, int]] = []
        for group in np.unique(self._group[who]).tolist():
            rest = who & (self._group == group)
            for old in self.requested:
                both = rest & old.chosen
                if old.group == group and both.any():
                    parts.append((old, both, group))
                    rest = rest & ~both
            if rest.any():
                parts.append((None, rest, group))
        return parts

    def _part(self, words: str, old: Subgroup | None, who: Bool, group: int) -> "StepProgram":
        if old is not None and not (old.chosen & (self._group == group) & ~who).any():
            return old.program
        like = self._idle[group] if old is None else old.program
        self._count += 1
        made = Subgroup(words, group, like.copy(_REQUESTED + self._count), who)
        if old is not None:
            old.chosen = old.chosen & ~who
        self.requested.append(made)
        return made.program

    def drop_requested(self, group: int) -> None:
        """Drop the requested subgroups of a group, which got new steps as a whole."""
        for each in [one for one in self.requested if one.group == group]:
            each.program.release()
        self._drop_finished()

    def call(self, group: int, step: int, *, measures: float) -> None:
        """Call a step of a whole group: its requested subgroups dance it too, before theirs resume."""
        for each in self.requested:
            if each.group == group:
                each.program.call(step, measures=measures)

    def end_call(self, group: int) -> None:
        """End a called step of a whole group."""
        for each in self.requested:
            if each.group == group:
                each.program.end_call()

    def clear(self) -> None:
        """Drop all requests."""
        for group in range(len(self._programs)):
            self.drop_requested(group)

    @property
    def sequences(self) -> "tuple[RequestedSequence, ...]":
        """Requested sequences: words, group, dancers (from 0), and steps."""
        return tuple(
            (each.words, each.group, tuple(np.flatnonzero(each.chosen).tolist()), each.program.live_sequence)
            for each in self.requested
            if each.program.live_sequence
        )

    def restore_sequences(self, wanted: "Iterable[RequestedSequence]") -> None:
        """Replace the requested sequences; see `sequences`."""
        for each in self.requested:
            if each.program.live_sequence:
                each.program.release()
        self._drop_finished()
        for words, _, dancers, steps in wanted:
            who = np.zeros(len(self._group), np.bool_)
            who[list(dancers)] = True
            for program in self.request(words, who):
                program.set_sequence(list(steps))

    # -- exchange of graph and patch -----------------------------------------------------------------------------

    def set_graph(self, graph: "MotionGraph") -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        for program in (*(each.program for each in self._all()), *self._idle):
            program.set_graph(graph)

    def apply_patch(self, fresh: "Subgroups") -> None:
        """Adopt the subgroups of an edited score; those that are in both continue, and requests stay."""
        known: Mapping[str, list[Subgroup]] = {row[0].words: row for row in self.written}
        written = []
        for new in fresh.written:
            row = known.get(new[0].words)
            if row is None:
                for each in new:
                    each.program.attach(self._idle[each.group])
                written.append(new)
                continue
            for each, other in zip(row, new, strict=True):
                each.program.apply_patch(other.program)
            written.append(row)
        self.written, self._assigned, self._before = written, None, []
        for program, other_program in zip(self._idle, fresh._idle, strict=True):
            program.apply_patch(other_program)
        for each in self.requested:
            each.program.apply_patch(fresh._idle[each.group])
        self._drop_removed()

    def _drop_removed(self) -> None:
        """End the subgroups that dance and that the edited score no longer has."""
        kept = {id(each) for each in self._all()}
        places = [place for place, each in enumerate(self.active) if id(each) in kept]
        if len(places) == len(self.active):
            return
        before = self.of_dancer.copy()
        self.of_dancer[:] = GROUP_ONLY
        for new, place in enumerate(places):
            self.of_dancer[before == place] = new
        self.active = [self.active[place] for place in places]
