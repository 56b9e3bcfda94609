"""Part of a group or subgroup in the score: for each measure a sequence, an improvisation, or nothing."""

from collections.abc import Iterator, Sequence
from copy import copy
from typing import Final, Literal

from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import HORIZON
from live.graph.search.sequence_spec import SequenceEntry
from live.show.patch.patch import Patch
from live.show.patch.section_motion import parse_entry
from live.show.patch.section_score import ImproviseSection, SequenceSection
from live.show.score.improviser import DrawState, EntrySpan, Improviser, Nodes, resolve_table
from live.show.score.music_reactions import Mood
from live.show.score.score import Score
from live.show.score.sequence_lookup import SequenceLookup
from live.show.score.step_history import StepHistory, required_capacity

ANY_STEP: Final = -1
"""Wanted step where a sequence has "*"."""

StepChoice = tuple[int, tuple[SequenceEntry, ...], int]
"""Step, the steps wanted from there on, and measures already danced of the first of them."""


ScoreEntry = tuple[int, int, int, int]
"""Kind (0: sequence, 1: improvisation), index, first measure in its section, and turn of the section."""


class ScorePart:
    """Part of one group or subgroup in the score. Ask for measures in order, as with programs."""

    def __init__(self, score: Score, sequences: SequenceLookup, improviser: Improviser) -> None:
        self._score = score
        self._sequences = sequences
        self._improviser = improviser

    def apply_patch(self, fresh: "ScorePart") -> None:
        """Adopt the part from an edited patch; step history and requested improvisation stay."""
        self._sequences = fresh._sequences
        self._improviser.apply_patch(fresh._improviser)

    def choose(
        self, measure: int, nodes: Nodes, own: tuple[SequenceEntry, ...], *, standing: bool, measure_s: float = 0.0
    ) -> StepChoice | None:
        """Return what to dance in `measure` by dancers who were in `nodes` before it; None: the group's own steps.

        `own` are the group's own steps after the score's; `standing`: prefer random steps in place; `measure_s`: and
        those that were recorded near the tempo of such measures [s].
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
        return self._improviser.choose(measure, nodes, standing=standing, measure_s=measure_s)

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

    def entry(self, measure: int) -> ScoreEntry | None:
        """Return what the score has here in `measure`; None for nothing."""
        if measure < 0:
            return None
        place = self._score.place(measure)
        sequence = self._sequences.at(place.section, place.measure)
        if sequence is not None:
            return 0, sequence.index, sequence.begin, place.turn
        table = self._improviser.entry(place)
        return None if table is None else (1, *table, place.turn)

    def spans(self) -> Iterator[EntrySpan]:
        """Yield section, first measure, measure after the last, and place in the patch of each entry."""
        yield from self._sequences.spans()
        yield from self._improviser.spans()

    def begins(self, measure: int, entry: ScoreEntry) -> bool:
        """Whether an entry, which the score has in `measure`, begins there."""
        return self._score.place(measure).measure == entry[2] and self._score.playhead.entered(measure)

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

    @property
    def improvises(self) -> bool:
        """Whether improvisation was requested."""
        return self._improviser.forced

    def attach(self, running: "ScorePart") -> None:
        """Take part in the show of another part."""
        self._score = running._score
        self._improviser.attach(running._improviser)

    def copy(self, number: int) -> "ScorePart":
        """Return an independent copy for the subgroup with this number."""
        other = copy(self)
        other._improviser = self._improviser.copy(number)
        return other

    def forget(self) -> None:
        """Forget the past of a subgroup that has ended."""
        self._improviser.forget()

    def set_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        self._improviser.set_graph(graph)


EVERYONE: Final = "*"


class PartBuilder:
    """Builds the parts of one score, which share the history of steps."""

    def __init__(self, patch: Patch, graph: MotionGraph, score: Score, mood: Mood, seed: int) -> None:
        self._patch, self._graph, self._score, self._mood, self._seed = patch, graph, score, mood, seed
        self._names = [section.name for section in patch.group]
        self._sequences: dict[str, list[tuple[int, SequenceSection]]] = {}
        for index, sequence in enumerate(patch.sequence):
            self._sequences.setdefault(folded(sequence.group), []).append((index, sequence))
        self._improvised: dict[str, list[tuple[int, ImproviseSection]]] = {}
        for index, improvised in enumerate(patch.improvise):
            self._improvised.setdefault(folded(improvised.group), []).append((index, improvised))
        self.history = StepHistory(required_capacity(patch.improvise))

    @property
    def selections(self) -> list[str]:
        """The selections with steps that are no groups, in their order."""
        groups = {EVERYONE, *(folded(name) for name in self._names)}
        return [words for words in dict.fromkeys((*self._sequences, *self._improvised)) if words not in groups]

    def of_group(self, group: int, steps: list[int]) -> ScorePart:
        """Return the part of a group, whose own `steps` are these.

        PersonError for an unknown step, and for entries that overlap or exceed their section.
        """
        own = self._names[group].casefold()
        # a canon improvises only where a table names its group; otherwise it stays a canon
        means_it = (own,) if self._patch.group[group].like else (EVERYONE, own)
        part, data = self._build((EVERYONE, own), means_it, group, steps, group)
        self._score.written.parts.append([data])
        return part

    def of_selection(self, words: str, numbers: Sequence[int], steps: Sequence[list[int]]) -> list[ScorePart]:
        """Return the part of the subgroup of each group that `words` select, by group; `numbers` and own `steps` of the
        subgroups.  Empty words: parts without entries, for requests.
        """
        built = [
            self._build((words,), (words,), group, own, number)
            for group, (number, own) in enumerate(zip(numbers, steps, strict=True))
        ]
        self._score.written.parts.append([data for _, data in built])
        return [part for part, _ in built]

    def _build(
        self, ordered_for: tuple[str, ...], improvised_for: tuple[str, ...], group: int, steps: list[int], number: int
    ) -> tuple[ScorePart, tuple[object, ...]]:
        score, graph, names = self._score, self._graph, self._names
        sequences = [one for words in ordered_for for one in self._sequences.get(words, ())]
        sequences.sort(key=lambda one: one[0])
        asked: list[tuple[tuple[str | int, ...], ImproviseSection]] = [
            (("sequence", index), _improvise_section(section))
            for index, section in sequences
            if section.choose == "random"
        ]
        improvised = [one for words in improvised_for for one in self._improvised.get(words, ())]
        asked += [(("improvise", index), section) for index, section in sorted(improvised, key=lambda one: one[0])]
        made = (resolve_table(section, score, graph, steps, names, group, where) for where, section in asked)
        tables = [table for table in made if table is not None]
        free = ImproviseSection(most=2 if len(set(steps)) > 1 else 1000)
        usual = resolve_table(free, score, graph, steps, names, group) if not tables else tables[0]
        assert usual is not None
        improviser = Improviser(
            tables, usual, score, self.history, self._mood, group=number, seed=self._seed, graph=graph
        )
        ordered = [(index, section) for index, section in sequences if section.choose == "sequence"]
        sequences_of = SequenceLookup(ordered, score, graph, score.written.built_sequences)
        return ScorePart(score, sequences_of, improviser), (sequences_of, tables, usual)


def folded(words: str) -> str:
    """Return words of a selection in the form in which they are compared."""
    return " ".join(words.split()).casefold()


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
