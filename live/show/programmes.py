"""The programmes of all groups of a patch: their own, or echoes of others (T147)."""

from live.graph.motion_graph import MotionGraph
from live.show.echo import Echo, Programme
from live.show.patch import Patch
from live.show.programme import GroupProgramme


def programmes_of(patch: Patch, graph: MotionGraph, seed: int) -> list[Programme]:
    """One for each group, in the patch's order; UnknownStep if a group names a step that is not there."""
    own: list[GroupProgramme] = []
    for index, section in enumerate(patch.group):
        leader = patch.leader_of(section)
        if leader is not section:
            travel = section.travel_step or leader.travel_step
            section = leader.model_copy(update={"name": section.name, "travel_step": travel})
        own.append(GroupProgramme(graph, section, seed=seed, index=index))
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
