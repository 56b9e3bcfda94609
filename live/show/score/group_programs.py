"""The programmes of all groups of a patch: their own, or echoes of others (T147), each with its part in the score."""

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
    """One for each group, in the patch's order; UnknownStep if a group names a step that is not there, PersonError for
    a part of the score that cannot be."""
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
    """Let groups go on with what `patch`, whose programmes are `fresh`, says; who dances the same goes on undisturbed.

    What was called or set live stays.
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
            assert isinstance(leader, GroupProgramme)  # whoever is echoed echoes nobody
            programme.follow(leader)
