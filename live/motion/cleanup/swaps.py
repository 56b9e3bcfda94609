"""Swapped limbs: from one frame to the next left becomes right, and later right becomes left again (T161)."""

from typing import Final

import numpy as np

from live.motion.formats.source_motion import Float64
from live.motion.retarget.body_tracks import BodyTracks

PAIRS: Final = (("LowerArm", "Hand"), ("LowerLeg", "Foot"))
"""Joints whose paths are exchanged together: arms, legs."""
CROSSED: Final = 0.35
"""Crossed over, the limbs have at most this share of the way that they have straight."""


def find_swaps(tracks: BodyTracks, kick_limit: float, start: int = 0) -> list[tuple[int, int, list[int], float]]:
    """(first frame, last frame, columns, distance of the exchanged joints [m]) of every stretch that is swapped.

    Where limbs cross over an odd number of times, the last stretch is taken to go on to the end.
    """
    found: list[tuple[int, int, list[int], float]] = []
    for pair in PAIRS:
        columns = [[tracks.column(side + joint) for side in ("left", "right")] for joint in pair]
        known = [(left, right) for left, right in columns if left is not None and right is not None]
        if not known:
            continue
        left = tracks.positions[start:, [c[0] for c in known]]
        right = tracks.positions[start:, [c[1] for c in known]]
        straight, crossed = _way(left, right, left, right), _way(left, right, right, left)
        steps = start + np.flatnonzero((crossed < CROSSED * straight) & (straight > 4.0 * kick_limit))
        every = sorted(column for c in known for column in c)
        for first, last in zip(steps[::2], [*steps[1::2], tracks.frame_count - 1], strict=False):
            apart = float(np.linalg.norm(left[first - start] - right[first - start], axis=-1).max())
            found.append((int(first) + 1, int(last), every, apart))
    return found


def _way(left: Float64, right: Float64, left_after: Float64, right_after: Float64) -> Float64:
    """Way from each frame to the next over both sides and all joints [m], shape (T - 1,)."""
    steps = np.linalg.norm(left_after[1:] - left[:-1], axis=-1) + np.linalg.norm(right_after[1:] - right[:-1], axis=-1)
    return np.asarray(steps.sum(axis=-1))
