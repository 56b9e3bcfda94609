"""How late pictures are seen: people clap with flashes, and their claps are heard."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

STEP: Final = 0.001
"""Seconds of sound that one value of the envelope stands for."""

RISE: Final = 6.0
"""A clap is so many times louder than what was there before ..."""

BEFORE: Final = 0.100
"""... in this time [s]."""

REST: Final = 0.200
"""Seconds after a clap in which no other is looked for: echoes, and hands that are not quite together."""

FLOOR: Final = 1e-3
"""Level under which nothing is a clap (full scale is 1)."""

HALF_WAY: Final = 0.2
"""A clap begins where it has this share of its peak."""

LEARNING: Final = 4
"""Flashes that nobody is expected to meet yet."""

FEWEST: Final = 8
"""Claps needed."""

SPREAD_MAX: Final = 0.060
"""Seconds by which claps may scatter (median distance from their median)."""

FAR: Final = 3.0
"""Claps farther off than so many times that scatter are left out."""


@dataclass(frozen=True, slots=True)
class ClapOffset:
    """How late claps came after their flashes."""

    seconds: float
    """Median [s]."""
    spread: float
    """Median distance from it [s]."""
    claps: int
    """Claps that counted."""


def find_claps(sound: Float32, sample_rate: float) -> Float64:
    """Where claps begin in a sound of one channel, shape (n,) [s]."""
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
            while begin > at - 5 and level[begin - 1] > HALF_WAY * level[peak]:
                begin -= 1
            claps.append(begin * step / sample_rate)
            at += round(REST / STEP)
        else:
            at += 1
    return np.array(claps)


def clap_offset(claps: Float64, flashes: Float64) -> ClapOffset:
    """How late `claps` come after `flashes` [s], both in order; each belongs to the flash nearest to it.

    PersonError with a remedy if there are too few, or if they scatter too much to say anything.
    """
    counted = flashes[LEARNING:]
    late = np.array([clap - flashes[np.argmin(np.abs(flashes - clap))] for clap in claps if len(flashes)])
    if len(counted):
        half = 0.5 * float(np.median(np.diff(flashes)))
        late = late[(claps > counted[0] - half) & (claps < counted[-1] + half)]
    if len(late) < FEWEST or not len(counted):
        raise PersonError(
            f"only {len(late)} claps were heard; {FEWEST} are needed",
            "clap loudly with every flash, near the microphone, and try another --audio-channel if none is heard",
        )
    middle = float(np.median(late))
    scatter = float(np.median(np.abs(late - middle)))
    kept = late[np.abs(late - middle) <= FAR * max(scatter, 0.005)]
    if scatter > SPREAD_MAX:
        raise PersonError(
            f"the claps scatter by {1000 * scatter:.0f} ms: nothing can be told from them",
            "clap with the flashes, several people together; what else is loud must rest",
        )
    return ClapOffset(float(np.median(kept)), scatter, len(kept))
