"""BeatEstimate: one beat as a tracker of sound hears it."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Samples = npt.NDArray[np.float32]
"""Sound of one channel, shape (n,), full scale = 1."""


@dataclass(frozen=True, slots=True)
class BeatEstimate:
    """One beat as a tracker hears it; `position` and `heard` are seconds from the first sample fed."""

    position: float
    """Where the beat lies [s]; it may lie ahead of what was fed: a prediction."""
    period: float
    """Seconds to the next beat."""
    confidence: float
    """How sure the tracker is, 0 to 1."""
    heard: float
    """How much had been fed when the estimate was made [s]."""
    beat: int = -1
    """Which beat of its measure it is, from 0; -1 where the tracker does not know."""
    beats_per_measure: int = 0
    """0 where the tracker does not know."""
    replaces: float = math.nan
    """The position under which the same beat was named before, where this corrects it [s]; else NaN."""
