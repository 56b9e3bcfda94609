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
    """The end of an element, after which nothing moves its dancers for some measures."""

    element: ElementSection
    begin: int
    """Measure in which it begins, from 0."""
    end: int
    """Measure with whose line it is over, from 0."""
    who: Bool
    """Its dancers, (A,)."""
    next: int
    """Measure in which something could follow: `end`, or 0 if the score begins again there."""
    quiet: float
    """Measures until something moves one of them again, inf: nothing does."""
    room: int
    """Measures that a segment may last there, `MOST_MEASURES` at most."""


@dataclass(frozen=True, slots=True, eq=False)
class _Mover:
    """What moves dancers during some measures, from 0."""

    begin: float
    end: float
    who: Bool | None
    """(A,); None: anybody."""


class ScoreEnds:
    """The ends of a score's elements, and what moves dancers after them."""

    def __init__(self, patch: Patch, casting: Casting, position: npt.NDArray[np.floating]) -> None:
        """`position` (A, 2) [m]: where dancers stand at the beginning."""
        self._patch, self._casting, self._position = patch, casting, position
        self._length = score_length(patch)
        self._loop = self._length if not patch.section else None
        self._selected: dict[str, Bool | None] = {}
        movers = list(self._all_movers())
        if self._loop is not None:  # what comes first follows what comes last
            loop = self._loop
            movers += [replace(one, begin=one.begin + loop, end=one.end + loop) for one in movers]
        self._movers = sorted(movers, key=lambda one: one.begin)

    def of(self, element: ElementSection) -> OpenEnd | None:
        """Return the end of an element. None for selections by place, as only the dance shows whom they mean, and if no
        place of the score follows."""
        length, loop, who = self._length, self._loop, self._select(element.group)
        begin, last = entry_span(self._patch, element)
        end = math.ceil(last - 1e-9)
        if who is None or end > (loop or end) or (self._patch.section and end >= (length or 0)):
            return None
        there = end % loop if loop is not None else end
        quiet = max(self._next_begin(last, who) - end, 0.0)
        room = min(quiet, _measures_left(self._patch, there), MOST_MEASURES)
        return OpenEnd(element, int(begin), end, who, there, quiet, int(room))

    def open(self) -> list[OpenEnd]:
        """Return the elements after which nothing moves their dancers for some measures, the first to end first; of
        those that end together for the same dancers only one."""
        found: dict[tuple[int, bytes], OpenEnd] = {}
        for element in self._patch.element:
            if entry_span(self._patch, element)[1] > MAX_MEASURES:
                continue
            one = self.of(element)
            if one is not None and one.quiet >= QUIET_MEASURES:
                found.setdefault((one.end, one.who.tobytes()), one)
        return sorted(found.values(), key=lambda one: one.end)

    def _next_begin(self, last: float, who: Bool) -> float:
        """Return the measure in which something moves one of the dancers after `last`: before it if it does already."""
        for one in self._movers:
            if one.end > last + 1e-9 and (one.who is None or (one.who & who).any()):
                return one.begin
        return math.inf

    def _select(self, group: str) -> Bool | None:
        """Return the dancers of a selection, (A,); None if it depends on their places."""
        if group not in self._selected:
            by_place = self._casting.depends_on_places(group)
            self._selected[group] = None if by_place else self._casting.select(group, self._position)
        return self._selected[group]

    def _all_movers(self) -> Iterator[_Mover]:
        patch = self._patch
        moving: tuple[SegmentSection | ElementSection, ...] = (*patch.segment, *patch.element)
        for entry in moving:
            yield _Mover(*entry_span(patch, entry), self._select(entry.group))
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
    ends = ScoreEnds(show.patch, show.casting, show.state.position).open()
    ends = [one for one in ends if np.count_nonzero(one.who & show.motion.present) >= FEWEST_DANCERS]
    told = ends[:MAX_HINTS]
    places = agent_places(show, {measure for one in told for measure in (one.begin, one.end)})
    hints = []
    for one in told:
        who = one.who & show.motion.present
        standing = standing_of(show, who, places[one.end], places[one.begin], measures=one.room)
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


def next_segment(patch: Patch, one: OpenEnd, formation: NextFormation) -> dict[str, str | int]:
    """Return the table of a segment into a formation after the end of an element."""
    section, measure = one.element.section, one.next + 1
    if section is not None:
        first = span_of(patch, section, 1, None).first
        size = next(each.measures for each in patch.section if each.name.casefold() == section.casefold())
        section, measure = (section, measure - first) if one.next < first + size else (None, measure)
    table: dict[str, str | int] = {} if section is None else {"section": section}
    table |= {"measure": measure, "measures": formation.measures}
    if one.element.group.strip() not in EVERYONE:
        table["group"] = one.element.group
    return table | {"formation": formation.formation}


def _segment_lines(patch: Patch, one: OpenEnd, count: int, formation: NextFormation) -> str:
    """Return the segment as it is written in a patch."""
    pairs = "a pair" if formation.meetings == 1 else f"{formation.meetings} pairs"
    meetings = "" if not formation.meetings else f", {pairs} would meet on straight ways"
    lines = [
        f"[[segment]]  # {formation.total_m / count:.1f} m for each, {formation.longest_m:.1f} m at most{meetings}",
        *(f"{key} = {_text(value)}" for key, value in next_segment(patch, one, formation).items()),
    ]
    return "\n".join(f"    {line}" for line in lines)


def _text(value: str | int) -> str:
    """Return a value as it is written in TOML."""
    return json.dumps(value, ensure_ascii=False)
