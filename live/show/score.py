"""Score: what the patch puts at measures, handed out when they come (T132)."""

from collections.abc import Iterable
from typing import Final, Protocol, TypeVar

from live.show.patch import Patch
from live.show.playhead import END, Place, Playhead, Stretch
from live.show.sections.element import ElementSection
from live.show.sections.score import AtSection, SignalSection
from live.show.sections.segment import RegroupSection, SegmentSection

WHOLE: Final = ""
"""The name of the one section of a score without sections."""


class _Placed(Protocol):
    @property
    def measure(self) -> float | None: ...
    @property
    def section(self) -> str | None: ...


Entry = TypeVar("Entry", bound=_Placed)


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
        self._element = self._by_place(patch.element)
        self._segment = self._by_place(patch.segment)
        self._regroup = self._by_place(patch.regroup)
        self._at = self._by_place(patch.at)
        self._signal = self._by_place(patch.signal)

    def take_patch(self, fresh: "Score") -> None:
        """Take over the entries of another score; where it is, the playhead knows."""
        for name in ("_sections", "_element", "_segment", "_regroup", "_at", "_signal"):
            setattr(self, name, getattr(fresh, name))

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

    def _by_place(self, entries: Iterable[Entry]) -> dict[tuple[int, int], list[Entry]]:
        found: dict[tuple[int, int], list[Entry]] = {}
        for entry in entries:
            place = None if entry.measure is None else self.place_of(entry.section, entry.measure)
            if place is not None:
                found.setdefault(place, []).append(entry)
        return found

    def _of(self, entries: dict[tuple[int, int], list[Entry]], measure: int) -> list[Entry]:
        """What begins with `measure` (from 0): nothing before the first, after the end, or while the score is held."""
        if measure < 0 or not self.playhead.entered(measure):
            return []
        place = self.playhead.place(measure)
        return entries.get((place.section, place.measure), [])

    def place(self, measure: int) -> Place:
        """Where the score is in `measure` (from 0)."""
        return self.playhead.place(measure)

    def elements(self, measure: int) -> list[ElementSection]:
        """Elements whose first measure is `measure` (from 0); a start within it is theirs. Below 0 there are none."""
        return self._of(self._element, measure)

    def regroups(self, measure: int) -> list[RegroupSection]:
        """Who changes the group with `measure` (from 0)."""
        return self._of(self._regroup, measure)

    def segments(self, measure: int) -> list[SegmentSection]:
        """Segments whose first measure is `measure` (from 0)."""
        return self._of(self._segment, measure)

    def calls(self, measure: int) -> list[AtSection]:
        """What is called within `measure` (from 0)."""
        return self._of(self._at, measure)

    def signals(self, measure: int) -> list[SignalSection]:
        """Signals that the score gives within `measure` (from 0)."""
        return self._of(self._signal, measure)
