"""Landing: feet that a cut sends to other places are lifted on the way, and not dragged there over the floor."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.pose.inertialization_kernels import LONGEST
from live.motion.pose.legs_kernels import CLEAR, ROUND

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.floating]

STAYS: Final = 0.12
"""A foot that is no farther than this [m] from its new place does not go there: it is held where it comes down."""
ARRIVED: Final = 0.05
"""One that is on its way is held where it is nearer than this [m] to its new place."""
HIGHEST: Final = 0.06
"""Others are lifted so far [m]."""
UP: Final = 0.1
DOWN: Final = (0.22, 0.36)
"""It is up within so many seconds, and comes down between these."""


class Landing:
    """Which feet of A dancers are on their way to where a cut sent them."""

    def __init__(self, dancer_count: int) -> None:
        self.lift: Float32 = np.zeros((dancer_count, 2), np.float32)
        """How high each foot is lifted on its way [m], 0 for feet that stay or have none, shape (A, 2)."""

    def begin(self, rows: Int32, way: Floats) -> None:
        """The dancers `rows` (n,) are cut: their feet have a `way` (n, 2) [m] to go."""
        self.lift[rows] = np.where(way < STAYS, 0.0, HIGHEST)

    def near(self, away: Floats) -> Bool:
        """Which feet may be held that are `away` (A, 2) [m] from their places, (A, 2)."""
        return np.asarray(away < np.where(self.lift > 0.0, ARRIVED, STAYS))

    def clear(self, feet: Float32, age: Float32) -> None:
        """Lift them, by the columns CLEAR and ROUND of `feet` (A, 2, 9), `age` (A,) [s] after the cut."""
        up = _ease(age / UP) * _ease((DOWN[1] - age) / (DOWN[1] - DOWN[0])) * (age < LONGEST)
        lifted = self.lift * up[:, None].astype(np.float32)
        feet[:, :, CLEAR] = np.maximum(feet[:, :, CLEAR], lifted)
        feet[:, :, ROUND] = np.maximum(feet[:, :, ROUND], 0.3 * lifted)


def _ease(t: Floats) -> Floats:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
