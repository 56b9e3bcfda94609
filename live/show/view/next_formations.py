"""What could come next: the formations that a show knows, ranked for dancers whom an element has left where they stand.

It only reads the show, so nothing of it is in snapshots and journals.
"""

import json
from collections.abc import Iterator
from itertools import islice
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.elements.element import Element
from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import FormationLike, Places
from live.agents.evolutions.next_formations import MOST_MEASURES, NextFormation, Standing, rank_in_pieces
from live.agents.formations.formation_notation import parse_formation
from live.base.arrays import Bool, Float32, Float64
from live.base.element_kinds import KIND_NAMES
from live.base.errors import PersonError
from live.show.audience.audience import SOURCE
from live.show.desk.pad import SHAPES
from live.show.group.division import dancer_words
from live.show.group.formations import cached_formation, fit_slots
from live.show.show import Show

NOTATIONS: Final = (*SHAPES, "circle inside", "ellipse inside")
"""Formations by notation that are suggested besides those of the show; many dancers have room inside."""
MOST_OWN: Final = 32
"""Most formations of the show that are ranked."""
MOST_TOLD: Final = 4
"""Most formations that are suggested."""
FEWEST_DANCERS: Final = 2
"""So many dancers make a formation."""
TOLD_MEASURES: Final = 8
"""A suggestion that nobody follows stays for so many measures."""
NAMES: Final = {number: name for name, number in KIND_NAMES.items()}


def known_formations(show: Show, count: int) -> Iterator[FormationLike]:
    """Yield the formations of a show for `count` dancers, its own ones first; impossible ones are left out."""
    own = show.motion.evolutions.formations
    specs = [(formation.name, formation.spec, formation.seed) for formation in islice(own.values(), MOST_OWN)]
    specs += [(words, parse_formation(words), show.seed) for words in NOTATIONS if words not in own]
    fit = show.motion.stage_area.fit_size
    for name, spec, seed in specs:
        try:
            found = cached_formation(spec, count, seed)
        except PersonError:
            continue
        slots: Float64 = found.slots if fit is None else fit_slots(found.slots, fit)
        yield Places(name, slots, found.heading, found.marks)


def standing_of(
    show: Show,
    who: Bool,
    position: npt.NDArray[np.floating],
    before: npt.NDArray[np.floating] | None = None,
    *,
    present: Bool | None = None,
    measures: int = MOST_MEASURES,
) -> Standing:
    """Return the dancers `who` (A,) of a show, at `position` (A, 2) [m].

    `before` (A, 2) [m]: where they stood before. `present` (A,): who is on the stage, None: as it is now. `measures`
    within which a formation has to be reached.
    """
    rows = np.flatnonzero(who)
    reach = np.broadcast_to(show.scheduler.step_reach() + show.patch.locomotion.correction_m, who.shape)
    half_width, half_depth = show.motion.stage_area.half.tolist()
    others = (show.motion.on_stage if present is None else present) & ~who
    return Standing(
        position=position[rows].astype(np.float64),
        group=show.casting.group[rows],
        attributes=tuple(show.casting.roster.attributes[row] for row in rows.tolist()),
        reach=reach[rows].astype(np.float64),
        radius=show.motion.model.radius[rows].astype(np.float64),
        half_stage=(half_width, half_depth),
        before=None if before is None else before[rows].astype(np.float64),
        others=position[others].astype(np.float64),
        measures=measures,
        measure_beats=float(show.desk.beats),
    )


def rank_known(show: Show, standing: Standing) -> Pieces[tuple[NextFormation, ...]]:
    """Rank the formations of a show for these dancers, in pieces of a millisecond or two."""
    return (yield from rank_in_pieces(standing, known_formations(show, len(standing.position))))


