"""What improvisation does to the group's motion: with each phrase something is drawn and called."""

import numpy as np

from live.control.events.events import ControlEvent
from live.show.patch.improvise import ImproviseSection
from live.show.score.score import Score

SALT = 0x307
"""Keeps this chance apart from that of steps."""


class ImprovisedMotion:
    """The `[[improvise.motion]]` of a patch; chance comes of (seed, section, turn, table, measure)."""

    def __init__(self, sections: tuple[ImproviseSection, ...], score: Score, seed: int) -> None:
        self._score, self._seed = score, seed
        self._tables: list[tuple[int, int, int, int | None, ImproviseSection]] = []
        for index, section in enumerate(sections):
            place = score.place_of(section.section, section.measure)
            if place is not None and section.motion:
                end = place[1] + section.measures if section.measures is not None else None
                self._tables.append((index, place[0], place[1], end, section))

    def take_patch(self, fresh: "ImprovisedMotion") -> None:
        """Draw from what another patch has."""
        self._tables = fresh._tables

    def calls(self, measure: int, time: float) -> list[ControlEvent]:
        """What is called at the line of `measure` (from 0), with which a phrase may begin."""
        if measure < 0 or not self._score.playhead.entered(measure):
            return []
        place = self._score.place(measure)
        called: list[ControlEvent] = []
        for index, section, begin, end, asked in self._tables:
            if place.section != section or place.measure < begin or (end is not None and place.measure >= end):
                continue
            if (place.measure - begin) % asked.phrase:
                continue
            chance = np.random.default_rng((self._seed, SALT, place.section + 1, place.turn, index, place.measure))
            weights = np.cumsum([item.weight for item in asked.motion])
            row = int(np.searchsorted(weights, float(chance.random()) * weights[-1], side="right"))
            item = asked.motion[min(row, len(asked.motion) - 1)]
            event = None if item.call is None else item.event(time)
            if isinstance(event, ControlEvent):
                called.append(event)
        return called
