"""Phase cues: whether a grid lies on the beats of the music, or quarters of a beat beside them.

The network hears frames and may prefer other places for a whole song: off-beats of a hi-hat, an organ's chop, the bell
of a timeline, the sixteenths of a samba. Over some measures bass, pickups and changes of harmony tell them apart:
harmony and bass come with the beat, short notes lead into it (features of the parts of a beat: Krebs, Böck, Dorfer and
Widmer, Downbeat tracking using beat-synchronous features and recurrent neural networks, ISMIR 2016). Each of the four
grids has a score, the same function of what is heard at its own quarters (McFadden, Conditional logit analysis, 1974).
`training/` makes its weights.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.clock.bar_pointer.phase_choice import PLACES
from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW
from live.clock.tracking.measure_cues import BASS, HIGH, LEAST_DEVIATION, MIDDLE, spectral_distance, tonal_part

Floats = npt.NDArray[np.float32]

ONSETS: Final = 4
HEARD: Final = ONSETS + 2
"""At each place: onsets of bass, middle, high and all bands, the network's probability of a beat, change of harmony."""
PHASE_FEATURES: Final = 2 * HEARD
"""Of each place: what is heard, and how far that alternates from beat to beat."""

LEAD: Final = 3.5
"""Onsets are looked for from so many frames before a place to as many after it."""
MEMORY_BEATS: Final = 24
"""Beats that are remembered, half of them of each parity."""
FIRST_BEATS: Final = 8
"""Beats before anything is said."""
FLOOR: Final = 0.05
"""Added to onsets before they are compared, as a share of their mean over all places."""

PHASE_WEIGHTS: Final = np.array(
    ((0.49, 0.09, 0.25, 0.23, 2.29, 4.06, 0.18, -0.09, 0.32, 0.14, 1.49, 1.23),
     (-0.39, -0.25, -0.28, -0.31, -1.55, 0.36, -0.28, -0.04, 0.09, 0.05, 1.08, 0.41),
     (-0.19, 0.22, 0.06, -0.01, -0.33, -2.36, -0.04, 0.18, -0.21, -0.22, -1.89, -1.10),
     (0.08, -0.07, -0.03, 0.08, -0.41, -2.06, 0.14, -0.05, -0.20, 0.03, -0.68, -0.54))
)  # fmt: skip
"""Made in `training/`: for each place of a grid."""

_SHORT, _LONG = BANDS_PER_WINDOW


