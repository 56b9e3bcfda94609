"""Observation model: likelihoods of the states from beat and downbeat probabilities (Krebs et al., ISMIR 2015), and a
check that the music still follows the grid.
"""

import math
from typing import Final

import numpy as np

from live.clock.bar_pointer.state_space import BarPointerModel

Likelihoods = tuple[np.float32, np.float32, np.float32]

MIN_PROBABILITY: Final = 1e-4
"""Lower limit of the probability of a beat and of its absence."""


def likelihoods(
    model: BarPointerModel, beat: float, downbeat: float, downbeat_range: tuple[float, float], downbeat_sharpness: float
) -> Likelihoods:
    """Return the likelihoods of a plain beat, a downbeat, and between beats, relative to no beat.

    `downbeat_range`: limits of the probability of a downbeat among beats; `downbeat_sharpness`: exponent of its
    likelihoods.
    """
    beat = min(max(beat, MIN_PROBABILITY), 1.0 - MIN_PROBABILITY)
    least, most = downbeat_range
    first = min(max(downbeat / beat, least), most)
    odds = beat / (1.0 - beat) * (1.0 - model.beat_share) / model.beat_share
    any_beat = min(max(odds**model.sharpness, model.ratio_min), model.ratio_max)
    usual = model.downbeat_share
    other = any_beat * ((1.0 - first) / (1.0 - usual)) ** downbeat_sharpness
    one = any_beat * (first / usual) ** downbeat_sharpness
    between = any_beat**model.half_beat
    return np.float32(other), np.float32(one), np.float32(between)


QUARTERS: Final = 4
MEMORY: Final = 0.25
"""Weight of the newest beat."""

BETWEEN_RATIO: Final = 0.6
"""The grid is wrong if activations between on-beat and off-beat reach this share of those on them."""

LONG_MEMORY: Final = 0.02
CONTRAST_LOSS: Final = 0.45
"""The grid is also wrong if the usual difference of on-beats and off-beats has fallen by this much; the newest beat
enters that usual value with the weight `LONG_MEMORY` (the first beats equally).
"""

CONFIDENCE_WEIGHTS: Final = (-3.08, 0.34, 3.75, 0.87, 1.06, 0.23)
MANUAL_LEVEL_WEIGHT: Final = 0.84
"""Log-odds that the next beat is right: constant; factors of the share's log-odds, of the strengths on the beat, off
it and in between, and of the odds by phase cues; and a bonus if the level was set by hand. A logistic regression over
the beats reported in made pieces that no network has learned; `training/` makes another.
"""

SHARE_LEAST: Final = 0.01
SHARE_MOST: Final = 0.995
"""Limits of the share."""


class ActivationPhase:
    """Phase histogram: the strongest activations of the last beats, on the beat, off it, and in between.

    A network may find the off-beats stronger for a whole song; then there is nothing in between. A new tempo gives
    activations anywhere. If a tracker was sure of the beats and now finds activations between the old ones, the music
    has left the grid, for example by an extra half beat.
    """

    def __init__(self) -> None:
        self.strength = [0.5, 0.0, 0.0, 0.0]
        """On the beat, a quarter after it, half, three quarters: smoothed maxima of each beat."""
        self._quarter = 0
        self._strongest = 0.0
        self._beats = 0
        self._usual = 0.0  # strength on the beat less that off it, over a long time

    def step(self, phase: float, activation: float) -> None:
        """Process one frame, `phase` beats after the last beat."""
        quarter = int(phase * QUARTERS + 0.5) % QUARTERS
        if quarter != self._quarter:
            here = self._quarter
            self.strength[here] += MEMORY * (self._strongest - self.strength[here])
            self._quarter, self._strongest = quarter, 0.0
            if here == 0:
                self._beats += 1
                before = self.strength[0] - self.strength[2]
                self._usual += max(LONG_MEMORY, 1.0 / self._beats) * (before - self._usual)
        self._strongest = max(self._strongest, activation)

    @property
    def grid_is_lost(self) -> bool:
        """Whether the music has left the grid."""
        on, first, off, last = self.strength
        return max(first, last) > BETWEEN_RATIO * max(on, off) or on - off < self._usual - CONTRAST_LOSS

    def confidence(self, share: float, level_is_set: bool = False, phase_odds: float = 0.0) -> float:
        """Return the probability that the next beat is right, 0 to 1.

        share: of all states, those near the grid; phase_odds: log-odds of its phase by cues, 0 if there are none.
        """
        on, first, off, last = self.strength
        share = min(max(share, SHARE_LEAST), SHARE_MOST)
        constant, of_share, of_on, of_off, of_between, of_phase = CONFIDENCE_WEIGHTS
        odds = MANUAL_LEVEL_WEIGHT * level_is_set
        odds += constant + of_share * math.log(share / (1.0 - share)) + of_phase * phase_odds
        return 1.0 / (1.0 + math.exp(-(odds + of_on * on + of_off * off + of_between * max(first, last))))
