"""Segments as patches and controls say them, as values for the plan (T085, T095-T103)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.intention import (
    By,
    Evolve,
    Follow,
    Hold,
    Intention,
    Matching,
    Pause,
    Trajectory,
    Way,
)
from live.agents.evolutions.matching import Cost
from live.agents.evolutions.orientation import Facing, Orientation
from live.agents.evolutions.segment import Segment
from live.agents.evolutions.start_delays import Order, Ripple
from live.agents.groups.relations import Line
from live.base.errors import PersonError
from live.control.events import events
from live.show.group.casting import EVERYONE
from live.show.group.elements_of import points_of
from live.show.patch.segment import SegmentSection

Float64 = npt.NDArray[np.float64]
SegmentEvent = events.Evolve | events.Travel | events.Pause


def matching_of(word: str) -> Matching:
    """Who goes where, by a patch's or control's word; PersonError for others."""
    if word == "number":
        return Matching(by=By.ID)
    try:
        return Matching(cost=Cost(word))
    except ValueError:
        raise PersonError(f"match {word[:40]!r} is unknown", f"there are: {', '.join(Cost)}, number") from None


def everyone(words: str) -> str:
    """The expression of a plan for the words of a patch or control: "*" is everybody."""
    return "" if words.strip() in EVERYONE else words.casefold().strip()


def segment_of_section(section: SegmentSection, *, start: int, formation: str, path: str) -> Segment:
    """The segment of the score from measure `start` (from 0) on; its formation and path under these names."""
    orientation = Orientation(
        Facing(section.facing or ("tangent" if section.path is not None else "linear")),
        tuple(math.radians(heading) for heading in section.headings_deg),
    )
    intention: Intention
    matching = matching_of(section.match)
    if section.hold:
        intention = Hold(formation, matching)
    elif section.formation is not None:
        intention = Evolve(formation, matching, Way(section.way), orientation, section.soft)
    elif section.path is not None:
        follow = Follow.FILE if section.single_file else Follow.SHIFTED
        intention = Trajectory(path, follow, orientation=orientation, soft=section.soft)
    else:
        intention = Pause()
    mirror = Line() if section.mirror is True else None
    if isinstance(section.mirror, tuple):
        mirror = Line.through(*section.mirror)
    return Segment(
        intention,
        everyone(section.group),
        start,
        section.measures,
        Ripple(section.ripple_beats, Order(section.ripple_from)),
        mirror,
        section.beats_later,
    )


def segment_of_event(event: SegmentEvent, *, start: int, formation: str, path: str) -> tuple[Segment, Float64 | None]:
    """The segment that a control asks for, with the name its formation has in the plan, and the way it draws, to be
    kept as `path`; PersonError if it draws none."""
    group, measures = everyone(event.group), max(1, math.ceil(event.measures - 1e-9))
    match event:
        case events.Evolve():
            evolve = Evolve(formation, matching_of(event.match))
            return Segment(evolve, group, start, measures, Ripple(event.ripple)), None
        case events.Travel():
            follow = Follow.FILE if event.single_file else Follow.SHIFTED
            return Segment(Trajectory(path, follow), group, start, measures), np.array(points_of(event.points))
        case events.Pause():
            return Segment(Pause(), group, start, measures), None
