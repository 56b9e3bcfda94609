"""The motion of all dancers of a show on the stage, as it is written for other programs."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64, Int64
from live.motion import quaternion
from live.motion.clip import Clip


@dataclass(frozen=True, slots=True, eq=False)
class FigureMesh:
    """What is seen of a dancer: V corners of triangles in the rest pose, which joints move."""

    positions: Float32
    """[m], shape (V, 3)."""
    normals: Float32
    """Unit, shape (V, 3)."""
    joints: npt.NDArray[np.uint8]
    """Four joints that move each corner, shape (V, 4)."""
    weights: Float32
    """How much each of them does; rows sum to 1, shape (V, 4). Where it is 0 the joint is 0."""
    indices: npt.NDArray[np.uint16]
    """Three corners of each triangle, shape (3 T,)."""


@dataclass(frozen=True, slots=True, eq=False)
class DancerMotion:
    """One dancer: the poses in the places of the stage."""

    name: str
    """Such as "dancer 3"."""
    group: str
    """Name of the group to which the dancer belongs at the beginning."""
    clip: Clip
    """T samples, in stage coordinates."""
    present: Bool
    """At which of them the dancer is on the stage, (T,)."""
    colour: tuple[float, float, float] = (0.8, 0.6, 0.4)
    """Of the clothes, linear, 0 to 1."""
    figure: FigureMesh | None = None
    """The body; None: the bones. Dancers with the same body have the same object."""

    def presence_changes(self) -> Int64:
        """Return the samples from which the dancer is there or not: 0, then each at which this changes, (N,)."""
        return np.concatenate([[0], 1 + np.flatnonzero(np.diff(self.present))])

    def rotation_xyzw(self) -> Float32:
        """Return the local rotations in the order x, y, z, w, with signs that do not jump, (T, J, 4)."""
        signed = quaternion.align_signs(self.clip.rotation.astype(np.float64))
        return np.ascontiguousarray(quaternion.unit(signed)[..., [1, 2, 3, 0]], np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class StageFormation:
    """The places of a formation, as the largest group would stand in it."""

    name: str
    places: Float64
    """x and z [m], (S, 2)."""
    heading: Float64
    """As in `StageMotion.heading` [rad], (S,)."""


@dataclass(frozen=True, slots=True, eq=False)
class StageMotion:
    """All dancers, with samples at the same times."""

    name: str
    dancers: tuple[DancerMotion, ...]
    sample_rate: float
    """Samples per second."""
    begin: float
    """Time of the first sample in the show [s]."""
    beat: Float64
    """Beats since the first one at each sample, (T,)."""
    measure: Float64
    """The measure that is danced, from 1, (T,)."""
    formations: tuple[StageFormation, ...] = ()
    """The formations that the show knows by name."""

    @property
    def sample_count(self) -> int:
        """Number of samples T."""
        return len(self.beat)

    def hips(self, dancer: int) -> Float32:
        """Return the place of a dancer's hips on the floor: x and z [m], (T, 2)."""
        return self.dancers[dancer].clip.root_position[:, ::2]

    def heading(self, dancer: int) -> Float64:
        """Return where a dancer's hips face: 0 the audience, positive towards +x [rad], (T,)."""
        w, x, y, z = np.moveaxis(self.dancers[dancer].clip.rotation[:, 0].astype(np.float64), -1, 0)
        return np.asarray(np.arctan2(2.0 * (x * z + w * y), 1.0 - 2.0 * (x * x + y * y)))


StageFiles = Mapping[str, bytes]
"""Contents of the files by what their names have between the stem and the suffix: "" for the only one."""
