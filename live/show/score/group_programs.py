"""Builder for the step programs of all groups of a patch, own ones or canons (T147), and of its subgroups (T026)."""

from collections.abc import Sequence

import numpy as np

from live.base.arrays import Int32
from live.base.errors import PersonError
from live.graph.motion_graph import MotionGraph
from live.show.group.casting import Casting
from live.show.patch.patch import Patch
from live.show.patch_checks.score_conflicts import DancerSelections, check_step_calls, check_subgroups
from live.show.score.canon import Canon, StepSource
from live.show.score.music_reactions import Mood
from live.show.score.part import PartBuilder
from live.show.score.score import Score
from live.show.score.step_program import StepProgram
from live.show.score.subgroups import MAX_SELECTIONS, Subgroup, Subgroups, subgroup_number


def build_programs(
    patch: Patch, graph: MotionGraph, seed: int, group: Int32, score: Score | None = None, mood: Mood | None = None
) -> tuple[list[StepSource], Subgroups]:
    """Return one program for each group, in the patch's order, and the subgroups; `group` (A,) of each dancer.

    Raises UnknownStep if a group names a missing step, PersonError for an invalid part of the score.
    """
    score, mood = score or Score(patch), mood or Mood()
    check_step_calls(patch, graph)
    parts = PartBuilder(patch, graph, score, mood, seed)

    def programs(numbers: Sequence[int]) -> list[StepProgram]:
        return [
            StepProgram(graph, section, seed=seed, index=number)
            for section, number in zip(sections, numbers, strict=True)
        ]

    sections = []
    for section in patch.group:
        leader = patch.leader_of(section)
        if leader is not section:
            travel = section.travel_step or leader.travel_step
            section = leader.model_copy(update={"name": section.name, "travel_step": travel})
        sections.append(section)
    own = programs(range(len(sections)))
    steps = [program.steps for program in own]
    for index, program in enumerate(own):
        program.part = parts.of_group(index, program.steps)
    names = [section.name for section in patch.group]
    groups: list[StepSource] = [
        Canon(own[names.index(section.like)], own[index], measures=section.beats_later // patch.clock.beats_per_measure)
        if section.like is not None
        else own[index]
        for index, section in enumerate(patch.group)
    ]
    written, idle = [], programs(range(len(sections)))
    _check_count(parts.selections)
    for words in ("", *parts.selections):
        numbers = [subgroup_number(words, name) for name in names]
        row = programs(numbers) if words else idle
        for program, part in zip(row, parts.of_selection(words, numbers, steps), strict=True):
            program.part = part
        if words:
            nobody = np.zeros(len(group), np.bool_)
            written.append([Subgroup(words, index, program, nobody) for index, program in enumerate(row)])
    spans = [(row[0].words, span) for row in written if row[0].program.part for span in row[0].program.part.spans()]
    check_subgroups(spans, DancerSelections(patch, Casting(patch)))
    return groups, Subgroups(group, groups, written, idle)


def _check_count(selections: list[str]) -> None:
    if len(selections) > MAX_SELECTIONS:
        raise PersonError(
            f"{len(selections)} different selections have steps of their own, at most {MAX_SELECTIONS} can",
            "give the steps to groups, or name selections under [selections]",
        )


def update_programs(running: list[StepSource], fresh: list[StepSource], patch: Patch) -> None:
    """Update running programs to the edited `patch`, whose programs are `fresh`.

    Unchanged groups continue without interruption. Called steps and sequences set live stay.
    """
    for index, (own, new) in enumerate(zip(running, fresh, strict=True)):
        match own, new:
            case StepProgram(), StepProgram():
                own.apply_patch(new)
            case Canon(), Canon():
                own.apply_patch(new)
            case _:
                if isinstance(own, StepProgram | Canon):
                    new.attach(own if isinstance(own, StepProgram) else own.own)
                running[index] = new
    names = [section.name for section in patch.group]
    for programme, section in zip(running, patch.group, strict=True):
        if isinstance(programme, Canon) and section.like is not None:
            leader = running[names.index(section.like)]
            assert isinstance(leader, StepProgram)  # a leader is never an echo itself
            programme.set_leader(leader)
