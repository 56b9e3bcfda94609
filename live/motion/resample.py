"""A clip at another rate, or a part of one that begins between two samples."""

import numpy as np

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.sampling import read_clip


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
