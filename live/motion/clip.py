"""Motion clips on the engine's skeleton (immutable), with sampling between frames and resampling (T035)."""

from dataclasses import dataclass, replace

import numpy as np

from live.base.arrays import Bool, Float, Float32
from live.motion import quaternion


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """T samples of a pose (T030): root position and local rotations, Y up, floor at y = 0, rest pose facing +z."""

    name: str
    root_position: Float32
    """World position of the hips [m], shape (T, 3)."""
    rotation: Float32
    """Local rotations, unit quaternions (w, x, y, z), shape (T, J, 4)."""
    sample_rate: float
    """Samples per second at the clip's original tempo [Hz]."""
    contact: Bool
    """Whether the left and the right foot are in contact with the floor, shape (T, 2)."""

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
            raise ValueError(f"clip {self.name!r} contains a value that is not a finite number")
        for array in (self.root_position, self.rotation, self.contact):
            array.setflags(write=False)

    @property
    def sample_count(self) -> int:
        """Number of samples T."""
        return int(self.rotation.shape[0])

    @property
    def seconds(self) -> float:
        """Duration [s] at the clip's original tempo, from the first to the last sample."""
        return (self.sample_count - 1) / self.sample_rate


def clip_part(clip: Clip, first: int, last: int) -> Clip:
    """Return the clip's samples from `first` to `last` - 1; the arrays are views."""
    part = slice(first, last)
    return replace(
        clip, root_position=clip.root_position[part], rotation=clip.rotation[part], contact=clip.contact[part]
    )


def read_clip(clip: Clip, samples: Float) -> tuple[Float, Float, Bool]:
    """Return root (n, 3), rotations (n, J, 4) and contacts (n, 2) at fractional `samples` (n,), clamped to the clip.

    Rotations are interpolated by SLERP, the root linearly, in float64. Contacts come from the nearest sample.
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
    """Return the clip from sample `first` to `last` (fractional; default: the end) at `rate` samples per second.

    Rotations are interpolated by SLERP, the root linearly; contacts come from the nearest sample. The last new sample
    does not lie beyond `last`. Raises ValueError for a range outside the clip.
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
        np.ascontiguousarray(quaternion.align_signs(rotation), np.float32),
        rate,
        np.ascontiguousarray(contact),
    )
