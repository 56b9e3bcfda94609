"""Clip: one recorded or sketched motion on the engine's skeleton, built once and read only.

Reading a clip between its samples: SLERP per joint, the root linearly, as everywhere in the engine (T035).

A clip at another rate, or a part of one that begins between two samples.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.motion import quaternion

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


Float = npt.NDArray[np.floating]


def read_clip(clip: Clip, samples: Float) -> tuple[Float, Float, Bool]:
    """Root (n, 3), rotations (n, J, 4) and contacts (n, 2) at fractional `samples` (n,); ends are held.

    Motion in float64; a foot is in contact where it is at the nearest sample.
    """
    samples = np.clip(np.asarray(samples, np.float64), 0.0, clip.sample_count - 1)
    before = np.minimum(samples.astype(np.int64), max(clip.sample_count - 2, 0))
    after = np.minimum(before + 1, clip.sample_count - 1)
    part = samples - before
    root = clip.root_position.astype(np.float64)
    rotation = clip.rotation.astype(np.float64)
    return (
        root[before] * (1.0 - part[:, None]) + root[after] * part[:, None],
        quaternion.slerp(rotation[before], rotation[after], part[:, None]),
        clip.contact[np.round(samples).astype(np.int64)],
    )


def resample(clip: Clip, rate: float, *, first: float = 0.0, last: float | None = None) -> Clip:
    """The clip from sample `first` to sample `last` (fractions allowed; default: the end), `rate` samples a second.

    Rotations are interpolated by SLERP, the root linearly, contacts taken from the nearest sample. The last new
    sample is the last one that does not lie beyond `last`. Raises ValueError for a range outside the clip.
    """
    end = clip.sample_count - 1.0
    last = end if last is None else last
    if not (0.0 <= first <= last <= end + 1e-6 and rate > 0.0):
        raise ValueError(f"samples {first:g} to {last:g} at {rate:g} Hz: within 0 to {end:g} expected")
    if rate == clip.sample_rate and first == 0.0 and last >= end:
        return clip
    step = clip.sample_rate / rate
    count = int((last - first) / step + 1e-3) + 1
    root, rotation, contact = read_clip(clip, first + np.arange(count) * step)
    return Clip(
        clip.name,
        np.ascontiguousarray(root, np.float32),
        np.ascontiguousarray(quaternion.continuous(rotation), np.float32),
        rate,
        np.ascontiguousarray(contact),
    )
