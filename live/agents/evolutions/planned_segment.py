"""A segment that has been, or is being, worked out for certain dancers; what a running plan holds (T085)."""

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
"""How often work may still be done after a segment has begun: at once a tick for a second and a half."""
PAIRS: Final = 2500
"""Pairs of dancers that are looked at in about half a millisecond."""
SEATED: Final = 60
"""While it is not known yet who goes where, a small piece is done at a time for each so many dancers: else the largest
groups would not know it when the measure begins."""


class Motion:
    """One segment from one departure: worked out in pieces, then asked for places at beats."""

    def __init__(self, segment: Segment, intention: Intention, repertoire: Repertoire, departure: Departure) -> None:
        self.segment = segment
        self.intention = intention
        self.departure = departure
        self.who = departure.numbers
        """Indices of its dancers, shape (D,)."""
        self.keep = np.ones(len(self.who), np.uint8)
        """1 for dancers it still holds, shape (D,)."""
        self.journey: Journey | None = None
        """What came out; the draft of it while ways are mended; None before, and for `Procedural` always."""
        self._draft = Draft()
        self._from: npt.NDArray[np.floating] | None = None
        self._left = PATIENCE
        self._pieces: Pieces[Journey] | None = None
        if not isinstance(intention, Procedural):
            self._pieces = travelling(segment, intention, repertoire, departure, self._draft)

    @property
    def begin(self) -> float:
        """The beat from which it holds its dancers."""
        return self.departure.begin

    @property
    def done(self) -> bool:
        """Whether it is worked out."""
        return self._pieces is None

    @property
    def usable(self) -> bool:
        """Whether it is known where everybody goes; her way may still be mended."""
        return self.done or self.journey is not None

    def work(self) -> None:
        """Do one piece."""
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
        """Do what is left until everybody knows where she goes."""
        while not self.usable:
            self.work()

    def finish(self) -> None:
        """Do all that is left."""
        while not self.done:
            self.work()

    def work_some(self, *, late: bool = False) -> None:
        """Do about half a millisecond's work: pieces take the longer the more pairs of dancers there are.

        `late`: it has begun already; what takes too long then stays as it is, and steering sees to the rest.
        """
        self._left -= late
        if self._left < 0:
            self._pieces = None
        count = max(len(self.who), 1)
        seating = 0 if self.usable else count // SEATED
        for _ in range(max(1, PAIRS // count**2, seating)):
            self.work()

    def start_from(self, position: npt.NDArray[np.floating]) -> None:
        """The dancers stand at `position` (D, 2) [m], not where they were foreseen: ways begin there, ends stay."""
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
        """Fill the rows of its dancers; elements' dancers become free."""
        if self.journey is not None:
            self.journey.locomotion.write(beat, self.who, self.keep, out)
        elif self.done:
            out.under[self.who[self.keep == 1]] = 0
