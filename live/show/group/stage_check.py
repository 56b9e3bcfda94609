"""Check of an edited stage: who would stand outside it, or in an obstacle."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np

from live.agents.groups.roster import Line, mirror_places
from live.base.arrays import Bool, Float64
from live.base.errors import PersonError
from live.show.group.group_motion import AGENT_RADIUS
from live.show.group.stage_area import AREA_PER_DANCER
from live.show.patch.patch import Patch
from live.show.patch.section_score import SegmentSection
from live.show.patch.section_stage import ObstacleSection, StageSection

ROUNDING: Final = 1e-6
"""Distance [m] that counts as nothing."""


def stage_faults(show: Any, former: Patch) -> list[PersonError]:
    """Return whom the patch of a fresh `show` leaves without their places by another stage or other obstacles than in
    `former`: all entries, each with its place in the patch. What was so in `former` is no fault."""
    patch: Patch = show.patch
    if (patch.stage, patch.obstacle) == (former.stage, former.obstacle):
        return []
    return [*_floor_faults(patch, former), *_segment_faults(show, former), *_start_faults(show, former)]


def _floor_faults(patch: Patch, former: Patch) -> Iterator[PersonError]:
    """Yield the fault of a stage that is too small for all its dancers."""
    needed, stage = AREA_PER_DANCER * patch.dancer_count, patch.stage
    if stage.width * stage.depth < needed <= former.stage.width * former.stage.depth:
        yield PersonError(
            f"{patch.dancer_count} dancers have no room on {stage.width:g} x {stage.depth:g} m",
            f"they need {needed:.1f} m²", ("stage",),
        )  # fmt: skip


def _segment_faults(show: Any, former: Patch) -> Iterator[PersonError]:
    """Yield the segments whose formation, path or evolution leaves the stage, or has places in an obstacle."""
    patch: Patch = show.patch
    known: dict[tuple[str, int], Float64] = {}
    for index, section in enumerate(patch.segment):
        if section.path is not None:
            path = _mirrored(section, np.array(section.path, np.float64))
            if (outside(path, patch.stage) & ~outside(path, former.stage)).any():
                yield PersonError(
                    f"the path leads outside the stage of {_size(patch.stage)}",
                    f"a stage of at least {_needed(path)}, or a shorter path", ("segment", index, "path"),
                )  # fmt: skip
        if section.evolution is not None:
            ways = _mirrored(section, np.asarray(show.motion.evolutions.ways(section.evolution), np.float64)).reshape(
                -1, 2
            )
            if (outside(ways, patch.stage) & ~outside(ways, former.stage)).any():
                yield PersonError(
                    f"the ways of {section.evolution!r} lead outside the stage of {_size(patch.stage)}",
                    f"a stage of at least {_needed(ways)}, or one like it into a smaller region",
                    ("segment", index, "evolution"),
                )
        if section.formation is None:
            continue
        who = show.motion.casting.select(section.group, show.motion.state.position) & show.motion.present
        key = section.formation, int(who.sum())
        if key not in known:
            known[key] = show.motion.evolutions.formation(*key).slots
        where = ("segment", index, "formation")
        yield from _place_faults(_mirrored(section, known[key]), section.formation, patch, former, where)


def _start_faults(show: Any, former: Patch) -> Iterator[PersonError]:
    """Yield the groups whose starting places are in an obstacle; at the start all stand on the stage."""
    patch: Patch = show.patch
    first = 0
    for index, group in enumerate(patch.group):
        own = np.asarray(show.motion.state.position[first : first + group.dancers], np.float64)
        first += group.dancers
        yield from _obstacle_faults(own, f"{group.name!r} would begin", patch, former, ("group", index, "formation"))


def _place_faults(
    places: Float64, formation: str, patch: Patch, former: Patch, where: tuple[str | int, ...]
) -> Iterator[PersonError]:
    """Yield the faults of a formation's places (S, 2) [m]."""
    gone = outside(places, patch.stage) & ~outside(places, former.stage)
    if gone.any():
        yield PersonError(
            f"{_dancers(gone)} of {formation!r} would stand outside the stage of {_size(patch.stage)}",
            f"a stage of at least {_needed(places)}, or a smaller formation", where,
        )  # fmt: skip
    yield from _obstacle_faults(places, f"{formation!r} would stand", patch, former, where)


def _obstacle_faults(
    places: Float64, words: str, patch: Patch, former: Patch, where: tuple[str | int, ...]
) -> Iterator[PersonError]:
    """Yield the obstacles in which places (S, 2) [m] would be that were free before."""
    before = _blocked(places, former.obstacle)
    for item in patch.obstacle:
        hit = _blocked(places, (item,)) & ~before
        if hit.any():
            yield PersonError(
                f"{_dancers(hit)} of {words} in {item.name!r}",
                f"put {item.name!r} elsewhere, make it smaller, or move the formation", where,
            )  # fmt: skip


def outside(places: Float64, stage: StageSection) -> Bool:
    """Whether each of the places (S, 2) [m] lies outside a stage, shape (S,)."""
    half = np.array([stage.width / 2, stage.depth / 2]) + ROUNDING
    return np.asarray((np.abs(places) > half).any(axis=1))


def _blocked(places: Float64, items: Iterable[ObstacleSection]) -> Bool:
    """Whether a dancer at each of the places (S, 2) [m] would touch an obstacle or a wall, shape (S,)."""
    found = np.zeros(len(places), np.bool_)
    for item in items:
        start = np.array(item.at, np.float64)
        way = np.zeros(2) if item.wall_to is None else np.array(item.wall_to, np.float64) - start
        share = np.clip((places - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
        reach = AGENT_RADIUS + (item.radius if item.wall_to is None else 0.0)
        found |= np.hypot(*(places - start - share[:, None] * way).T) < reach - ROUNDING
    return found


def _mirrored(section: SegmentSection, places: Float64) -> Float64:
    if section.mirror is False:
        return places
    return mirror_places(places, Line() if section.mirror is True else Line.through(*section.mirror))


def _needed(places: Float64) -> str:
    width, depth = np.ceil(20.0 * np.abs(places).max(axis=0) - 1e-6) / 10.0
    return f"{width:g} x {depth:g} m"


def _size(stage: StageSection) -> str:
    return f"{stage.width:g} x {stage.depth:g} m"


def _dancers(who: Bool) -> str:
    count = int(np.count_nonzero(who))
    return "a dancer" if count == 1 else f"{count} dancers"


def refusal(faults: Sequence[PersonError]) -> PersonError:
    """Return one error for several: the first, and the places of the others."""
    first = faults[0]
    others = "".join(f"; {fault.message}" for fault in faults[1:])
    return PersonError(first.message + others, first.remedy, first.key_path)
