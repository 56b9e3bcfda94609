"""A clip at another rate, or a part of one that begins between two samples."""

import numpy as np

from live.motion import quaternion
from live.motion.clip import Clip


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
    place = np.minimum(first + np.arange(count) * step, end)
    before = np.minimum(place.astype(np.int64), max(clip.sample_count - 2, 0))
    after = np.minimum(before + 1, clip.sample_count - 1)
    part = place - before
    root, rotation = clip.root_position.astype(np.float64), clip.rotation.astype(np.float64)
    weight = part[:, None]
    moved = root[before] * (1.0 - weight) + root[after] * weight
    turned = quaternion.slerp(rotation[before], rotation[after], weight)
    nearest = np.where(part < 0.5, before, after)
    return Clip(
        clip.name,
        np.ascontiguousarray(moved, np.float32),
        np.ascontiguousarray(quaternion.continuous(turned), np.float32),
        rate,
        np.ascontiguousarray(clip.contact[nearest]),
    )
