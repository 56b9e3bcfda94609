"""Builder for the step programs of all groups of a patch: own programs or canons (T147), with their score parts."""

from live.graph.motion_graph import MotionGraph
from live.show.patch.patch import Patch
from live.show.patch_checks.score_conflicts import check_step_calls
from live.show.score.canon import Canon, StepSource
from live.show.score.music_reactions import Mood
from live.show.score.part import build_part
from live.show.score.score import Score
from live.show.score.step_history import StepHistory, required_capacity
from live.show.score.step_program import StepProgram


def build_programs(
    patch: Patch, graph: MotionGraph, seed: int, score: Score | None = None, mood: Mood | None = None
) -> list[StepSource]:
    """Return one program for each group, in the patch's order.

    Raises UnknownStep if a group names a missing step, PersonError for an invalid part of the score.
    """
    score, mood = score or Score(patch), mood or Mood()
    check_step_calls(patch, graph)
    own: list[StepProgram] = []
    ledger = StepHistory(len(patch.group), required_capacity(patch.improvise))
    for index, section in enumerate(patch.group):
        leader = patch.leader_of(section)
        if leader is not section:
            travel = section.travel_step or leader.travel_step
            section = leader.model_copy(update={"name": section.name, "travel_step": travel})
        programme = StepProgram(graph, section, seed=seed, index=index)
        programme.part = build_part(patch, graph, score, ledger, mood, programme.steps, index, seed)
        own.append(programme)
    names = [section.name for section in patch.group]
    return [
        Canon(own[names.index(section.like)], own[index], measures=section.beats_later // patch.clock.beats_per_measure)
        if section.like is not None
        else own[index]
        for index, section in enumerate(patch.group)
    ]


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
                running[index] = new
    names = [section.name for section in patch.group]
    for programme, section in zip(running, patch.group, strict=True):
        if isinstance(programme, Canon) and section.like is not None:
            leader = running[names.index(section.like)]
            assert isinstance(leader, StepProgram)  # a leader is never an echo itself
            programme.set_leader(leader)
