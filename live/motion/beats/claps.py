"""Claps: sharp minima of the distance between the hands are the moments at which somebody clapped (T018, Fig 2.4)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.formats.source_motion import Float64
from live.motion.retarget.body_tracks import BodyTracks

Int = npt.NDArray[np.int64]

NEAR: Final = 0.22
"""Palms nearer than this [m] may touch: skeletons put the hand's middle beside the palm, and retargeting widens it."""
OPEN: Final = 0.07
"""So far [m] the hands part before and after, within `REACH`."""
REACH: Final = 0.4
"""Seconds."""
SPEED: Final = 0.5
"""They come together at least this fast [m/s] just before."""
TURN: Final = 0.9
"""And the speed of the distance changes by this [m/s] from just before to just after: a V, not a U."""
SIDE: Final = 0.03
"""Seconds on each side that make the two sides of the V; at least two frames."""
SAME_WAY: Final = 0.2
"""Hands that clap bounce off; hands that pass each other leave on the other side (cosine of the two directions)."""
APART: Final = 0.12
"""Two claps are at least so far apart [s]."""


@dataclass(frozen=True, slots=True)
class Clap:
    """One clap."""

    time_s: float
    """When the hands met, between the frames; from the first frame that is kept [s]."""
    distance_m: float
    """Smallest distance of the palms that was recorded."""
    sharpness: float
    """Change of the speed of the distance there [m/s]."""


def find_claps(tracks: BodyTracks, start: int = 0) -> list[Clap]:
    """Everything in the recording from frame `start` on that may be a clap, in order.

    The hands' touch is where the two sides of the V meet (a line through the frames on each side); where hands rest on
    each other, it is where the first side comes down to that distance. Whether it was meant as a clap is decided by
    whom it agrees with: `live.motion.beats.clap_sync`.
    """
    apart = tracks.palms[start:, 0] - tracks.palms[start:, 1]
    distance = np.linalg.norm(apart, axis=-1)
    found: list[Clap] = []
    for frame in _minima(distance):
        clap = _clap(apart, distance, int(frame), tracks.rate)
        if clap is None:
            continue
        if found and clap.time_s - found[-1].time_s < APART:
            if clap.sharpness > found[-1].sharpness:
                found[-1] = clap
            continue
        found.append(clap)
    return found


def _minima(distance: Float64) -> Int:
    """Frames that are lower than the one before and not higher than the one after."""
    if distance.size < 5:
        return np.zeros(0, np.int64)
    down = distance[1:-1] < distance[:-2]
    up = distance[1:-1] <= distance[2:]
    low = distance[1:-1] < NEAR
    return np.flatnonzero(down & up & low) + 1


def _clap(apart: Float64, distance: Float64, frame: int, rate: float) -> Clap | None:
    side, reach = max(2, round(SIDE * rate)), max(3, round(REACH * rate))
    end = frame  # of the stretch in which the hands rest on each other
    while end + 1 < distance.size and abs(distance[end + 1] - distance[frame]) < 0.1 * OPEN and end - frame < reach:
        end += 1
    if frame < side + 1 or end + side + 1 >= distance.size:
        return None
    before, after = distance[max(frame - reach, 0) : frame], distance[end + 1 : end + 1 + reach]
    if min(before.max(), after.max()) - distance[frame] < OPEN:
        return None
    closing, opening = _line(distance, frame - side, frame, rate), _line(distance, end + 1, end + side + 1, rate)
    turn = opening[0] - closing[0]
    if -closing[0] < SPEED or turn < TURN:
        return None
    ways = apart[frame - side], apart[end + side]
    cosine = float(ways[0] @ ways[1]) / max(float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1])), 1e-9)
    if cosine < SAME_WAY:
        return None
    if end - frame >= 2:
        time = (float(np.median(distance[frame : end + 1])) - closing[1]) / closing[0]
    else:
        time = (closing[1] - opening[1]) / turn
    if not frame - 1.5 <= time * rate <= frame + 1.5:
        return None
    return Clap(float(time), float(distance[frame]), float(turn))


def _line(distance: Float64, first: int, stop: int, rate: float) -> tuple[float, float]:
    """Slope [m/s] and value at time 0 [m] of the line through frames `first` to `stop` - 1."""
    time = np.arange(first, stop) / rate
    middle = time.mean()
    slope = float(((time - middle) * distance[first:stop]).sum() / ((time - middle) ** 2).sum())
    return slope, float(distance[first:stop].mean()) - slope * float(middle)
