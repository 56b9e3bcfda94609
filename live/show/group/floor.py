"""Floor: how large the stage is now. What steers takes a new size at once; the border that is seen moves there.

Nobody is put anywhere: agents are bent to the new edges, and dancers come after them with the steps that they have.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.base.stage_snapshot import FLOOR_MARGIN
from live.show.patch.section_stage import StageSection

Float64 = npt.NDArray[np.float64]

SMALLEST: Final = 2.0
"""No stage is narrower or shallower than this [m], as in the patch."""
LARGEST: Final = 2.0
"""Nor more than so many times as large as the patch's; and of the floor that is drawn around that ..."""
DARK: Final = 0.5
"""... at least so much [m] stays outside."""
ROOM: Final = 0.8
"""Each dancer needs so much of it [m²]."""
MEASURES: Final = 2.0
"""Measures in which the border comes in, or half of them to go out: measures that are decided already end first ..."""
PACE: Final = 0.12
"""... and no more of it than this [m] in a beat on the average: about as fast as steps travel."""


class Floor:
    """The size of one show's stage. Call `resize` for events and `tick` once a tick."""

    def __init__(self, stage: StageSection) -> None:
        self._patch = np.array([stage.width / 2, stage.depth / 2])
        self.half: Float64 = self._patch.copy()
        """Half width and half depth [m] as whatever steers takes them, shape (2,): the same array as long as the show
        lasts."""
        self.border: Float64 = self._patch.copy()
        """The same of what is seen."""
        self._from, self._began, self._ends = self._patch.copy(), -math.inf, -math.inf

    @property
    def largest(self) -> Float64:
        """Half width and half depth [m] that can be asked for, shape (2,)."""
        return np.asarray(np.minimum(LARGEST * self._patch, self._patch + (FLOOR_MARGIN - DARK)))

    @property
    def fitting(self) -> Float64 | None:
        """Half width and half depth [m] into which what the patch has made must be fitted; None: it has its room."""
        return None if (self.half >= self._patch).all() else self.half.copy()

    def resize(self, width: float, depth: float, *, dancers: int, beat: float, beats_per_measure: float) -> bool:
        """The stage shall have this `width` and `depth` [m] from `beat` on; False if it has.

        PersonError if that is more floor than there is, or less than so many `dancers` need.
        """
        half = np.array([width / 2, depth / 2])
        if (half > self.largest + 1e-9).any() or not (half >= SMALLEST / 2 - 1e-9).all():
            most = 2.0 * self.largest
            raise PersonError(
                f"the stage cannot be {width:g} x {depth:g} m", f"from 2 x 2 to {most[0]:g} x {most[1]:g} m of it can"
            )
        if width * depth < ROOM * dancers and (half < self._patch).any():
            raise PersonError(
                f"{dancers} dancers have no room on {width:g} x {depth:g} m", f"they need {ROOM * dancers:.1f} m²"
            )
        if (half == self.half).all():
            return False
        self._from[:] = self.border
        far = np.abs(half - self.border).max()
        least = MEASURES * beats_per_measure * (1.0 if (half < self.border).any() else 0.5)
        self._began, self._ends = beat, beat + max(least, float(far) / PACE)
        self.half[:] = half
        return True

    def tick(self, beat: float) -> None:
        """The border moves on to where it is at `beat`: gently at the beginning and at the end."""
        if beat >= self._ends:
            self.border[:] = self.half
            return
        share = max(beat - self._began, 0.0) / (self._ends - self._began)
        self.border[:] = self._from + (self.half - self._from) * (share * share * (3.0 - 2.0 * share))
