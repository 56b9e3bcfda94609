"""Pushing: who would touch within a moment, whatever was planned, is moved away; collisions come before feet."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.parting.paths.kernels import walk_on
from live.agents.parting.paths.paths import MOMENTS, PathParting
from live.clock.ticks import TICK
from live.show.carried import Carried
from live.show.coming import Coming

Float64 = npt.NDArray[np.float64]

PUSH_AHEAD: Final = 0.4
"""Who will touch in this time [s] is pushed apart."""
PUSH_MARGIN: Final = 0.085
PUSH_STIFFNESS: Final = 24.0


class Pushing:
    """Moves everything that is planned of those who are pushed."""

    def __init__(self, carried: Carried, coming: Coming, parting: PathParting) -> None:
        self._carried, self._coming, self._parting = carried, coming, parting
        self._soon, self._before = np.zeros((2, len(carried.node), 2), np.float32)
        self.count = 0
        """Ticks times dancers in which feet had to yield so that nobody touched, since the start."""

    def tick(self, fraction: float, rate: float) -> None:
        """One tick at `fraction` of the measure, of which `rate` [1/s] passes."""
        carried, dancers = self._carried, self._carried.dancers
        paths, present, last = carried.paths, dancers.present, MOMENTS - 1
        beyond = fraction + PUSH_AHEAD * rate - 1.0
        then, danced, place = paths, present, min(beyond, 0.0) + 1.0
        if beyond > 0.0 and dancers.decided and self._coming.traced:
            then, danced, place = self._coming.paths, dancers.coming, beyond
        walk_on(
            paths.path, paths.share, present.correction, present.aimed, fraction * last,
            then.path, then.share, danced.correction, danced.aimed, place * last,
            dancers.shown, self._before, self._soon,
        )  # fmt: skip
        moved = self._parting.push(dancers.shown, self._soon, margin=PUSH_MARGIN, stiffness=PUSH_STIFFNESS, dt=TICK)
        if moved is not None:
            self._move(moved)

    def _move(self, moved: Float64) -> None:
        """Everybody's measures, and all that is known of them, lie elsewhere by `moved` (A, 2) [m]."""
        carried, coming, dancers = self._carried, self._coming, self._carried.dancers
        carried.motion.partners.move(moved, dancers.shown)
        carried.keep_on_stage(moved, dancers.shown.astype(np.float64), np.maximum(carried.room, np.abs(dancers.shown)))
        moved[np.abs(moved) < 1e-7] = 0.0
        self.count += int(np.count_nonzero(moved.any(axis=1)))
        for danced in dancers.measures():
            danced.placement[:, :2] += moved
        for place in (carried.begin, carried.end, coming.end):
            place += moved
        for paths in (carried.paths, coming.paths):
            paths.path += moved[:, None].astype(np.float32)
