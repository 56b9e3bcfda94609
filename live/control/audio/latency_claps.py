"""Measurement of picture latency from people's claps in time with flashes."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.base.errors import PersonError

STEP: Final = 0.001
"""Time step of the envelope [s]."""

RISE: Final = 6.0
"""A clap is this many times louder than the level before it …"""

BEFORE: Final = 0.100
"""… in this time [s]."""

DEAD_TIME: Final = 0.200
"""Dead time after a clap [s], for echoes and hands that are not together."""

FLOOR: Final = 1e-3
"""Minimum level of a clap (full scale is 1)."""

ONSET_SHARE: Final = 0.2
"""A clap begins at this share of its peak."""

UNCOUNTED_FLASHES: Final = 4
"""Initial flashes that are not counted."""

MIN_CLAPS: Final = 8
"""Minimum number of claps."""

SPREAD_MAX: Final = 0.060
"""Maximum scatter of claps [s] (median distance from their median)."""

OUTLIER_FACTOR: Final = 3.0
"""Claps beyond this multiple of the scatter are excluded."""


@dataclass(frozen=True, slots=True)
class ClapOffset:
    """Delay of claps after their flashes."""

    seconds: float
    """Median [s]."""
    spread: float
    """Median distance from the median [s]."""
    claps: int
    """Number of claps used."""


def find_claps(sound: Float32, sample_rate: float) -> Float64:
    """Return the times of claps in a mono sound, shape (n,) [s]."""
    clean = np.nan_to_num(sound.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    step = max(round(STEP * sample_rate), 1)
    sharp = np.diff(clean, prepend=0.0) * (sample_rate / 20_000.0)  # claps are bright, halls rumble
    count = len(sharp) // step
    level = np.sqrt(np.mean(np.square(sharp[: count * step].reshape(count, step)), axis=1))
    window = round(BEFORE / STEP)
    claps, at = [], window
    while at < count:
        if level[at] > max(FLOOR, RISE * float(np.median(level[at - window : at])) + 1e-12):
            peak = at + int(np.argmax(level[at : at + 10]))
            begin = peak
            while begin > at - 5 and level[begin - 1] > ONSET_SHARE * level[peak]:
                begin -= 1
            claps.append(begin * step / sample_rate)
            at += round(DEAD_TIME / STEP)
        else:
            at += 1
    return np.array(claps)


def clap_offset(claps: Float64, flashes: Float64) -> ClapOffset:
    """Return the delay of `claps` after `flashes` [s], both in order; each clap belongs to the nearest flash.

    PersonError with a remedy if there are too few claps or they scatter too much.
    """
    counted = flashes[UNCOUNTED_FLASHES:]
    late = np.array([clap - flashes[np.argmin(np.abs(flashes - clap))] for clap in claps if len(flashes)])
    if len(counted):
        half = 0.5 * float(np.median(np.diff(flashes)))
        late = late[(claps > counted[0] - half) & (claps < counted[-1] + half)]
    if len(late) < MIN_CLAPS or not len(counted):
        raise PersonError(
            f"only {len(late)} claps were heard; {MIN_CLAPS} are needed",
            "clap loudly with every flash, near the microphone, and try another --audio-channel if none is heard",
        )
    middle = float(np.median(late))
    scatter = float(np.median(np.abs(late - middle)))
    kept = late[np.abs(late - middle) <= OUTLIER_FACTOR * max(scatter, 0.005)]
    if scatter > SPREAD_MAX:
        raise PersonError(
            f"the claps scatter by {1000 * scatter:.0f} ms: no delay can be measured",
            "clap with the flashes, several people together, and stop other loud sounds",
        )
    return ClapOffset(float(np.median(kept)), scatter, len(kept))
