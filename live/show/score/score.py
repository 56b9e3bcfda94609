"""Score: what the patch puts at measures, handed out when they come (T132)."""

from collections.abc import Iterable
from typing import Any, Final

from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import AtSection, RegroupSection, SegmentSection, SignalSection
from live.show.score.playhead import END, Place, Playhead, Stretch

WHOLE: Final = ""
"""The name of the one section of a score without sections."""


KINDS: Final = ("element", "segment", "regroup", "at", "signal")


class Written:
    """What is written in a score, which no measure changes: entries by place, and the parts of the groups."""

    def __init__(self) -> None:
        self.entries: dict[str, dict[tuple[int, int], list[Any]]] = {}
        """By kind, section and measure."""
        self.made: dict[int, Any] = {}
        """Sequences that are made already, for groups that have the same."""
        self.parts: list[Any] = []
        """What the parts of the groups have: see `live.show.score.part`."""


def stretches_of(patch: Patch) -> tuple[Stretch, ...]:
    """The sections of a patch for its playhead; one, of `loop_measures`, if it has none."""
    if not patch.section:
        return (Stretch(WHOLE, patch.loop_measures, 1, 0),)
    names = [section.name.casefold() for section in patch.section]

    def after(index: int) -> int:
        then = patch.section[index].then
        if then is None:
            return (index + 1) % len(names)
        return END if then.casefold() == "end" else names.index(then.casefold())

    return tuple(
        Stretch(section.name, section.measures, 0 if section.wait else section.repeat, after(index))
        for index, section in enumerate(patch.section)
    )


class Score:
    """The entries of a patch by their places: found without looking through the others."""

    def __init__(self, patch: Patch, playhead: Playhead | None = None) -> None:
        """`playhead` says where the score is; left out: one of its own that nobody leads elsewhere."""
        self.playhead = Playhead(stretches_of(patch)) if playhead is None else playhead
        self._sections = {stretch.name.casefold(): i for i, stretch in enumerate(self.playhead.stretches)}
        self.written = Written()
        for kind in KINDS:
            self.written.entries[kind] = self._by_place(getattr(patch, kind))

    def take_patch(self, fresh: "Score") -> None:
        """Take over the entries of another score; where it is, the playhead knows."""
        self._sections, self.written = fresh._sections, fresh.written

    def place_of(self, section: str | None, measure: float) -> tuple[int, int] | None:
        """Section and measure (from 0) of an entry of the patch; None for one that never comes."""
        if section is not None:
            index = self._sections.get(section.casefold())
            return None if index is None else (index, int(measure) - 1)
        try:
            place = self.playhead.of_written(int(measure) - 1)
        except ValueError:
            return None
        return place.section, place.measure

    def _by_place(self, entries: Iterable[Any]) -> dict[tuple[int, int], list[Any]]:
        found: dict[tuple[int, int], list[Any]] = {}
        for entry in entries:
            place = None if entry.measure is None else self.place_of(entry.section, entry.measure)
            if place is not None:
                found.setdefault(place, []).append(entry)
        return found

    def _of(self, kind: str, measure: int) -> list[Any]:
        """What begins with `measure` (from 0): nothing before the first, after the end, or while the score is held."""
        if measure < 0 or not self.playhead.entered(measure):
            return []
        place = self.playhead.place(measure)
        return self.written.entries[kind].get((place.section, place.measure), [])

    def place(self, measure: int) -> Place:
        """Where the score is in `measure` (from 0)."""
        return self.playhead.place(measure)

    def elements(self, measure: int) -> list[ElementSection]:
        """Elements whose first measure is `measure` (from 0); a start within it is theirs. Below 0 there are none."""
        return self._of("element", measure)

    def regroups(self, measure: int) -> list[RegroupSection]:
        """Who changes the group with `measure` (from 0)."""
        return self._of("regroup", measure)

    def segments(self, measure: int) -> list[SegmentSection]:
        """Segments whose first measure is `measure` (from 0)."""
        return self._of("segment", measure)

    def calls(self, measure: int) -> list[AtSection]:
        """What is called within `measure` (from 0)."""
        return self._of("at", measure)

    def signals(self, measure: int) -> list[SignalSection]:
        """Signals that the score gives within `measure` (from 0)."""
        return self._of("signal", measure)
