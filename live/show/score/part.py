"""Part: what the score has for one group in each measure: a sequence, an improvisation, or nothing (then its own)."""

from typing import Final, Literal

from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import HORIZON
from live.graph.search.sequence_spec import Wanted
from live.show.score.improviser import Improviser, Kept, Nodes
from live.show.score.score import Score
from live.show.score.sequence_lookup import Sequences

ANY_STEP: Final = -1
"""What is wanted where a sequence says "*"."""

Told = tuple[int, tuple[Wanted, ...], int]
"""The step, what comes from there on, and how many measures of the first of that are over."""


class Part:
    """One group's part in the score. To be asked in the order of the measures, as programmes are."""

    def __init__(self, score: Score, sequences: Sequences, improviser: Improviser) -> None:
        self._score = score
        self._sequences = sequences
        self._improviser = improviser

    def take_patch(self, fresh: "Part") -> None:
        """Dance what another patch's score has for the group; what was danced and asked for stays."""
        self._sequences = fresh._sequences
        self._improviser.take_patch(fresh._improviser)

    def told(self, measure: int, nodes: Nodes, own: tuple[Wanted, ...], *, stands: bool) -> Told | None:
        """What to dance in `measure` by dancers who were in `nodes` before it; None: the group's own steps.

        `own` is what comes of these after the score's; `stands`: chance draws among steps in place if it can.
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
        """Whose steps the group dances in `measure`."""
        place = self._score.place(measure)
        if measure >= 0 and not self._improviser.asked and self._sequences.at(place.section, place.measure) is not None:
            return "sequence"
        return "improvised" if measure >= 0 and self._improviser.holds(measure) else "own"

    def holds(self, measure: int) -> bool:
        """Whether the score has something for the group in `measure`."""
        if measure < 0:
            return False
        place = self._score.place(measure)
        return self._sequences.at(place.section, place.measure) is not None or self._improviser.holds(measure)

    def _coming(self, measure: int, own: tuple[Wanted, ...]) -> tuple[Wanted, ...]:
        """What the sequences have from `measure` on, as far as they go, and then the group's own steps."""
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
        """The group dances this in `measure`, whoever wanted it."""
        if measure >= 0:
            self._improviser.note(measure, step, into)

    # -- what is kept ------------------------------------------------------------------------------------------

    @property
    def kept(self) -> Kept:
        """What must be known to ask again: see `take_back` of the programmes."""
        return self._improviser.kept

    @kept.setter
    def kept(self, kept: Kept) -> None:
        self._improviser.kept = kept

    def improvise(self, on: bool) -> None:
        """Let the group improvise, whatever the score has for it; False: as the score says."""
        self._improviser.asked = on

    def take_graph(self, graph: MotionGraph) -> None:
        """Choose in a graph that has all nodes and steps of the old one."""
        self._improviser.take_graph(graph)
