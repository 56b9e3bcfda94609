"""What a frame says: the chances of a beat and a downbeat as likelihoods of the states (Krebs et al., ISMIR 2015)."""

from typing import Final

import numpy as np

from live.clock.bar_pointer.model import Model

Likelihoods = tuple[np.float32, np.float32, np.float32, np.float32]

LEAST: Final = 1e-4
"""No beat is less sure, nor its absence."""


def likelihoods(
    model: Model, beat: float, downbeat: float, downbeat_range: tuple[float, float], downbeat_sharpness: float
) -> Likelihoods:
    """How much likelier the frame is with a plain beat, a downbeat, the middle of a measure, and between beats.

    `downbeat_range`: chances of a downbeat among beats are taken for no less and no more; `downbeat_sharpness`: the
    exponent of what is heard of them.
    """
    beat = min(max(beat, LEAST), 1.0 - LEAST)
    least, most = downbeat_range
    first = min(max(downbeat / beat, least), most)
    odds = beat / (1.0 - beat) * (1.0 - model.beat_share) / model.beat_share
    any_beat = min(max(odds**model.sharpness, model.ratio_min), model.ratio_max)
    usual = model.downbeat_share
    other = any_beat * ((1.0 - first) / (1.0 - usual)) ** downbeat_sharpness
    one = any_beat * (first / usual) ** downbeat_sharpness
    between = any_beat**model.half_beat
    middle = model.middle_share * one + (1.0 - model.middle_share) * other
    return np.float32(other), np.float32(one), np.float32(middle), np.float32(between)
