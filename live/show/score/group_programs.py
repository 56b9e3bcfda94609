"""Builder for the step programs of all groups of a patch: own programs or canons (T147), with their score parts."""

from live.graph.motion_graph import MotionGraph
from live.show.patch.patch import Patch
from live.show.patch.score_conflicts import check_calls
from live.show.score.canon import Echo, Programme
from live.show.score.music_reactions import Mood
from live.show.score.part import part_of
from live.show.score.score import Score
from live.show.score.step_history import Ledger, remembered
from live.show.score.step_program import GroupProgramme


def programmes_of(
    patch: Patch, graph: MotionGraph, seed: int, score: Score | None = None, mood: Mood | None = None
) -> list[Programme]:
    """Return one program for each group, in the patch's order.

    Raises UnknownStep if a group names a missing step, PersonError for an invalid part of the score.
    """
    score, mood = score or Score(patch), mood or Mood()
    check_calls(patch, graph)
    own: list[GroupProgramme] = []
    ledger = Ledger(len(patch.group), remembered(patch.improvise))
    for index, section in enumerate(patch.group):
        leader = patch.leader_of(section)
        if leader is not section:
            travel = section.travel_step or leader.travel_step
            section = leader.model_copy(update={"name": section.name, "travel_step": travel})
        programme = GroupProgramme(graph, section, seed=seed, index=index)
        programme.part = part_of(patch, graph, score, ledger, mood, programme.steps, index, seed)
        own.append(programme)
    names = [section.name for section in patch.group]
    return [
        Echo(own[names.index(section.like)], own[index], measures=section.beats_later // patch.clock.beats_per_measure)
        if section.like is not None
        else own[index]
        for index, section in enumerate(patch.group)
    ]


def take_programmes(running: list[Programme], fresh: list[Programme], patch: Patch) -> None:
    """Update running programs to the edited `patch`, whose programs are `fresh`.

    Unchanged groups continue without interruption. Called steps and sequences set live stay.
    """
    for index, (own, new) in enumerate(zip(running, fresh, strict=True)):
        match own, new:
            case GroupProgramme(), GroupProgramme():
                own.take_patch(new)
            case Echo(), Echo():
                own.take_patch(new)
            case _:
                running[index] = new
    names = [section.name for section in patch.group]
    for programme, section in zip(running, patch.group, strict=True):
        if isinstance(programme, Echo) and section.like is not None:
            leader = running[names.index(section.like)]
            assert isinstance(leader, GroupProgramme)  # a leader is never an echo itself
            programme.follow(leader)
