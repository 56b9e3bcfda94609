"""Measure cues: what harmony and bass say about the beat with which a measure begins, beat by beat.

Beside the network, which hears frames, these are features of whole beats: how far harmony and bass differ from those of
the beat before, how strongly low, middle and high bands begin (Durand, Bello, David and Richard, Robust downbeat
tracking using an ensemble of convolutional networks, TASLP 2017; Krebs, Böck, Dorfer and Widmer, Downbeat tracking
using beat-synchronous features and recurrent neural networks, ISMIR 2016). A logistic regression over a beat and its
two neighbours turns them into odds. `training/` makes its weights.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW

Floats = npt.NDArray[np.float32]

FEATURES: Final = 7
"""Of each beat: change of harmony and of bass, onsets of bass, middle, high and all bands, the network's log-odds."""
CONTEXT: Final = 3
"""Beats that are looked at together: the one before, the beat, the one after."""
CUES: Final = FEATURES * CONTEXT

LEAD: Final = 3.5
"""A beat's onsets are looked for from so many frames before it to as many after it."""
HARMONY_FROM: Final = 1.0
HARMONY_UNTIL: Final = 0.7
"""Its harmony is heard from so many frames after it until this share of the beat."""
SMOOTH: Final = 13
"""Bands over which the spectrum's trend is removed: an octave."""
USUAL_BEATS: Final = 16
"""Features are compared with those of the last beats."""
LEAST_SAID, MOST_SAID = 0.02, 0.98
"""Limits of the network's probability that a beat is a downbeat."""
LEAST_SPREAD: Final = 0.15
"""Least spread of a feature that is compared with the last beats, as a share of its mean."""
LEAST_DEVIATION: Final = 1e-3
LEAST_BEAT: Final = 1e-4
LEAST_NORM: Final = 1e-6
"""Added so that nothing is divided by 0."""

_SHORT, _LONG = BANDS_PER_WINDOW
BASS: Final = slice(_SHORT, _SHORT + 14)
MIDDLE: Final = slice(20, 45)
HIGH: Final = slice(52, _SHORT)
"""Bands whose onsets are summed."""
_BASS_LINE: Final = 18
"""Lowest bands of the long window that the bass's pitch is taken from: up to 300 Hz."""

CUE_WEIGHTS: Final = np.array(
    (-0.317, -0.015, 0.019, 0.039, -0.043, -0.060, 0.083, 0.749, -0.019, -0.062, 0.017, 0.240,
     0.099, 0.910, -0.480, 0.061, -0.222, -0.165, -0.090, 0.271, -0.329, -1.054, 1.086, -0.626)
)  # fmt: skip
"""Made in `training/`: of the beat before, the beat, the one after, and a constant; then of the network's word alone,
and a constant."""


class BeatFeatures:
    """Collects the features of each beat, frame by frame. Allocates little, and only once a beat."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all beats, for example after a jump of the grid."""
        self._harmony = np.zeros(_LONG)
        self._frames = 0
        self._onset: Float64 = np.zeros(4)
        self._beat = self._downbeat = 0.0
        self._open = False
        self._previous: Float64 | None = None
        self._recent: Float64 = np.zeros((USUAL_BEATS, FEATURES - 1))
        self._count = 0

    def step(self, features: Floats, beat: float, downbeat: float, since: float, interval: float) -> Float64 | None:
        """Process a frame, `since` frames after the last beat; return the features of a beat that is complete, (7,).

        features: compressed bands and their rises, (2 BAND_COUNT,); beat, downbeat: the network's probabilities.
        """
        off = since - interval if since > interval - LEAD else since
        if off < 0.0 and not self._open:
            self._begin()
        if not self._open:
            return None
        if abs(off) < LEAD:
            rises = features[BAND_COUNT:]
            for row, part in enumerate((BASS, MIDDLE, HIGH)):
                self._onset[row] = max(self._onset[row], float(rises[part].sum()))
            self._onset[3] = max(self._onset[3], float(rises.sum()))
            self._beat, self._downbeat = max(self._beat, beat), max(self._downbeat, downbeat)
        if off >= HARMONY_FROM:
            self._harmony += features[_SHORT:BAND_COUNT]
            self._frames += 1
        return self._end() if off >= HARMONY_UNTIL * interval else None

    def _begin(self) -> None:
        self._open = True
        self._harmony[:] = 0.0
        self._onset[:] = 0.0
        self._frames, self._beat, self._downbeat = 0, 0.0, 0.0

    def _end(self) -> Float64:
        self._open = False
        level = self._harmony / max(self._frames, 1)
        tones = tonal_part(level)
        found = np.zeros(FEATURES)
        if self._previous is not None:
            found[0] = spectral_distance(tones, self._previous)
            found[1] = spectral_distance(tones[:_BASS_LINE], self._previous[:_BASS_LINE])
        self._previous = tones
        found[2:6] = self._onset
        said = min(max(self._downbeat / max(self._beat, LEAST_BEAT), LEAST_SAID), MOST_SAID)
        found[6] = math.log(said / (1.0 - said))
        self._recent[self._count % USUAL_BEATS] = found[:6]
        self._count += 1
        known = self._recent[: min(self._count, USUAL_BEATS)]
        mean = known.mean(axis=0)
        found[:6] = (found[:6] - mean) / (known.std(axis=0) + LEAST_SPREAD * np.abs(mean) + LEAST_DEVIATION)
        return found


def tonal_part(level: Float64) -> Float64:
    """Return by how much the bands of a spectrum (n,) are above its trend, at least 0."""
    padded = np.pad(level, SMOOTH // 2, mode="edge")
    return np.maximum(level - np.convolve(padded, np.full(SMOOTH, 1.0 / SMOOTH), "valid"), 0.0)


def spectral_distance(one: Float64, other: Float64) -> float:
    """Return 1 less the cosine of two spectra."""
    return 1.0 - float(one @ other) / (math.sqrt(float(one @ one) * float(other @ other)) + LEAST_NORM)


class MeasureCues:
    """Log-odds that a beat is the first of a measure, beside what the network says of it."""

    def __init__(self, weights: Float64) -> None:
        """weights (CUES + 1 + 2,): of all features and a constant, then of the network's word alone and a constant.

        Raises ValueError for another shape.
        """
        if weights.shape != (CUES + 3,):
            raise ValueError(f"cues of shape {weights.shape}: {(CUES + 3,)} expected")
        self._weights = weights
        self._beats = BeatFeatures()
        self._context: Float64 = np.zeros((CONTEXT, FEATURES))
        self._known = 0

    def clear(self) -> None:
        """Forget all beats."""
        self._beats.clear()
        self._known = 0

    def step(self, features: Floats, beat: float, downbeat: float, since: float, interval: float) -> float | None:
        """Process a frame; when a beat is complete, return the log-odds of the beat before it that the network has not
        said, once `CONTEXT` beats are known."""
        found = self._beats.step(features, beat, downbeat, since, interval)
        if found is None:
            return None
        self._context[:-1] = self._context[1:]
        self._context[-1] = found
        self._known += 1
        if self._known < CONTEXT:
            return None
        heard = float(self._context.reshape(-1) @ self._weights[:CUES]) + float(self._weights[CUES])
        alone, constant = self._weights[CUES + 1 :]
        return heard - (float(alone) * float(self._context[CONTEXT - 2, FEATURES - 1]) + float(constant))
