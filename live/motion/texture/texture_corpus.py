"""Motion capture cut into fragments, from which one or many sketches are textured."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.errors import PersonError
from live.motion.clip import Clip
from live.motion.texture.drivers import DriverSet
from live.motion.texture.fragments import Fragments, find_cuts, make_fragments
from live.motion.texture.frequency_bands import (
    Chart,
    SampledClip,
    charts_for,
    columns_of,
    sample_clip,
    split_bands,
    tracks_of,
)
from live.motion.texture.texture_settings import TextureSettings
from live.motion.texture.upper_body_regression import UpperBodyRegression, learn_upper_body

MIN_CLIP_S: Final = 1.0
"""Clips shorter than this [s] are too short to match."""


@dataclass(frozen=True, slots=True, eq=False)
class DrivingFeatures:
    """Features of all data for matching, and its fragments."""

    features: Float64
    """One band of the driving angles, then their weighted derivatives, (S, 2 D)."""
    fragments: Fragments
    weight: float
    """Weight of the derivatives [samples]."""


@dataclass(frozen=True, slots=True, eq=False)
class TextureCorpus:
    """Clips of motion capture as concatenated tracks in common charts."""

    clips: tuple[Clip, ...]
    charts: tuple[Chart, ...]
    tracks: Float64
    """All degrees of freedom of all clips, (S, COLUMNS)."""
    starts: Int64
    """First sample of each clip and the end of the last, (n + 1,)."""
    _driving_cache: dict[tuple[object, ...], DrivingFeatures] = field(default_factory=dict)
    _regressions: dict[tuple[object, ...], UpperBodyRegression] = field(default_factory=dict)

    def regression(self, settings: TextureSettings) -> UpperBodyRegression:
        """Return what the lower body tells of `settings.synthesize` in these clips. Cached; the first takes seconds."""
        key = _regression_key(settings)
        if key not in self._regressions:
            drive = DriverSet(settings.learnt_drive, 0 in settings.learnt_drive) if settings.learnt_drive else None
            takes = [sample_clip(clip) for clip in self.clips]
            self._regressions[key] = learn_upper_body(takes, settings.synthesize, drive)
        return self._regressions[key]

    def keep_regression(self, settings: TextureSettings, regression: UpperBodyRegression) -> None:
        """Use what was learnt from the same clips before, with charts for another sketch."""
        self._regressions[_regression_key(settings)] = regression

    def driving_features(self, drive: tuple[int, ...], band: int, cut: int, derivative: float) -> DrivingFeatures:
        """Return the data's driving angles in one band, cut at turning points of column `cut`. Cached."""
        key = (drive, band, cut, derivative)
        if key not in self._driving_cache:
            columns = columns_of(drive)
            pieces = [self.tracks[a:b] for a, b in zip(self.starts[:-1], self.starts[1:], strict=True)]
            values = [split_bands(piece[:, columns], band)[band - 1] for piece in pieces]
            slopes = [np.gradient(value, axis=0) for value in values]
            value, slope = np.concatenate(values), np.concatenate(slopes)
            weight = derivative * float(value.std()) / max(float(slope.std()), 1e-12)
            at = int(np.flatnonzero(columns == cut)[0])
            parts = make_fragments([find_cuts(one[:, at]) for one in values], self.starts[:-1].tolist())
            self._driving_cache[key] = DrivingFeatures(np.concatenate((value, weight * slope), axis=1), parts, weight)
        return self._driving_cache[key]


def _regression_key(settings: TextureSettings) -> tuple[object, ...]:
    return settings.synthesize, settings.learnt_drive


def make_corpus(clips: Sequence[Clip], sketches: Sequence[SampledClip] = ()) -> TextureCorpus:
    """Return the tracks of `clips`, in charts that also cover the sketches `sketches`.

    Raises PersonError if there are no clips or one is too short.
    """
    if not clips:
        raise PersonError("there is no motion capture to take texture from", "give recordings: --with DIR_OR_FILES")
    for clip in clips:
        if clip.seconds < MIN_CLIP_S:
            raise PersonError(
                f"{clip.name}: {clip.seconds:.2f} s are too short to find movements in",
                f"leave it out, or give recordings of {MIN_CLIP_S:g} s and more (10 s and more are useful)",
            )
    samples = [sample_clip(clip) for clip in clips]
    charts = charts_for([*samples, *sketches])
    starts = np.cumsum([0, *(len(one.root) for one in samples)])
    return TextureCorpus(tuple(clips), charts, np.concatenate([tracks_of(one, charts) for one in samples]), starts)


def cut_column(sketch: Float64, settings: TextureSettings) -> int:
    """Return the column at whose turning points curves are cut: `wish.cut`, else the driving one that moves most."""
    columns = columns_of(settings.drive)
    if settings.cut is not None:
        return settings.cut
    band = split_bands(sketch[:, columns], settings.match_band)[settings.match_band - 1]
    return int(columns[int(np.argmax(band.var(axis=0)))])