class QuarterFeatures:
    """Collects onsets and changes of harmony at the quarters of each beat, frame by frame, and keeps their means over
    the last even and odd beats. Allocates little, and only at each quarter."""

    def __init__(self) -> None:
        self._strongest: Float64 = np.zeros(HEARD - 1)
        self._spectrum: Float64 = np.zeros(_LONG)
        self.clear()

    def clear(self) -> None:
        """Forget all beats, for example after a jump of the grid."""
        self._mean: Float64 = np.zeros((2, PLACES, HEARD))
        self._beats = -1  # beats whose first place was passed
        self._place = self._quarter = -1
        self._spectra: list[Float64] = []
        self._strongest[:] = 0.0
        self._spectrum[:] = 0.0
        self._frames = 0

    def shift(self, places: int) -> None:
        """Go on with the grid that begins `places` quarters of a beat later."""
        mean = np.roll(self._mean, -places, axis=1)
        wrapped = slice(PLACES - places, PLACES)  # these are of the next beat
        mean[:, wrapped] = mean[::-1, wrapped].copy()
        self._mean = mean
        self._place = self._quarter = -1
        self._spectra.clear()

    def step(self, features: Floats, beat: float, since: float, interval: float) -> Float64 | None:
        """Process a frame, `since` frames after the last beat; return the features of the grid's places, shape
        (PLACES, PHASE_FEATURES), when a beat is complete and enough are known.

        features: compressed bands and their rises, (2 BAND_COUNT,); beat: the network's probability.
        """
        quarters = PLACES * since / interval
        place, quarter = int(quarters + 0.5) % PLACES, int(quarters) % PLACES
        complete = False
        if place != self._place:
            self._end_place()
            complete = place == 0
            self._beats += complete
            self._place = place
        if quarter != self._quarter:
            self._end_quarter()
            self._quarter = quarter
        if abs(quarters - int(quarters + 0.5)) * interval < PLACES * LEAD:
            rises, strongest = features[BAND_COUNT:], self._strongest
            for row, part in enumerate((BASS, MIDDLE, HIGH, slice(None))):
                strongest[row] = max(strongest[row], float(rises[part].sum()))
            strongest[ONSETS] = max(strongest[ONSETS], beat)
        self._spectrum += features[_SHORT:BAND_COUNT]
        self._frames += 1
        return quarter_features(self._mean) if complete and self._beats >= FIRST_BEATS else None

    def _end_place(self) -> None:
        if self._beats >= 0 and self._place >= 0:
            self._learn(self._beats, self._place, slice(0, HEARD - 1), self._strongest)
        self._strongest[:] = 0.0

    def _end_quarter(self) -> None:
        """The quarters of two places are heard: compare the half beats before and after the place between them."""
        spectra = self._spectra
        spectra.append(self._spectrum / max(self._frames, 1))
        self._spectrum[:] = 0.0
        self._frames = 0
        if len(spectra) < PLACES:
            return
        before, after = (tonal_part(spectra[k] + spectra[k + 1]) for k in (0, 2))
        del spectra[0]
        place = (self._quarter - 1) % PLACES
        beat = self._beats - (place >= 2)  # the beat is counted from the middle before its first place on
        if beat >= 0:
            self._learn(beat, place, slice(HEARD - 1, HEARD), spectral_distance(before, after))

    def _learn(self, beat: int, place: int, columns: slice, value: Float64 | float) -> None:
        mean = self._mean[beat % 2, place, columns]
        mean += max(2.0 / MEMORY_BEATS, 1.0 / (beat // 2 + 1)) * (value - mean)


def quarter_features(mean: Float64) -> Float64:
    """Return the features of the places, (PLACES, PHASE_FEATURES), of the means of even and odd beats, (2, PLACES,
    HEARD): what is heard there against the mean of all places, and how far it alternates."""
    heard, apart = mean.mean(axis=0), np.abs(mean[0] - mean[1])
    usual = heard[:, :ONSETS].mean(axis=0) + LEAST_DEVIATION
    heard[:, :ONSETS] = np.log(heard[:, :ONSETS] / usual + FLOOR)
    apart[:, :ONSETS] /= usual
    return np.concatenate([heard - heard.mean(axis=0), apart], axis=1)


def grid_scores(features: Float64, weights: Float64) -> Float64:
    """Return the scores of the grid and of those one, two and three quarters of a beat later, (PLACES,)."""
    return np.array([float((np.roll(features, -k, axis=0) * weights).sum()) for k in range(PLACES)])


class PhaseCues:
    """Log-odds of the four grids that lie quarters of a beat apart, from the last `MEMORY_BEATS` beats."""

    def __init__(self, weights: Float64) -> None:
        """weights (PLACES, PHASE_FEATURES); ValueError for another shape."""
        if weights.shape != (PLACES, PHASE_FEATURES):
            raise ValueError(f"phase cues of shape {weights.shape}: {(PLACES, PHASE_FEATURES)} expected")
        self._weights = weights
        self._quarters = QuarterFeatures()

    def clear(self) -> None:
        """Forget all beats."""
        self._quarters.clear()

    def shift(self, places: int) -> None:
        """Go on with the grid that begins `places` quarters of a beat later."""
        self._quarters.shift(places)

    def step(self, features: Floats, beat: float, since: float, interval: float) -> Float64 | None:
        """Process a frame, `since` frames after the last beat; return the scores of the grid and of those one, two and
        three quarters of a beat later, (PLACES,), when a beat is complete, None otherwise."""
        found = self._quarters.step(features, beat, since, interval)
        return None if found is None else grid_scores(found, self._weights)
