"""Random generators for variation, one for each purpose and measure."""

from enum import IntEnum

import numpy as np


class Purpose(IntEnum):
    """Purposes of random draws, each with independent generators."""

    MEASURE = 1
    """Warp, amplitude and takes of one measure."""
    AMPLITUDE = 2
    """Amplitudes that change slowly over the sequence (T059)."""
    DRIFT = 3
    """The warp over the whole sequence (T056)."""
    FOLLOW = 4
    """The pad that follows a launched one."""
    EXPRESSION = 5
    """When each dancer's first blink, breath and glance are."""
    SHOT = 6
    """The camera's next shot."""


def generator_for(seed: int, purpose: Purpose, measure: int) -> np.random.Generator:
    """Return the generator of a purpose and measure, or another number. Measures before the first downbeat are below
    0."""
    return np.random.default_rng([seed, purpose, measure % (1 << 32)])
