"""Score: the elements that the patch puts at measures, and those called live, as elements with beats (T132)."""

from live.agents.elements import ATTRACTOR, REPULSOR, SPREADER, Element
from live.show.patch import Patch
from live.show.sections.element import ElementSection

KINDS = {"attract": ATTRACTOR, "repel": REPULSOR, "spread": SPREADER}


class Score:
    """Hands out the patch's elements when their measure begins."""

    def __init__(self, patch: Patch) -> None:
        self._sections = patch.element
        self._loop = patch.loop_measures

    def beginning(self, measure: int) -> list[ElementSection]:
        """Elements whose first measure is `measure` (from 0); the fraction of a start is left to `placed`."""
        if measure < 0:  # before the music's first downbeat
            return []
        place = measure if self._loop is None else measure % self._loop
        return [section for section in self._sections if int(section.measure) - 1 == place]


def placed(section: ElementSection, *, measure_beat: float, beats_per_measure: int) -> Element:
    """The element of a section whose measure begins at `measure_beat`."""
    start = measure_beat + (section.measure - int(section.measure)) * beats_per_measure
    return Element(
        KINDS[section.kind],
        section.at[0],
        section.at[1],
        section.strength,
        start,
        start + section.measures * beats_per_measure,
    )
