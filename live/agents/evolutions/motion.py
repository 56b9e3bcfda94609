"""A segment that has been, or is being, worked out for certain dancers; what a running plan holds (T085)."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.intention import Intention, Procedural, Repertoire
from live.agents.evolutions.journey import Departure, Journey, travelling
from live.agents.evolutions.locomotion import Float32, Setting
from live.agents.evolutions.pieces import Pieces
from live.agents.evolutions.segment import Segment


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
        """What came out; None while it is worked out, and for `Procedural` always."""
        self._pieces: Pieces[Journey] | None = None
        if not isinstance(intention, Procedural):
            self._pieces = travelling(segment, intention, repertoire, departure)

    @property
    def begin(self) -> float:
        """The beat from which it holds its dancers."""
        return self.departure.begin

    @property
    def done(self) -> bool:
        """Whether it is worked out."""
        return self._pieces is None

    def work(self) -> None:
        """Do one piece."""
        if self._pieces is not None:
            try:
                next(self._pieces)
            except StopIteration as stop:
                self.journey, self._pieces = stop.value, None

    def finish(self) -> None:
        """Do all that is left."""
        while not self.done:
            self.work()

    def start_from(self, position: npt.NDArray[np.floating]) -> None:
        """The dancers stand at `position` (D, 2) [m], not where they were foreseen: ways begin there, ends stay."""
        if self.journey is None:
            return
        moved = self.journey.locomotion
        missing = np.asarray(position, np.float64) - moved.ways[:, 0]
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
