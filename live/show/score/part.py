"""Part of one group in the score: for each measure a sequence, an improvisation, or nothing (the group's own steps)."""

from typing import Final, Literal

from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import HORIZON
from live.graph.search.sequence_spec import Wanted
from live.show.patch.patch import Patch
from live.show.patch.section_motion import parse_entry
from live.show.patch.section_score import ImproviseSection, SequenceSection
from live.show.score.improviser import Improviser, Kept, Nodes, table_of
from live.show.score.music_reactions import Mood
from live.show.score.score import Score
from live.show.score.sequence_lookup import Sequences
from live.show.score.step_history import Ledger

ANY_STEP: Final = -1
"""Wanted step where a sequence has "*"."""

Told = tuple[int, tuple[Wanted, ...], int]
"""Step, the steps wanted from there on, and measures already danced of the first of them."""


class Part:
    """Part of one group in the score. Ask for measures in order, as with programs."""

    def __init__(self, score: Score, sequences: Sequences, improviser: Improviser) -> None:
        self._score = score
        self._sequences = sequences
        self._improviser = improviser

    def take_patch(self, fresh: "Part") -> None:
        """Adopt the part from an edited patch; step history and requested improvisation stay."""
        self._sequences = fresh._sequences
        self._improviser.take_patch(fresh._improviser)

    def told(self, measure: int, nodes: Nodes, own: tuple[Wanted, ...], *, stands: bool) -> Told | None:
        """Return what to dance in `measure` by dancers who were in `nodes` before it; None: the group's own steps.

        `own` are the group's own steps after the score's; `stands`: prefer random steps in place.
        """
        if measure < 0:
            return None
        place = self._score.place(measure)
        if not self._improviser.asked:
            sequence = self._sequences.at(place.section, place.measure)
            if sequence is not None:
                index, into = sequence.at(place.measure)
                entry = sequence.entries[index]
                step = ANY_STEP if entry.step is None else entry.step
                return step, self._coming(measure, own), into
        return self._improviser.told(measure, nodes, stands=stands)

    def kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Return the origin of the steps that the group dances in `measure`."""
        place = self._score.place(measure)
        if measure >= 0 and not self._improviser.asked and self._sequences.at(place.section, place.measure) is not None:
            return "sequence"
        return "improvised" if measure >= 0 and self._improviser.holds(measure) else "own"

    def holds(self, measure: int) -> bool:
        """Whether the score has an entry for the group in `measure`."""
        if measure < 0:
            return False
        place = self._score.place(measure)
        return self._sequences.at(place.section, place.measure) is not None or self._improviser.holds(measure)

    def _coming(self, measure: int, own: tuple[Wanted, ...]) -> tuple[Wanted, ...]:
        """Return the entries of the sequences from `measure` on, then the group's own steps."""
        found: list[Wanted] = []
        while len(found) <= HORIZON:
            place = self._score.place(measure)
            sequence = self._sequences.at(place.section, place.measure)
            if sequence is None:
                break
            index, into = sequence.at(place.measure)
            found.append(sequence.entries[index])
            measure += found[-1].measures - into
        return (*found, *own)[: HORIZON + 1]

    def note(self, measure: int, step: int, into: int) -> None:
        """Record the step that the group dances in `measure`, whatever its origin."""
        if measure >= 0:
            self._improviser.note(measure, step, into)

    # -- state -------------------------------------------------------------------------------------------------

    @property
    def kept(self) -> Kept:
        """State needed to ask again: see `take_back` of the programs."""
        return self._improviser.kept

    @kept.setter
    def kept(self, kept: Kept) -> None:
        self._improviser.kept = kept

    def improvise(self, on: bool) -> None:
        """Switch improvisation on regardless of the score; False: follow the score."""
        self._improviser.asked = on

    def take_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        self._improviser.take_graph(graph)


EVERYONE: Final = "*"


def part_of(
    patch: Patch, graph: MotionGraph, score: Score, ledger: Ledger, mood: Mood, steps: list[int], group: int, seed: int
) -> Part:
    """Return the part in the score of group `group`, whose own `steps` are these."""
    names = [section.name for section in patch.group]
    for_it = (EVERYONE, names[group].casefold())
    sequences = [(index, one) for index, one in enumerate(patch.sequence) if one.group.casefold() in for_it]
    asked: list[tuple[tuple[str | int, ...], ImproviseSection]] = [
        (("sequence", index), _as_improvised(section)) for index, section in sequences if section.choose == "random"
    ]
    # a canon improvises only where a table names its group; otherwise it stays a canon
    means_it = for_it[1:] if patch.group[group].like else for_it
    asked += [
        (("improvise", index), section)
        for index, section in enumerate(patch.improvise)
        if section.group.casefold() in means_it
    ]
    made = (table_of(section, score, graph, steps, names, group, where) for where, section in asked)
    tables = [table for table in made if table is not None]
    free = ImproviseSection(most=2 if len(set(steps)) > 1 else 1000)
    usual = table_of(free, score, graph, steps, names, group) if not tables else tables[0]
    assert usual is not None
    improviser = Improviser(tables, usual, score, ledger, mood, group=group, seed=seed, graph=graph)
    ordered = [(index, section) for index, section in sequences if section.choose == "sequence"]
    sequences_of = Sequences(ordered, score, graph, score.written.made)
    score.written.parts.append((sequences_of, tables, usual))
    return Part(score, sequences_of, improviser)


def _as_improvised(section: SequenceSection) -> ImproviseSection:
    """Return a sequence with `choose = "random"` as an improvise table, steps weighted by their count."""
    weights: dict[str, float] = {}
    for entry in section.steps:
        name, times = parse_entry(entry)
        weights[name] = weights.get(name, 0.0) + times
    return ImproviseSection(
        group=section.group,
        section=section.section,
        measure=section.measure,
        measures=section.measures,
        steps=weights,
        most=2 if len(weights) > 1 else 1000,
    )
