"""Pushing: who would touch within a moment, whatever was planned, is moved away; collisions come before feet."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.separation.path_separation_kernels import walk_on
from live.agents.separation.paths import PathParting
from live.clock.ticks import TICK
from live.show.dancers.coming import Coming
from live.show.dancers.root_correction import Carried

Float64 = npt.NDArray[np.float64]

PUSH_AHEAD: Final = np.array([0.1, 0.2, 0.3, 0.4])
"""Who will touch on straight ways from now to where they are in so many seconds is pushed apart: hips swing to and fro
within a beat, and who is far enough away at its end may have touched before."""
PUSH_MARGIN: Final = 0.1
PUSH_STIFFNESS: Final = 24.0


class Pushing:
    """Moves everything that is planned of those who are pushed."""

    def __init__(self, carried: Carried, coming: Coming, parting: PathParting) -> None:
        self._carried, self._coming, self._parting = carried, coming, parting
        count = len(carried.node)
        self._soon = np.zeros((len(PUSH_AHEAD), count, 2), np.float32)
        self._fractions = np.zeros(1 + len(PUSH_AHEAD))
        self.count = 0
        """Ticks times dancers in which feet had to yield so that nobody touched, since the start."""

    def tick(self, fraction: float, rate: float) -> None:
        """One tick at `fraction` of the measure, of which `rate` [1/s] passes."""
        carried, dancers = self._carried, self._carried.dancers
        paths, present, then, later = carried.paths, dancers.present, self._coming.paths, dancers.coming
        self._fractions[:] = fraction
        self._fractions[1:] += PUSH_AHEAD * rate
        walk_on(
            paths.path, paths.share, present.correction, present.aimed,
            then.path, then.share, later.correction, later.aimed,
            dancers.decided and self._coming.traced, dancers.graph.window,
            self._fractions, dancers.shown, self._soon,
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
