"""Frozen joints: what capture programs write while markers are hidden is often the last pose seen (T161)."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.cleanup.shocks import turned_by
from live.motion.retarget.body_tracks import BodyTracks

Bool = npt.NDArray[np.bool_]

STILL: Final = 1e-6
"""Turns [rad] and ways [m] below this per frame are none: even standing still is alive."""
SHORTEST: Final = 0.1
"""Held shorter than this [s] may be a file written at a higher rate than it was captured at."""
DEAD_STOP: Final = np.radians(40.0)
"""A joint that turns faster than this [rad/s] just before or after was stopped by the recording, not by the body."""
ALIVE: Final = 0.5
"""Joints that move in fewer than this share of all frames are not tracked at all."""
TOGETHER: Final = 2
"""One joint alone is a knee or elbow that the capture program keeps from bending the wrong way."""
MOVING: Final = 0.05
"""The rest of the body moves faster than this [m/s] meanwhile, else she stands in a pose."""


def find_frozen(tracks: BodyTracks, start: int = 0) -> list[tuple[int, int, list[int]]]:
    """(first, last frame of the held pose, columns); the whole body where everything stops and goes on with a jolt."""
    if tracks.frame_count - start < 4:
        return []
    turn = turned_by(quaternion.mul(tracks.rotation[start + 1 :], quaternion.inverse(tracks.rotation[start:-1])))
    way = np.linalg.norm(np.diff(tracks.positions[start:], axis=0), axis=-1)
    still = turn < STILL
    alive = np.flatnonzero((~still).mean(axis=0) >= ALIVE)
    shortest = max(3, round(SHORTEST * tracks.rate))
    found: dict[tuple[int, int], list[int]] = {}
    for column in alive:
        for first, last in _runs(still[:, column], shortest):
            beside = [turn[place, column] for place in (first - 1, last) if 0 <= place < len(turn)]
            moving = float(np.median(way[first:last].max(axis=1))) * tracks.rate > MOVING
            whole = bool((way[first:last] < STILL).all())
            if (
                max(beside, default=0.0) * tracks.rate > DEAD_STOP
                and (moving or whole)
                and first > 0
                and last < len(turn)
            ):
                found.setdefault((start + first, start + last), []).append(int(column))
    return [(first, last, columns) for (first, last), columns in sorted(found.items()) if len(columns) >= TOGETHER]


def _runs(still: Bool, shortest: int) -> list[tuple[int, int]]:
    """(first, last) frame of stretches of at least `shortest` frames that do not move."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False])).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a + 1 >= shortest]
