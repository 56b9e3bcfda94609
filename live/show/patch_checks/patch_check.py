"""All checks of a patch, in the order in which errors are reported: of single tables, then of tables together."""

from collections.abc import Iterator
from typing import Final

from live.base.errors import PersonError
from live.base.projector_perspective import camera_from_corners
from live.show.patch.patch import Patch
from live.show.patch.section_base import Checks, InvalidEntry
from live.show.patch.section_motion import parse_facing
from live.show.patch_checks.entry_checks import ENTRY_CHECKS
from live.show.patch_checks.name_checks import (
    check_answers,
    check_call_names,
    check_cues,
    check_performers,
    check_trackers,
)
from live.show.patch_checks.score_checks import check_score

MAX_DANCERS: Final = 20_000
"""Most dancers of all groups together; two cores keep up with about half as many at 60 frames a second."""


def table_faults(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield all errors between the tables of a patch whose tables are valid each."""
    yield from _check_size(patch)
    yield from _check_unique_names(patch)
    yield from check_trackers(patch.psn, patch.mocap)
    yield from check_answers(patch.answer, patch.mocap)
    yield from check_performers(patch)
    yield from _check_projector(patch)
    yield from _check_characters(patch)
    yield from _check_elements(patch)
    yield from _check_leaders(patch)
    yield from _check_facings(patch)
    yield from _check_regroups(patch)
    yield from check_score(patch)
    yield from check_cues(patch)
    yield from check_call_names(patch)


def check_patch(patch: Patch) -> None:
    """Raise InvalidEntry for the first error between the tables of a patch; its `others` are the further ones."""
    faults = list(table_faults(patch))
    if faults:
        faults[0].others = tuple(faults[1:])
        raise faults[0]


PATCH_CHECKS: Final[Checks] = {**ENTRY_CHECKS, "patch": check_patch}
"""The context with which a patch from outside is validated: a file, an edit, a journal."""


def _check_size(patch: Patch) -> Iterator[InvalidEntry]:
    if patch.dancer_count > MAX_DANCERS:
        largest = max(range(len(patch.group)), key=lambda index: patch.group[index].dancers)
        words = f"{patch.dancer_count} dancers in all groups; {MAX_DANCERS} at most, and `live bench frame` tells how "
        yield InvalidEntry(f"{words}many this machine keeps up with", "group", largest, "dancers")


def _check_unique_names(patch: Patch) -> Iterator[InvalidEntry]:
    things = {"group": [group.name for group in patch.group]}
    things |= {"formation": [str(table["name"]) for table in patch.formation]}
    things |= {"evolution": [evolution.name for evolution in patch.evolution]}
    things |= {"view": [view.name for view in patch.view], "looks": [look.name for look in patch.looks]}
    things |= {"scene": [scene.name for scene in patch.scene], "cue": [cue.name for cue in patch.cue]}
    things["pad"] = [pad.name for pad in patch.pad]
    things["mocap"] = [performer.name for performer in patch.mocap]
    things["answer"] = [answer.name for answer in patch.answer]
    things["scenery"], things["title"] = [each.name for each in patch.scenery], [each.name for each in patch.title]
    things["background"] = [background.name for background in patch.background]
    things |= {"character": [each.name for each in patch.character]}
    things["partner"] = [partner.name for partner in patch.partner]
    things |= {"gate": [gate.name for gate in patch.gate], "obstacle": [item.name for item in patch.obstacle]}
    things["item"] = [item.name or f"\0{index}" for index, item in enumerate(patch.item)]
    for what, names in things.items():
        known: set[str] = set()
        for index, name in enumerate(names):
            folded = name.casefold().strip()
            if folded in known:
                words = f"two {what.removesuffix('s')}s are called {name[:60]!r}: give each its own name"
                yield InvalidEntry(words, what, index, "name")
            known.add(folded)


def _check_projector(patch: Patch) -> Iterator[InvalidEntry]:
    """Raise InvalidEntry if no projector at its place sees the floor of this stage so."""
    if patch.projector is None:
        return
    try:
        camera_from_corners(patch.projector.at, patch.projector.corners, (patch.stage.width, patch.stage.depth),
            patch.projector.aspect)  # fmt: skip
    except PersonError as error:
        yield InvalidEntry(str(error), "projector", "corners")


def _check_characters(patch: Patch) -> Iterator[InvalidEntry]:
    groups = {group.name.casefold() for group in patch.group}
    for index, each in enumerate(patch.character):
        for name in each.groups:
            if name.casefold() not in groups:
                yield InvalidEntry(
                    f"character {each.name!r}: no group is called {name!r}", "character", index, "groups"
                )
        if each.dancers and max(each.dancers) > patch.dancer_count:
            words = f"character {each.name!r}: there is no dancer {max(each.dancers)}, only {patch.dancer_count}"
            yield InvalidEntry(words, "character", index, "dancers")


def _check_elements(patch: Patch) -> Iterator[InvalidEntry]:
    for number, element in enumerate(patch.element, start=1):
        if patch.loop_measures is not None and element.measure >= patch.loop_measures + 1:
            yield InvalidEntry(
                f"element {number} begins in measure {element.measure:g}, but the score begins again after "
                f"{patch.loop_measures} (loop_measures): it would never begin",
                *("element", number - 1, "measure"),
            )


def _check_leaders(patch: Patch) -> Iterator[InvalidEntry]:
    names = {group.name: group for group in patch.group}
    for index, group in enumerate(patch.group):
        if group.like is None:
            continue
        leader, place = names.get(group.like), ("group", index, "like")
        if leader is None or leader is group:
            yield InvalidEntry(f"group {group.name!r} is like {group.like!r}: no other group is called that", *place)
        elif leader.like is not None:
            words = f"group {group.name!r}: name {leader.like!r}, which {leader.name!r} is like itself"
            yield InvalidEntry(words, *place)


def _check_facings(patch: Patch) -> Iterator[InvalidEntry]:
    names = tuple(group.name.casefold() for group in patch.group)
    for index, group in enumerate(patch.group):
        try:
            parse_facing(group.facing, dancers=patch.dancer_count + patch.reserve, groups=names)
        except PersonError as error:
            yield InvalidEntry(f"group {group.name!r}: {error}", "group", index, "facing")


def _check_regroups(patch: Patch) -> Iterator[InvalidEntry]:
    names = {group.name.casefold() for group in patch.group}
    for index, section in enumerate(patch.regroup):
        if section.group.casefold() not in names:
            words = f"regroup in measure {section.measure}: no group is called {section.group!r}"
            yield InvalidEntry(words, "regroup", index, "group")
