"""The beat network's trained weights, read from the package; the core is given them as a value."""

import io
from functools import cache
from importlib.resources import files

import numpy as np

from live.clock.tracking.network import Weights


@cache
def beat_weights() -> Weights:
    """The weights that come with the engine (`training/` makes them). Raises ValueError where they are damaged."""
    data = files("live.clock.hearing").joinpath("weights.npz").read_bytes()
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            return Weights.of({name: arrays[name] for name in arrays.files if name != "recipe"})
    except Exception as error:  # zipfile, zlib and numpy each have errors of their own for what is damaged
        raise ValueError(f"the beat network's weights cannot be read: {error}") from error
