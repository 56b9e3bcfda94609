"""Score: what the patch puts at measures, handed out when they come (T132)."""

from live.show.patch import Patch
from live.show.sections.element import ElementSection
from live.show.sections.segment import RegroupSection, SegmentSection


class Score:
    """The elements and segments of a patch by their measures; after `loop_measures` they come again."""

    def __init__(self, patch: Patch) -> None:
        self._patch = patch
        self._loop = patch.loop_measures

    def _place(self, measure: int) -> int:
        return measure if self._loop is None else measure % self._loop

    def elements(self, measure: int) -> list[ElementSection]:
        """Elements whose first measure is `measure` (from 0); a start within it is theirs. Below 0 there are none."""
        if measure < 0:
            return []
        place = self._place(measure)
        return [section for section in self._patch.element if int(section.measure) - 1 == place]

    def regroups(self, measure: int) -> list[RegroupSection]:
        """Who changes the group with `measure` (from 0)."""
        if measure < 0:
            return []
        place = self._place(measure)
        return [section for section in self._patch.regroup if section.measure - 1 == place]

    def segments(self, measure: int) -> list[SegmentSection]:
        """Segments whose first measure is `measure` (from 0)."""
        if measure < 0:
            return []
        place = self._place(measure)
        return [section for section in self._patch.segment if section.measure - 1 == place]
