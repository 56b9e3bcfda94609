"""Clip: one recorded or sketched motion on the engine's skeleton, built once and read only."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """T samples of a pose (T030): root position and local rotations, Y up, floor at y = 0, facing +z at rest."""

    name: str
    root_position: Float32
    """World position of the hips [m], shape (T, 3)."""
    rotation: Float32
    """Local rotations, unit quaternions (w, x, y, z), shape (T, J, 4)."""
    sample_rate: float
    """Samples per second at the clip's own tempo [Hz]."""
    contact: Bool
    """Whether the left and the right foot carry or touch the floor, shape (T, 2)."""

    def __post_init__(self) -> None:
        samples, joints = self.rotation.shape[:2]
        if self.root_position.shape != (samples, 3) or self.rotation.shape != (samples, joints, 4):
            raise ValueError(
                f"clip {self.name!r}: root {self.root_position.shape} and rotation {self.rotation.shape} "
                "do not fit; (T, 3) and (T, J, 4) expected"
            )
        if self.contact.shape != (samples, 2):
            raise ValueError(f"clip {self.name!r}: contact {self.contact.shape}, ({samples}, 2) expected")
        if not (np.isfinite(self.root_position).all() and np.isfinite(self.rotation).all()):
            raise ValueError(f"clip {self.name!r} holds a value that is not a finite number")
        for array in (self.root_position, self.rotation, self.contact):
            array.setflags(write=False)

    @property
    def sample_count(self) -> int:
        """Number of samples T."""
        return int(self.rotation.shape[0])

    @property
    def seconds(self) -> float:
        """Length in seconds at the clip's own tempo: from the first to the last sample."""
        return (self.sample_count - 1) / self.sample_rate
