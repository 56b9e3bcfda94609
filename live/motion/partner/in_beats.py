"""Examples in beats: recordings retimed so that every unit is so many beats long, whatever tempo it was danced at.

On the stage the clock knows the beats: a leader is looked at so many times a beat, and a unit that lasts two of them is
as many frames long at any tempo.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.partner.units import Example, Hold, Units, cut_units
from live.motion.sampling import read_clip

Float64 = npt.NDArray[np.float64]


def in_beats(units: Units, *, unit_beats: int, samples: int, period: float) -> Units:
    """The same units, each `unit_beats` long, with `samples` a beat, as if a beat lasted `period` [s].

    Before the first and after the last unit of a recording it goes on at its neighbour's tempo, as far as it goes.
    """
    return cut_units([_retimed(one, unit_beats * samples, samples / period) for one in units.examples])


def _retimed(example: Example, size: int, rate: float) -> Example:
    """One example whose units are `size` samples long at `rate` [Hz]."""
    cuts, last = example.cuts, example.follower.sample_count - 1.0
    first, final = size / (cuts[1] - cuts[0]), size / (cuts[-1] - cuts[-2])
    before = int(np.floor(cuts[0] * first + 1e-9))
    after = int(np.floor((last - cuts[-1]) * final + 1e-9))
    units = len(cuts) - 1
    at = np.concatenate(([-before / first + cuts[0]], cuts, [cuts[-1] + after / final]))
    new = np.concatenate(([0.0], before + size * np.arange(units + 1.0), [before + size * units + after]))
    places = np.asarray(np.interp(np.arange(int(new[-1]) + 1), new, at), np.float64)
    control, target = example.control.at(places), example.target.at(places)
    return Example(
        example.name, replace(control, rate=rate), replace(target, rate=rate), _read(example.follower, places, rate),
        np.asarray(new[1:-1]), np.asarray(np.interp(example.beats, at, new)),
        tuple(_moved(hold, at, new) for hold in example.holds),
    )  # fmt: skip


def _read(clip: Clip, places: Float64, rate: float) -> Clip:
    root, rotation, contact = read_clip(clip, places)
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32), rate,
        np.ascontiguousarray(contact),
    )  # fmt: skip


def _moved(hold: Hold, at: Float64, new: Float64) -> Hold:
    return replace(hold, begin=float(np.interp(hold.begin, at, new)), end=float(np.interp(hold.end, at, new)))
