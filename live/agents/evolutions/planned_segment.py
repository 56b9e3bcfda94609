"""A segment of a running plan, planned in pieces for certain dancers (T085)."""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import Intention, Procedural, Repertoire, Segment
from live.agents.evolutions.segment_start import MotionDraft, PlannedMotion, SegmentStart
from live.agents.evolutions.trajectory import GroupState
from live.agents.evolutions.trajectory_builder import plan_segment
from live.base.arrays import Float32

MAX_LATE_CALLS: Final = 96
"""Maximum calls of late planning work after a segment has begun: about a second and a half at one per tick."""
PAIRS_PER_CALL: Final = 2500
"""Pairs of dancers that are processed in about half a millisecond."""
DANCERS_PER_PIECE: Final = 200
"""Until slots are assigned, one small piece is done per this many dancers at a time. Otherwise the largest groups
would have no slots when the measure begins."""


class PlannedSegment:
    """One segment from one starting state: planned in pieces, then evaluated at beats."""

    def __init__(self, segment: Segment, intention: Intention, repertoire: Repertoire, departure: SegmentStart) -> None:
        self.segment = segment
        self.intention = intention
        self.departure = departure
        self.dancers = departure.dancer_indices
        """Indices of its dancers, shape (D,)."""
        self.controlled = np.ones(len(self.dancers), np.uint8)
        """1 for dancers that it still controls, shape (D,)."""
        self.motion: PlannedMotion | None = None
        """The result, or its draft during collision repair. None before, and always None for `Procedural`."""
        self._draft = MotionDraft()
        self._actual_start: npt.NDArray[np.floating] | None = None
        self._late_calls_left = MAX_LATE_CALLS
        self._pieces: Pieces[PlannedMotion] | None = None
        if not isinstance(intention, Procedural):
            self._pieces = plan_segment(segment, intention, repertoire, departure, self._draft)

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
        return self.done or self.motion is not None

    def work(self) -> None:
        """Do one piece of planning."""
        if self._pieces is None:
            return
        try:
            next(self._pieces)
            if self.motion is None:
                self.motion = self._draft.motion
        except StopIteration as stop:
            self.motion, self._pieces = stop.value, None
            if self._actual_start is not None:
                self._shift_start()

    def make_usable(self) -> None:
        """Plan until every dancer has a goal, of thousands not the best one."""
        self._draft.urgent = True
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
        self._late_calls_left -= late
        if self._late_calls_left < 0:
            self._pieces = None
        count = max(len(self.dancers), 1)
        seating = 0 if self.usable else count // DANCERS_PER_PIECE
        for _ in range(max(1, PAIRS_PER_CALL // count**2, seating)):
            self.work()

    def start_from(self, position: npt.NDArray[np.floating]) -> None:
        """Move the starts of the paths to the actual places `position` (D, 2) [m] of the dancers; the ends stay."""
        self._actual_start = np.asarray(position, np.float64)
        self._shift_start()

    def reshape(self, motion: PlannedMotion) -> None:
        """Take other ways of its dancers, planned together with those of other segments (T147)."""
        self.motion = motion
        self._shift_start()

    def _shift_start(self) -> None:
        if self.motion is None or self._actual_start is None:
            return
        moved = self.motion.locomotion
        missing = self._actual_start - moved.path_knots[:, 0]
        fading = np.linspace(1.0, 0.0, moved.path_knots.shape[1])
        if not moved.path_knots[:, 0].size or float(np.abs(missing).max()) == 0.0:
            return
        ways: Float32 = np.ascontiguousarray(moved.path_knots + missing[:, None] * fading[None, :, None], np.float32)
        self.motion = replace(self.motion, locomotion=replace(moved, path_knots=ways))

    def write(self, beat: float, out: GroupState) -> None:
        """Fill the rows of its dancers; dancers moved by elements become free."""
        if self.motion is not None:
            self.motion.locomotion.write(beat, self.dancers, self.controlled, out)
        elif self.done:
            out.controlled[self.dancers[self.controlled == 1]] = 0
