"""Claims: who is told two things at once by a score, and calls of steps that are not there; told before it plays."""

from collections.abc import Callable, Iterable
from typing import Final

import numpy as np

from live.base.errors import PersonError, named
from live.control.group_events import DefineFormation
from live.control.registry import REGISTRY
from live.graph.motion_graph import MotionGraph
from live.show.casting import EVERYONE, Casting
from live.show.patch import Patch
from live.show.programme_steps import find_step
from live.show.score import Score
from live.show.score_check import calls_of
from live.show.sections.segment import RegroupSection, SegmentSection

STEPS_OF: Final = ("/dance/step", "/dance/now")
"""Controls whose first value is a step."""


class Claims:
    """Who is meant by the words of a score, as bits: a bit for each dancer, 0 where that depends on places."""

    def __init__(self, patch: Patch, casting: Casting) -> None:
        self._casting = casting
        self._groups = {section.name.casefold(): 1 << index for index, section in enumerate(patch.group)}
        self._moves = bool(patch.regroup)
        self._known: dict[str, int] = {}
        self._somewhere = np.zeros((len(casting.group), 2))

    def bits(self, words: str) -> int:
        """The dancers that `words` mean wherever they stand. PersonError for words that mean nobody there is."""
        folded = words.casefold().strip()
        if folded not in self._known:
            self._known[folded] = self._meant(words, folded)
        return self._known[folded]

    def _meant(self, words: str, folded: str) -> int:
        who = self._casting.select(words, self._somewhere)
        if self._moves:  # dancers change their groups: of other words than these nobody knows whom they mean when
            return (1 << len(self._groups)) - 1 if folded in EVERYONE else self._groups.get(folded, 0)
        if self._casting.means_places(words):
            return 0
        return int.from_bytes(np.packbits(who, bitorder="little").tobytes(), "little")


def check_segments(segments: Iterable[SegmentSection], score: Score, claims: Claims) -> None:
    """PersonError for two segments that have the same dancers at the same time: words that mean places are left out."""
    running: dict[int, list[tuple[int, int, int, int]]] = {}
    for index, segment in enumerate(segments):
        place = score.place_of(segment.section, segment.measure)
        if place is None:
            continue
        bits = claims.bits(segment.group)
        running.setdefault(place[0], []).append((place[1], place[1] + segment.measures, index, bits))
    for rows in running.values():
        rows.sort()
        active: list[tuple[int, int, int, int]] = []
        for row in rows:
            active = [other for other in active if other[1] > row[0]]
            clash = next((other for other in active if other[3] & row[3]), None)
            if clash is not None:
                raise PersonError(
                    f"segment {row[2] + 1} begins in measure {row[0] + 1} with dancers whom segment {clash[2] + 1} has "
                    f"until the end of measure {clash[1]}",
                    f"measures = {row[0] - clash[0]} for the other one, or another group"
                    if row[0] > clash[0]
                    else "leave one of them out, or give it another group",
                    ("segment", row[2], "measure"),
                )
            active.append(row)


def check_regroups(regroups: Iterable[RegroupSection], score: Score, casting: Casting) -> None:
    """PersonError for a dancer whom two groups claim at one measure."""
    claimed: dict[tuple[int, int], list[tuple[np.ndarray, str]]] = {}
    somewhere = np.zeros((len(casting.group), 2))
    for index, section in enumerate(regroups):
        place = score.place_of(section.section, section.measure)
        if place is None or casting.means_places(section.dancers):
            continue
        who = casting.select(section.dancers, somewhere)
        for other, group in claimed.setdefault(place, []):
            twice = np.flatnonzero(other & who)
            if len(twice) and group != section.group.casefold():
                raise PersonError(
                    f"groups {group!r} and {section.group!r} both claim dancer {int(twice[0]) + 1} in measure "
                    f"{section.measure}",
                    "leave the dancer out of one of them",
                    ("regroup", index, "dancers"),
                )
        claimed[place].append((who, section.group.casefold()))


def check_calls(patch: Patch, graph: MotionGraph) -> None:
    """PersonError for a step that the score or a cue calls and that is not there."""
    for call, values, place in calls_of(patch):
        if call in STEPS_OF and place[0] != "react":
            try:
                find_step(graph, str(values[0]))
            except ValueError as error:
                raise PersonError(f"call {call}: {error}", None, place) from None


def check_called(patch: Patch, claims: Claims, find: Callable[[str], object]) -> None:
    """PersonError for a call of the score or of a cue that names a group or a formation which is not there.

    `find` takes a formation's name or words. Formations that a call of the patch itself defines are there.
    """
    texts = [row for row in calls_of(patch) if any(isinstance(value, str) for value in row[1])]  # names are texts
    made = [(REGISTRY.call(call, values, 0.0, "patch"), call, place) for call, values, place in texts]
    defined = {event.name.casefold().strip() for event, _, _ in made if isinstance(event, DefineFormation)}
    for event, call, place in made:
        group, formation = getattr(event, "group", None), getattr(event, "formation", None)
        with named(f"call {call}", place):
            if isinstance(group, str):
                claims.bits(group)
            if isinstance(formation, str) and formation.casefold().strip() not in defined:
                find(formation)
