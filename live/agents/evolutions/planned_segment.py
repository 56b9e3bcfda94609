"""A segment of a running plan, planned in pieces for certain dancers (T085)."""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import Intention, Procedural, Repertoire, Segment
from live.agents.evolutions.segment_start import Departure, Draft, Journey
from live.agents.evolutions.trajectory import Float32, Setting
from live.agents.evolutions.trajectory_builder import travelling

PATIENCE: Final = 96
"""Maximum calls of late planning work after a segment has begun: about a second and a half at one per tick."""
PAIRS: Final = 2500
"""Pairs of dancers that are processed in about half a millisecond."""
SEATED: Final = 60
"""Until slots are assigned, one small piece is done per this many dancers at a time. Otherwise the largest groups
would have no slots when the measure begins."""


class Motion:
    """One segment from one starting state: planned in pieces, then evaluated at beats."""

    def __init__(self, segment: Segment, intention: Intention, repertoire: Repertoire, departure: Departure) -> None:
        self.segment = segment
        self.intention = intention
        self.departure = departure
        self.who = departure.numbers
        """Indices of its dancers, shape (D,)."""
        self.keep = np.ones(len(self.who), np.uint8)
        """1 for dancers that it still controls, shape (D,)."""
        self.journey: Journey | None = None
        """The result, or its draft during collision repair. None before, and always None for `Procedural`."""
        self._draft = Draft()
        self._from: npt.NDArray[np.floating] | None = None
        self._left = PATIENCE
        self._pieces: Pieces[Journey] | None = None
        if not isinstance(intention, Procedural):
            self._pieces = travelling(segment, intention, repertoire, departure, self._draft)

    @property
    def begin(self) -> float:
        """The beat from which it controls its dancers."""
        return self.departure.begin

    @property
    def done(self) -> bool:
        """Whether planning is complete."""
        return self._pieces is None

    @property
    def usable(self) -> bool:
        """Whether every dancer's goal is set; collision repair may still be running."""
        return self.done or self.journey is not None

    def work(self) -> None:
        """Do one piece of planning."""
        if self._pieces is None:
            return
        try:
            next(self._pieces)
            if self.journey is None:
                self.journey = self._draft.journey
        except StopIteration as stop:
            self.journey, self._pieces = stop.value, None
            if self._from is not None:
                self._start()

    def make_usable(self) -> None:
        """Plan until every dancer has a goal."""
        while not self.usable:
            self.work()

    def finish(self) -> None:
        """Complete the planning."""
        while not self.done:
            self.work()

    def work_some(self, *, late: bool = False) -> None:
        """Do about half a millisecond of work: pieces take longer with more pairs of dancers.

        `late`: the segment has begun already. After `PATIENCE` calls the plan stays as it is.
        """
        self._left -= late
        if self._left < 0:
            self._pieces = None
        count = max(len(self.who), 1)
        seating = 0 if self.usable else count // SEATED
        for _ in range(max(1, PAIRS // count**2, seating)):
            self.work()

    def start_from(self, position: npt.NDArray[np.floating]) -> None:
        """Move the starts of the paths to the actual places `position` (D, 2) [m] of the dancers; the ends stay."""
        self._from = np.asarray(position, np.float64)
        self._start()

    def _start(self) -> None:
        if self.journey is None or self._from is None:
            return
        moved = self.journey.locomotion
        missing = self._from - moved.ways[:, 0]
        fading = np.linspace(1.0, 0.0, moved.ways.shape[1])
        if not moved.ways[:, 0].size or float(np.abs(missing).max()) == 0.0:
            return
        ways: Float32 = np.ascontiguousarray(moved.ways + missing[:, None] * fading[None, :, None], np.float32)
        self.journey = replace(self.journey, locomotion=replace(moved, ways=ways))

    def write(self, beat: float, out: Setting) -> None:
        """Fill the rows of its dancers; dancers moved by elements become free."""
        if self.journey is not None:
            self.journey.locomotion.write(beat, self.who, self.keep, out)
        elif self.done:
            out.under[self.who[self.keep == 1]] = 0
