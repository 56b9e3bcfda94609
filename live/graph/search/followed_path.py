"""A path as it is danced: clips, mixtures and turns of all measures, and how near they come to the targets."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class FollowedPath:
    """What is danced over M measures, and how near to the targets it comes."""

    node: Int32
    """Shape (M,)."""
    take: Int32
    """Node of the other take that is mixed in, NO_TAKE for none, shape (M,)."""
    share: Float64
    """How much of it, shape (M,)."""
    turn: Float64
    """Turn on the carrying foot in each measure [rad], shape (M,)."""
    correction: Float64
    """What moves the hips besides [m], shape (M, 2)."""
    place: Float64
    """Where the hips are at the end of each measure [m], shape (M, 2)."""
    error: Float64
    """How far that is from the target [m], shape (M,)."""
    heading_error: Float64
    """How far the body faces from where it should [rad], absolute, shape (M,)."""
    wrong: Bool
    """Measures of another step than the wanted one, shape (M,)."""
