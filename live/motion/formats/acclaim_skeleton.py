"""AcclaimSkeleton: the bones of an ASF file as joints, each with the axes in which its motion is written."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

METRES_PER_INCH: Final = 0.0254


@dataclass(frozen=True, slots=True, eq=False)
class AcclaimSkeleton:
    """J joints: the root and one where each bone begins; a parent comes before its children. Lengths in file units.

    In the rest pose the joints' axes are the world's, so `offsets` are those of a BVH file. A bone's motion is written
    in its own axes, turned by `axes` C: its rotation relative to its parent is C M C⁻¹ (CMU: L = C⁻¹ M C B in rows).
    """

    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, -1 for the root, shape (J,)."""
    offsets: Float64
    """Where each joint lies from its parent (the parent's bone); the root's is its `position`, shape (J, 3)."""
    end_parents: Int32
    """Joints whose bones carry no other, shape (E,)."""
    end_offsets: Float64
    """Those bones, shape (E, 3)."""
    axes: Float64
    """C of each joint, unit quaternions, shape (J, 4)."""
    channels: tuple[str, ...]
    """Per joint a letter for each number of its AMC line: x y z = moved along, X Y Z = turned about that axis."""
    length: float
    """`length` of :units; CMU's 0.45 means 0.45 units to the inch."""

    @property
    def unit_m(self) -> float:
        """Metres per unit by the CMU's reading of `length`: inches, divided by it."""
        return METRES_PER_INCH / self.length
