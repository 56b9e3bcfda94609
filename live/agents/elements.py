"""Procedural elements: attractors, repulsors, spreaders, each in force for some measures (T105, T109, T132)."""

from dataclasses import dataclass, replace

import numpy as np

from live.base.stage_view import ATTRACTOR, ELEMENT_CAPACITY, REPULSOR, SPREADER, StageView

FADE_BEATS = 1.0
"""Beats over which an element fades in after its start and out before its end."""


@dataclass(frozen=True, slots=True)
class Element:
    """One element: kind, stage position (x, z) [m], strength, and the beats between which it acts."""

    kind: int
    x: float = 0.0
    z: float = 0.0
    strength: float = 1.0
    start_beat: float = 0.0
    end_beat: float = 0.0

    def level(self, beat: float) -> float:
        """0 to 1: how far it has faded in, or out again, at `beat`."""
        into, left = beat - self.start_beat, self.end_beat - beat
        if into < 0.0 or left <= 0.0:
            return 0.0
        return min(1.0, into / FADE_BEATS, left / FADE_BEATS)


class ElementField:
    """The elements in force, as arrays for the steering kernel; bounded, the oldest gives way."""

    def __init__(self, capacity: int = ELEMENT_CAPACITY) -> None:
        self._elements: list[Element] = []
        self._capacity = capacity
        self.kind = np.zeros(capacity, np.int32)
        self.position = np.zeros((capacity, 2), np.float32)
        self.strength = np.zeros(capacity, np.float32)
        """Strength times level at the beat of the last `refresh`, shape (capacity,)."""
        self.level = np.zeros(capacity, np.float32)
        self.count = 0

    def add(self, element: Element) -> None:
        """Put one more element in force; at most `capacity` at a time, the oldest gives way."""
        if len(self._elements) >= self._capacity:
            self._elements.pop(0)
        self._elements.append(element)

    def move(self, old: Element, new: Element) -> Element:
        """Put `new` in the place of `old`, without fading in anew (a dragged attractor stays one); returns it.

        If `old` is no longer in force, `new` begins for itself.
        """
        for row, element in enumerate(self._elements):
            if element is old:
                self._elements[row] = replace(new, start_beat=min(old.start_beat, new.start_beat))
                return self._elements[row]
        self.add(new)
        return new

    def clear(self, beat: float) -> None:
        """Let every element fade out from `beat` on, from the level it has; those yet to come never begin."""
        self._elements = [
            replace(
                e, start_beat=e.start_beat - FADE_BEATS, end_beat=min(e.end_beat, beat + e.level(beat) * FADE_BEATS)
            )
            for e in self._elements
            if e.level(beat) > 0.0
        ]

    @property
    def elements(self) -> tuple[Element, ...]:
        """The elements that have not ended, oldest first."""
        return tuple(self._elements)

    def refresh(self, beat: float) -> None:
        """Fill the arrays for `beat`; elements that have ended are forgotten."""
        if self._elements and any(e.end_beat <= beat for e in self._elements):
            self._elements = [e for e in self._elements if e.end_beat > beat]
        self.count = 0
        for element in self._elements:
            level = element.level(beat)
            if level <= 0.0:
                continue
            row = self.count
            self.kind[row] = element.kind
            self.position[row, 0] = element.x
            self.position[row, 1] = element.z
            self.level[row] = level
            self.strength[row] = level * element.strength
            self.count += 1

    def show(self, view: StageView) -> None:
        """Copy what acts now into the drawing snapshot."""
        view.element_count = self.count
        view.element_kind[: self.count] = self.kind[: self.count]
        view.element_position[: self.count] = self.position[: self.count]
        view.element_level[: self.count] = self.level[: self.count]


__all__ = ["ATTRACTOR", "FADE_BEATS", "REPULSOR", "SPREADER", "Element", "ElementField"]
