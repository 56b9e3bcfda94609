"""Part of one group in the score: for each measure a sequence, an improvisation, or nothing (the group's own steps)."""

from typing import Final, Literal

from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import HORIZON
from live.graph.search.sequence_spec import SequenceEntry
from live.show.patch.patch import Patch
from live.show.patch.section_motion import parse_entry
from live.show.patch.section_score import ImproviseSection, SequenceSection
from live.show.score.improviser import DrawState, Improviser, Nodes, resolve_table
from live.show.score.music_reactions import Mood
from live.show.score.score import Score
from live.show.score.sequence_lookup import SequenceLookup
from live.show.score.step_history import StepHistory

ANY_STEP: Final = -1
"""Wanted step where a sequence has "*"."""

StepChoice = tuple[int, tuple[SequenceEntry, ...], int]
"""Step, the steps wanted from there on, and measures already danced of the first of them."""


class ScorePart:
    """Part of one group in the score. Ask for measures in order, as with programs."""

    def __init__(self, score: Score, sequences: SequenceLookup, improviser: Improviser) -> None:
        self._score = score
        self._sequences = sequences
        self._improviser = improviser

    def apply_patch(self, fresh: "ScorePart") -> None:
        """Adopt the part from an edited patch; step history and requested improvisation stay."""
        self._sequences = fresh._sequences
        self._improviser.apply_patch(fresh._improviser)

    def choose(
        self, measure: int, nodes: Nodes, own: tuple[SequenceEntry, ...], *, standing: bool
    ) -> StepChoice | None:
        """Return what to dance in `measure` by dancers who were in `nodes` before it; None: the group's own steps.

        `own` are the group's own steps after the score's; `standing`: prefer random steps in place.
        """
        if measure < 0:
            return None
        place = self._score.place(measure)
        if not self._improviser.forced:
            sequence = self._sequences.at(place.section, place.measure)
            if sequence is not None:
                index, into = sequence.entry_at(place.measure)
                entry = sequence.entries[index]
                step = ANY_STEP if entry.step is None else entry.step
                return step, self._upcoming(measure, own), into
        return self._improviser.choose(measure, nodes, standing=standing)

    def kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Return the origin of the steps that the group dances in `measure`."""
        place = self._score.place(measure)
        if (
            measure >= 0
            and not self._improviser.forced
            and self._sequences.at(place.section, place.measure) is not None
        ):
            return "sequence"
        return "improvised" if measure >= 0 and self._improviser.is_improvised(measure) else "own"

    def has_entry(self, measure: int) -> bool:
        """Whether the score has an entry for the group in `measure`."""
        if measure < 0:
            return False
        place = self._score.place(measure)
        return self._sequences.at(place.section, place.measure) is not None or self._improviser.is_improvised(measure)

    def _upcoming(self, measure: int, own: tuple[SequenceEntry, ...]) -> tuple[SequenceEntry, ...]:
        """Return the entries of the sequences from `measure` on, then the group's own steps."""
        found: list[SequenceEntry] = []
        while len(found) <= HORIZON:
            place = self._score.place(measure)
            sequence = self._sequences.at(place.section, place.measure)
            if sequence is None:
                break
            index, into = sequence.entry_at(place.measure)
            found.append(sequence.entries[index])
            measure += found[-1].measures - into
        return (*found, *own)[: HORIZON + 1]

    def record(self, measure: int, step: int, into: int) -> None:
        """Record the step that the group dances in `measure`, whatever its origin."""
        if measure >= 0:
            self._improviser.record(measure, step, into)

    # -- state -------------------------------------------------------------------------------------------------

    @property
    def draw_state(self) -> DrawState:
        """State needed to ask again: see `undo` of the programs."""
        return self._improviser.draw_state

    @draw_state.setter
    def draw_state(self, kept: DrawState) -> None:
        self._improviser.draw_state = kept

    def improvise(self, on: bool) -> None:
        """Switch improvisation on regardless of the score; False: follow the score."""
        self._improviser.forced = on

    def set_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        self._improviser.set_graph(graph)


EVERYONE: Final = "*"


def build_part(
    patch: Patch,
    graph: MotionGraph,
    score: Score,
    history: StepHistory,
    mood: Mood,
    steps: list[int],
    group: int,
    seed: int,
) -> ScorePart:
    """Return the part in the score of group `group`, whose own `steps` are these."""
    names = [section.name for section in patch.group]
    for_it = (EVERYONE, names[group].casefold())
    sequences = [(index, one) for index, one in enumerate(patch.sequence) if one.group.casefold() in for_it]
    asked: list[tuple[tuple[str | int, ...], ImproviseSection]] = [
        (("sequence", index), _improvise_section(section)) for index, section in sequences if section.choose == "random"
    ]
    # a canon improvises only where a table names its group; otherwise it stays a canon
    means_it = for_it[1:] if patch.group[group].like else for_it
    asked += [
        (("improvise", index), section)
        for index, section in enumerate(patch.improvise)
        if section.group.casefold() in means_it
    ]
    made = (resolve_table(section, score, graph, steps, names, group, where) for where, section in asked)
    tables = [table for table in made if table is not None]
    free = ImproviseSection(most=2 if len(set(steps)) > 1 else 1000)
    usual = resolve_table(free, score, graph, steps, names, group) if not tables else tables[0]
    assert usual is not None
    improviser = Improviser(tables, usual, score, history, mood, group=group, seed=seed, graph=graph)
    ordered = [(index, section) for index, section in sequences if section.choose == "sequence"]
    sequences_of = SequenceLookup(ordered, score, graph, score.written.built_sequences)
    score.written.parts.append((sequences_of, tables, usual))
    return ScorePart(score, sequences_of, improviser)


def _improvise_section(section: SequenceSection) -> ImproviseSection:
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