class NextFormations:
    """What could follow an element of a running show that has just ended. Call `frame` after each frame; it does one
    piece of the ranking. Thread: the show's.

    Elements of phones are left out. A suggestion ends when something else moves one of its dancers.
    """

    def __init__(self, show: Show) -> None:
        self._show = show
        self._acting: dict[
            int, tuple[Element, Float32]
        ] = {}  # by identity, with the places at their beginnings, (A, 2)
        self._who: Bool = np.zeros(0, np.bool_)
        self._after = ""
        self._until = 0
        self._pieces: Pieces[tuple[NextFormation, ...]] | None = None
        self._ranked: tuple[NextFormation, ...] = ()

    def start(self) -> None:
        """Nothing to open."""

    def stop(self) -> None:
        """Nothing to close."""

    def status(self) -> dict[str, Any]:
        """Return what is suggested now, see `facts`."""
        return self.facts() or {}

    def frame(self) -> None:
        """Look for elements that have ended, or do one piece of the ranking."""
        ended = self._ended()
        if ended:
            self._begin(ended)
            return
        if not self._after:
            return
        if self._show.span.number >= self._until or self._is_followed():
            self._clear()
        elif self._pieces is not None:
            try:
                next(self._pieces)
            except StopIteration as stop:
                self._ranked, self._pieces = stop.value[:MOST_TOLD], None

    def _ended(self) -> list[tuple[Element, Float32]]:
        """Return the elements that ended since the last frame, with the places at their beginnings."""
        show, beat = self._show, self._show.timeline.beat_at(self._show.time)
        former, now, fresh = self._acting, dict[int, tuple[Element, Float32]](), list[Element]()
        for element in show.motion.elements.in_force:
            if element.fair or element.source.startswith(SOURCE) or element.start_beat > beat:
                continue
            known = former.pop(id(element), None)
            if known is None:
                fresh.append(element)
            else:
                now[id(element)] = known
        for element in fresh:
            same = (key for key, (one, _) in former.items() if (one.source, one.kind) == (element.source, element.kind))
            moved = next(same, None)  # it was dragged, or fades out early
            now[id(element)] = element, show.state.position.copy() if moved is None else former.pop(moved)[1]
        self._acting = now
        return [one for one in former.values() if one[0].end_beat <= beat + 1e-6]

    def _begin(self, ended: list[tuple[Element, Float32]]) -> None:
        """Begin to rank what could follow elements that have ended together."""
        show = self._show
        self._clear()
        self._who = np.zeros(len(show.state.position), np.bool_)
        for element, _ in ended:
            self._who |= show.motion.elements.dancers_of(element)
        self._who &= show.motion.on_stage
        if np.count_nonzero(self._who) < FEWEST_DANCERS or self._is_followed():
            return
        element, before = ended[-1]
        self._after, self._until = NAMES.get(element.kind, ""), show.span.number + TOLD_MEASURES
        self._pieces = rank_known(show, standing_of(show, self._who, show.state.position, before))

    def _clear(self) -> None:
        self._after, self._pieces, self._ranked = "", None, ()

    def _is_followed(self) -> bool:
        """Whether a segment or another element moves one of the dancers."""
        motion = self._show.motion
        moved = [motion.elements.dancers_of(element) for element, _ in self._acting.values()]
        moved += [who for _, who in motion.evolutions.moved()]
        return any((self._who & who).any() for who in moved)

    def facts(self) -> dict[str, Any] | None:
        """Return what could come next: after which kind of element, for whom, and pads for `/dance/launch`, the best
        one first. None if nothing is suggested."""
        if not self._ranked:
            return None
        pads = [
            {"pad": f"formation {one.formation}", "name": one.formation, "measures": one.measures}
            for one in self._ranked
        ]
        return {"after": self._after, "who": self._words(), "pads": pads}

    def _words(self) -> str:
        """Return the dancers as a selection: everybody, a group, or numbers."""
        casting, present = self._show.casting, self._show.motion.on_stage
        if (self._who | ~present).all():
            return "*"
        for index, group in enumerate(self._show.patch.group):
            if np.array_equal(self._who & present, (casting.group == index) & present):
                return group.name
        return dancer_words((np.flatnonzero(self._who) + 1).tolist())

    def text(self) -> str:
        """Return the facts as JSON; empty if nothing is suggested."""
        facts = self.facts()
        return "" if facts is None else json.dumps(facts, ensure_ascii=False)
