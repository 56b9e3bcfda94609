"""The parts of the groups in the score of a patch: their sequences and their improvisations."""

from typing import Final

from live.graph.motion_graph import MotionGraph
from live.show.patch.group import parse_entry
from live.show.patch.improvise import ImproviseSection
from live.show.patch.patch import Patch
from live.show.patch.sequence import SequenceSection
from live.show.score.improvise_table import table_of
from live.show.score.improviser import Improviser
from live.show.score.mood import Mood
from live.show.score.part import Part
from live.show.score.score import Score
from live.show.score.sequence_lookup import Sequences
from live.show.score.step_history import Ledger

EVERYONE: Final = "*"


def part_of(
    patch: Patch, graph: MotionGraph, score: Score, ledger: Ledger, mood: Mood, steps: list[int], group: int, seed: int
) -> Part:
    """The part in the score of the group `group`, whose own `steps` are these."""
    names = [section.name for section in patch.group]
    for_it = (EVERYONE, names[group].casefold())
    sequences = [(index, one) for index, one in enumerate(patch.sequence) if one.group.casefold() in for_it]
    asked: list[tuple[tuple[str | int, ...], ImproviseSection]] = [
        (("sequence", index), _as_improvised(section)) for index, section in sequences if section.choose == "random"
    ]
    # an echo improvises only where it is meant by name: else it goes on echoing
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
    """A sequence in which chance chooses: its steps by how often they are named."""
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
