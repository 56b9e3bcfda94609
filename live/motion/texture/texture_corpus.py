"""Motion capture cut into fragments, from which one or many sketches are textured."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.motion.clip import Clip
from live.motion.texture.fragments import Fragments, find_cuts, fragments_of
from live.motion.texture.frequency_bands import (
    Chart,
    Sampled,
    charts_for,
    columns_of,
    sample_clip,
    split_bands,
    tracks_of,
)
from live.motion.texture.texture_settings import Wish

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

SHORTEST_S: Final = 1.0
"""Clips shorter than this [s] are too short to match."""


@dataclass(frozen=True, slots=True, eq=False)
class Driving:
    """Features of all data for matching, and its fragments."""

    features: Float64
    """One band of the driving angles, then their weighted derivatives, (S, 2 D)."""
    parts: Fragments
    weight: float
    """Weight of the derivatives [samples]."""


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """Clips of motion capture as concatenated tracks in common charts."""

    clips: tuple[Clip, ...]
    charts: tuple[Chart, ...]
    tracks: Float64
    """All degrees of freedom of all clips, (S, COLUMNS)."""
    starts: Int64
    """First sample of each clip and the end of the last, (n + 1,)."""
    _driving: dict[tuple[object, ...], Driving] = field(default_factory=dict)

    def driving(self, drive: tuple[int, ...], band: int, cut: int, derivative: float) -> Driving:
        """Return the data's driving angles in one band, cut at turning points of column `cut`. Cached."""
        key = (drive, band, cut, derivative)
        if key not in self._driving:
            columns = columns_of(drive)
            pieces = [self.tracks[a:b] for a, b in zip(self.starts[:-1], self.starts[1:], strict=True)]
            values = [split_bands(piece[:, columns], band)[band - 1] for piece in pieces]
            slopes = [np.gradient(value, axis=0) for value in values]
            value, slope = np.concatenate(values), np.concatenate(slopes)
            weight = derivative * float(value.std()) / max(float(slope.std()), 1e-12)
            at = int(np.flatnonzero(columns == cut)[0])
            parts = fragments_of([find_cuts(one[:, at]) for one in values], self.starts[:-1].tolist())
            self._driving[key] = Driving(np.concatenate((value, weight * slope), axis=1), parts, weight)
        return self._driving[key]


def material_of(clips: Sequence[Clip], also: Sequence[Sampled] = ()) -> Material:
    """Return the tracks of `clips`, in charts that also cover the sketches `also`.

    Raises PersonError if there are no clips or one is too short.
    """
    if not clips:
        raise PersonError("there is no motion capture to take texture from", "give recordings: --with DIR_OR_FILES")
    for clip in clips:
        if clip.seconds < SHORTEST_S:
            raise PersonError(
                f"{clip.name}: {clip.seconds:.2f} s are too short to find movements in",
                f"leave it out, or give recordings of {SHORTEST_S:g} s and more (10 s and more are useful)",
            )
    samples = [sample_clip(clip) for clip in clips]
    charts = charts_for([*samples, *also])
    starts = np.cumsum([0, *(len(one.root) for one in samples)])
    return Material(tuple(clips), charts, np.concatenate([tracks_of(one, charts) for one in samples]), starts)


def cutting_column(sketch: Float64, wish: Wish) -> int:
    """Return the column at whose turning points curves are cut: `wish.cut`, else the driving one that moves most."""
    columns = columns_of(wish.drive)
    if wish.cut is not None:
        return wish.cut
    band = split_bands(sketch[:, columns], wish.match_band)[wish.match_band - 1]
    return int(columns[int(np.argmax(band.var(axis=0)))])
