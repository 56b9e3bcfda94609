"""Score entries of a patch, indexed by measure (T132)."""

import math
from collections.abc import Iterable
from typing import Any, Final

from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import AtSection, CurveSection, RegroupSection, SegmentSection, SignalSection
from live.show.score.playhead import END, Place, Playhead, SectionTiming

UNNAMED_SECTION: Final = ""
"""Name of the single section of a score without sections."""


KINDS: Final = ("element", "segment", "regroup", "at", "signal")


class WrittenScore:
    """The written score, which does not change over time: entries by place, and the parts of the groups."""

    def __init__(self) -> None:
        self.entries: dict[str, dict[tuple[int, int], list[Any]]] = {}
        """Entries by kind, then by section and measure."""
        self.built_sequences: dict[int, Any] = {}
        """Sequences already built, shared by groups that have the same."""
        self.parts: list[Any] = []
        """Data of the groups' parts: see `live.show.score.part`."""


def section_timings(patch: Patch) -> tuple[SectionTiming, ...]:
    """Return the sections of a patch for its playhead; one of `loop_measures` if it has none."""
    if not patch.section:
        return (SectionTiming(UNNAMED_SECTION, patch.loop_measures, 1, 0),)
    names = [section.name.casefold() for section in patch.section]

    def after(index: int) -> int:
        then = patch.section[index].then
        if then is None:
            return (index + 1) % len(names)
        return END if then.casefold() == "end" else names.index(then.casefold())

    return tuple(
        SectionTiming(section.name, section.measures, 0 if section.wait else section.repeat, after(index))
        for index, section in enumerate(patch.section)
    )


class Score:
    """Entries of a patch, looked up by place."""

    def __init__(self, patch: Patch, playhead: Playhead | None = None) -> None:
        """`playhead` gives the position in the score; None: a new one."""
        self.playhead = Playhead(section_timings(patch)) if playhead is None else playhead
        self._sections = {stretch.name.casefold(): i for i, stretch in enumerate(self.playhead.sections)}
        self.written = WrittenScore()
        for kind in KINDS:
            self.written.entries[kind] = self._by_place(getattr(patch, kind))
        self.written.entries["curve"] = self._curves_by_place(patch.curve)

    def apply_patch(self, fresh: "Score") -> None:
        """Adopt the entries of another score; the playhead keeps the position."""
        self._sections, self.written = fresh._sections, fresh.written

    def place_of(self, section: str | None, measure: float) -> tuple[int, int] | None:
        """Return section and measure (from 0) of a patch entry; None if it never comes."""
        if section is not None:
            index = self._sections.get(section.casefold())
            return None if index is None else (index, int(measure) - 1)
        try:
            place = self.playhead.place_of_written(int(measure) - 1)
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

    def _curves_by_place(self, curves: Iterable[CurveSection]) -> dict[tuple[int, int], list[Any]]:
        """Return the curves that run in each measure, with the measures since their beginning."""
        found: dict[tuple[int, int], list[Any]] = {}
        for curve in curves:
            place = self.place_of(curve.section, curve.measure)
            if place is not None:
                for measure in range(int(curve.points[0][0]), math.ceil(curve.points[-1][0] + 1e-9)):
                    found.setdefault((place[0], place[1] + measure), []).append((curve, measure))
        return found

    def _entries_at(self, kind: str, measure: int) -> list[Any]:
        """Return the entries that begin with `measure` (from 0); empty before the first, after the end, or while
        held."""
        if measure < 0 or not self.playhead.entered(measure):
            return []
        place = self.playhead.place(measure)
        return self.written.entries[kind].get((place.section, place.measure), [])

    def place(self, measure: int) -> Place:
        """Return the place of `measure` (from 0)."""
        return self.playhead.place(measure)

    def elements(self, measure: int) -> list[ElementSection]:
        """Return elements whose first measure is `measure` (from 0); each may start within it. Empty below 0."""
        return self._entries_at("element", measure)

    def regroups(self, measure: int) -> list[RegroupSection]:
        """Return the group changes at `measure` (from 0)."""
        return self._entries_at("regroup", measure)

    def segments(self, measure: int) -> list[SegmentSection]:
        """Return segments whose first measure is `measure` (from 0)."""
        return self._entries_at("segment", measure)

    def calls(self, measure: int) -> list[AtSection]:
        """Return the calls within `measure` (from 0)."""
        return self._entries_at("at", measure)

    def curves(self, measure: int) -> list[tuple[CurveSection, int]]:
        """Return the curves that run in `measure` (from 0), with the measures since they began."""
        return self._entries_at("curve", measure)

    def signals(self, measure: int) -> list[SignalSection]:
        """Return the signals that the score gives within `measure` (from 0)."""
        return self._entries_at("signal", measure)
