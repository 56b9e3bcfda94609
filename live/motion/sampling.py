"""Reading a clip between its samples: SLERP per joint, the root linearly, as everywhere in the engine (T035)."""

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip

Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]


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
