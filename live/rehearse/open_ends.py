"""Hints of `live check`: elements after which nothing moves their dancers, and formations that could come next.

Measures are those of the written score, every section once.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.next_formations import MOST_MEASURES, NextFormation, rank_formations
from live.base.arrays import Bool
from live.control.registry.element_controls import ELEMENT_CONTROLS
from live.show.group.agent_run import agent_places
from live.show.group.casting import EVERYONE, Casting
from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import SegmentSection
from live.show.score.section_span import entry_span, score_length, span_of
from live.show.show import Show
from live.show.view.next_formations import FEWEST_DANCERS, known_formations, standing_of

QUIET_MEASURES: Final = 4
"""Measures after an element within which something has to follow."""
MAX_HINTS: Final = 4
"""Most hints."""
MAX_MEASURES: Final = 128
"""Elements that end later are not looked at: agents take a second or two for so many measures."""
SUGGESTED: Final = 2
"""Formations that a hint suggests."""
MOVING_CALLS: Final = frozenset(
    ("/dance/formation", "/dance/travel", "/dance/pause", "/dance/launch", *(one.address for one in ELEMENT_CONTROLS))
)
"""Controls that move dancers."""


@dataclass(frozen=True, slots=True, eq=False)
class OpenEnd:
    """An element after which nothing moves its dancers for some measures."""

    element: ElementSection
    begin: int
    """Measure in which it begins, from 0."""
    end: int
    """Measure with whose line it is over, from 0."""
    who: Bool
    """Its dancers, (A,)."""
    next: int
    """Measure in which something could follow: `end`, or 0 if the score begins again there."""
    room: int
    """Measures that it may last."""


@dataclass(frozen=True, slots=True, eq=False)
class _Mover:
    """What moves dancers during some measures, from 0."""

    begin: float
    end: float
    who: Bool | None
    """(A,); None: anybody."""


def open_ends(patch: Patch, casting: Casting, position: npt.NDArray[np.floating]) -> list[OpenEnd]:
    """Return the elements of a score after which nothing moves their dancers, the first to end first; of those that
    end together for the same dancers only one.

    Elements for selections by place are left out. `position` (A, 2) [m]: where dancers stand at the beginning.
    """
    length = score_length(patch)
    loop = length if length is not None and not patch.section else None
    movers = list(_movers(patch, casting, position))
    if loop is not None:  # what comes first follows what comes last
        movers += [replace(one, begin=one.begin + loop, end=one.end + loop) for one in movers]
    found: dict[tuple[int, bytes], OpenEnd] = {}
    for element in patch.element:
        if casting.depends_on_places(element.group):
            continue
        begin, last = entry_span(patch, element)
        end, who = math.ceil(last - 1e-9), casting.select(element.group, position)
        there = end % loop if loop is not None else end
        if end > MAX_MEASURES or end > (loop or end) or (patch.section and end >= (length or 0)):
            continue
        following = min(
            (one.begin for one in movers if one.end > last + 1e-9 and (one.who is None or (one.who & who).any())),
            default=math.inf,
        )
        if following >= end + QUIET_MEASURES:
            room = min(following - end, _measures_left(patch, there), MOST_MEASURES)
            found.setdefault((end, who.tobytes()), OpenEnd(element, int(begin), end, who, there, int(room)))
    return sorted(found.values(), key=lambda one: one.end)


def _movers(patch: Patch, casting: Casting, position: npt.NDArray[np.floating]) -> Iterator[_Mover]:
    """Yield what moves dancers."""
    moving: tuple[SegmentSection | ElementSection, ...] = (*patch.segment, *patch.element)
    for entry in moving:
        by_place = casting.depends_on_places(entry.group)
        yield _Mover(*entry_span(patch, entry), None if by_place else casting.select(entry.group, position))
    calls: list[tuple[str | None, int, int | None]] = [
        (one.section, one.measure, 1) for one in patch.at if one.call in MOVING_CALLS
    ]
    calls += [
        (one.section, one.measure, one.measures)
        for one in patch.improvise
        if any(motion.call in MOVING_CALLS for motion in one.motion)
    ]
    for section, measure, measures in calls:
        span = span_of(patch, section, measure, measures)
        yield _Mover(span.first + span.begin, span.first + span.end, None)


def _measures_left(patch: Patch, measure: int) -> float:
    """Return how many measures there are from `measure` (from 0) to the end of its section, or of the score."""
    end = 0
    for section in patch.section:
        end += section.measures
        if measure < end:
            return end - measure
    return math.inf if patch.loop_measures is None else patch.loop_measures - measure


def next_formation_hints(show: Show) -> list[str]:
    """Return a hint for each element after which nothing moves its dancers, with formations that could come next, as
    lines for the patch. `show` is fresh, and cannot be used again."""
    ends = open_ends(show.patch, show.casting, show.state.position)
    ends = [one for one in ends if np.count_nonzero(one.who & show.motion.present) >= FEWEST_DANCERS]
    told = ends[:MAX_HINTS]
    places = agent_places(show, {measure for one in told for measure in (one.begin, one.end)})
    hints = []
    for one in told:
        who = one.who & show.motion.present
        standing = replace(standing_of(show, who, places[one.end], places[one.begin]), measures=one.room)
        ranked = rank_formations(standing, known_formations(show, int(who.sum())))
        hints.append(_hint(show.patch, one, int(who.sum()), ranked[:SUGGESTED]))
    more = len(ends) - MAX_HINTS
    return hints if more <= 0 else [*hints, f"... and {more} more elements after which nothing moves their dancers"]


def _hint(patch: Patch, one: OpenEnd, count: int, ranked: tuple[NextFormation, ...]) -> str:
    where = f"measure {one.end + 1}" if one.next == one.end else "end of the score"
    words = (
        f"{where}: after the {one.element.kind!r} of measure {one.begin + 1}, {count} dancers stand where it left them"
    )
    if not ranked:
        return f"{words}; no formation that the show knows is within reach in {_measures(one.room)}"
    suggestions = "\n".join(_segment_lines(patch, one, count, each) for each in ranked)
    return f"{words}; what could come next:\n{suggestions}"


def _measures(count: int) -> str:
    return "a measure" if count == 1 else f"{count} measures"


def _segment_lines(patch: Patch, one: OpenEnd, count: int, formation: NextFormation) -> str:
    """Return a segment into a formation, as it is written in a patch."""
    section, measure = one.element.section, one.next + 1
    if section is not None:
        first = span_of(patch, section, 1, None).first
        size = next(each.measures for each in patch.section if each.name.casefold() == section.casefold())
        section, measure = (section, measure - first) if one.next < first + size else (None, measure)
    meetings = "" if not formation.meetings else f", {formation.meetings} pairs would meet on straight ways"
    lines = [
        f"[[segment]]  # {formation.total_m / count:.1f} m for each, {formation.longest_m:.1f} m at most{meetings}",
        *([] if section is None else [f"section = {_text(section)}"]),
        f"measure = {measure}",
        f"measures = {formation.measures}",
        *([] if one.element.group.strip() in EVERYONE else [f"group = {_text(one.element.group)}"]),
        f"formation = {_text(formation.formation)}",
    ]
    return "\n".join(f"    {line}" for line in lines)


def _text(words: str) -> str:
    """Return a text as it is written in TOML."""
    return json.dumps(words, ensure_ascii=False)
