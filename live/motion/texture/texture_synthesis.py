"""Texturing and completion of a sketch from motion capture (P001-P004, P018-P022)."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.errors import PersonError
from live.motion.clip import Clip
from live.motion.texture.foot_constraints import apply_foot_constraints
from live.motion.texture.fragment_search import Matches, Path, best_paths, match_fragments, weighted_paths
from live.motion.texture.fragments import (
    Fragments,
    concatenate_fragments,
    find_cuts,
    make_fragments,
    skew_to_meet,
    smooth_joins,
)
from live.motion.texture.frequency_bands import (
    RATE,
    SWAY,
    VECTOR,
    SampledClip,
    columns_of,
    headings,
    rotate_about_vertical,
    sample_clip,
    split_bands,
    tracks_of,
)
from live.motion.texture.texture_corpus import DrivingFeatures, TextureCorpus, cut_column
from live.motion.texture.texture_settings import LEGS, TextureSettings


@dataclass(frozen=True, slots=True, eq=False)
class TexturedSketch:
    """A sketch textured along one path through the data."""

    clip: Clip
    fragments: Fragments
    """The sketch's fragments, in samples at 24 Hz."""
    data_fragments: Fragments
    """The data's fragments, in samples of the concatenated data."""
    cut: int
    """The column at whose turning points both were cut."""
    sources: Int64
    """Index of the data fragment used for each, (n,)."""
    consecutive_joins: int
    """Number of joins of fragments that are consecutive in the data."""
    distance: float
    """Root mean square difference in the matching [rad]."""
    scales: Float64
    """Scale of each fragment (P010), (n,)."""
    jump: float
    """Largest jump of a generated angle at a join, before joining [rad]."""
    kinks: tuple[float, float]
    """Largest change of velocity between samples at a join, before and after smoothing [rad/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class PreparedSketch:
    """A sketch with its fragments and their candidates."""

    sampled: SampledClip
    tracks: Float64
    cut: int
    fragments: Fragments
    driving: DrivingFeatures
    matches: Matches


def prepare_sketch(sketch: Clip, corpus: TextureCorpus, settings: TextureSettings) -> PreparedSketch:
    """Return the sketch's fragments and their candidates in the data; PersonError where nothing can be matched."""
    sampled = sample_clip(sketch)
    tracks = tracks_of(sampled, corpus.charts)
    cut = cut_column(tracks, settings)
    driving = corpus.driving_features(settings.drive, settings.match_band, cut, settings.derivative)
    columns = columns_of(settings.drive)
    band = split_bands(tracks[:, columns], settings.match_band)[settings.match_band - 1]
    features = np.concatenate((band, driving.weight * np.gradient(band, axis=0)), axis=1)
    parts = make_fragments([find_cuts(band[:, int(np.flatnonzero(columns == cut)[0])])], [0])
    keep = settings.candidates(driving.fragments.count)
    try:
        matches = _match_by_drive(features, parts, driving, columns, keep, settings)
    except ValueError as error:
        raise PersonError(
            str(error), f"match a lower band, which has longer fragments: --match {settings.match_band + 1}"
        ) from None
    return PreparedSketch(sampled, tracks, cut, parts, driving, matches)


def _match_by_drive(
    features: Float64, parts: Fragments, driving: DrivingFeatures, columns: Int64, keep: int, settings: TextureSettings
) -> Matches:
    """Return the candidates of each fragment, by the joints that drive at its middle (P019)."""
    if not settings.drive_changes:
        return match_fragments(features, parts, driving.features, driving.fragments, keep, scale=settings.scale)
    middle = 0.5 * (parts.begin + parts.end) / RATE
    drives = [settings.drive_at(float(time)) for time in middle]
    found: list[tuple[Int64, Float64, Float64]] = [(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))] * parts.count
    for joints in sorted(set(drives)):
        rows = np.flatnonzero([one == joints for one in drives])
        which = np.flatnonzero(np.isin(columns, columns_of(joints)))
        both = np.concatenate((which, which + len(columns)))
        some = Fragments(parts.begin[rows], parts.end[rows], parts.clip[rows])
        one = match_fragments(
            features[:, both], some, driving.features[:, both], driving.fragments, keep, scale=settings.scale
        )
        for n, row in enumerate(rows.tolist()):
            found[row] = one.candidates[n], one.distances[n], one.scales[n]
    candidates, distances, scales = zip(*found, strict=True)
    return Matches(candidates, distances, scales)


def texture_sketch(sketch: Clip, corpus: TextureCorpus, settings: TextureSettings) -> list[TexturedSketch]:
    """Return the sketch with texture and synthesized joints, once for each path, the best first.

    There may be fewer paths than requested. The clips have the sketch's rate, length and contacts. Raises PersonError
    for a sketch shorter than half a second and where no data can be matched.
    """
    if sketch.seconds < 0.5:
        raise PersonError(
            f"{sketch.name}: {sketch.seconds:.2f} s are too short to match", "give at least half a second"
        )
    sketched = prepare_sketch(sketch, corpus, settings)
    return [_synthesize_path(sketched, corpus, settings, *one) for one in find_paths(sketched, settings)]


def find_paths(sketched: PreparedSketch, settings: TextureSettings) -> list[tuple[Path, Int64, Float64]]:
    """Return the paths, each with its fragments of the data and their scales."""
    parts, matches = sketched.driving.fragments, sketched.matches
    choices = [one.tolist() for one in matches.candidates]
    far = [one.tolist() for one in matches.distances]
    scales = [one.tolist() for one in matches.scales]
    found: list[tuple[Path, Int64, Float64]] = []
    most = 1 if settings.distinct_paths else settings.paths
    join = settings.join_weight * float(np.median([row[0] for row in far]))
    for _ in range(settings.paths if settings.distinct_paths else 1):
        if settings.join_weight:
            best = weighted_paths(choices, far, parts.follows, most, join)
        else:
            best = best_paths(choices, far, parts.follows, most)
        for path in best:
            taken = [row[place] for row, place in zip(choices, path.ranks, strict=True)]
            scale = [row[place] for row, place in zip(scales, path.ranks, strict=True)]
            found.append((path, np.array(taken, np.int64), np.array(scale)))
        if settings.distinct_paths:
            for rows, place in zip(zip(choices, far, scales, strict=True), found[-1][0].ranks, strict=True):
                if len(rows[0]) > 1:
                    for row in rows:
                        del row[place]
    return found


def _synthesize_path(
    sketched: PreparedSketch,
    corpus: TextureCorpus,
    settings: TextureSettings,
    path: Path,
    chosen: Int64,
    scales: Float64,
) -> TexturedSketch:
    data, parts = sketched.driving.fragments, sketched.fragments
    joints = [*settings.synthesize, *settings.texture, *([SWAY] if 0 in settings.texture else [])]
    columns = columns_of(joints)
    tracks, made = corpus.tracks[:, columns], len(settings.synthesize)
    told: Float64 | None = None
    if settings.learnt and made:
        told = corpus.regression(settings).predict(sketched.sampled)
        tracks[:, : 3 * made] = corpus.regression(settings).variation(settings.spread, told)
    pieces = _pieces(tracks, data, chosen, parts, scales)
    _align_turns(
        pieces,
        np.array(
            [
                3 * n + axis
                for n, joint in enumerate(joints)
                if joint < len(corpus.charts)
                and corpus.charts[joint].kind != VECTOR
                and not (settings.learnt and n < made)
                for axis in (0, 2)
            ],
            np.int64,
        ),
    )
    consecutive = np.array([data.follows(a, b) for a, b in pairwise(chosen)], np.bool_)
    before = max((float(np.abs(b[0] - a[-1]).max()) for a, b in pairwise(pieces)), default=0.0)
    met = concatenate_fragments(skew_to_meet(pieces))
    joined = smooth_joins(met, parts.begin[1:], settings.reach, consecutive)
    clip = _apply_bands(sketched, corpus, settings, joined, told)
    joins = parts.begin[1:][~consecutive]
    return TexturedSketch(
        clip, parts, data, sketched.cut, chosen, path.consecutive_joins, float(np.sqrt(path.distance / parts.count)),
        scales, before, (_kink(met, joins), _kink(joined, joins)),
    )  # fmt: skip


def _pieces(tracks: Float64, data: Fragments, chosen: Int64, parts: Fragments, scales: Float64) -> list[Float64]:
    """Return the fragments of the data, resampled to the lengths of the sketch's and scaled."""
    pieces = []
    for begin, end, length, scale in zip(
        data.begin[chosen], data.end[chosen], parts.length.tolist(), scales.tolist(), strict=True
    ):
        at = np.linspace(begin, end, length + 1)
        low = np.minimum(at.astype(np.int64), len(tracks) - 2)
        weight = (at - low)[:, None]
        pieces.append(scale * (tracks[low] * (1.0 - weight) + tracks[low + 1] * weight))
    return pieces


def _align_turns(pieces: list[Float64], columns: Int64) -> None:
    """Shift angles in `columns` by full turns, so that each piece begins as near as possible to the end of the last."""
    for before, piece in pairwise(pieces):
        piece[:, columns] += 2.0 * np.pi * np.round((before[-1, columns] - piece[0, columns]) / (2.0 * np.pi))


def _kink(curve: Float64, joins: Int64) -> float:
    """Return the largest change of velocity at `joins` [rad/s]."""
    return float(np.abs(curve[joins + 1] - 2.0 * curve[joins] + curve[joins - 1]).max(initial=0.0) * RATE)


def _apply_bands(
    sketched: PreparedSketch, corpus: TextureCorpus, settings: TextureSettings, joined: Float64, told: Float64 | None
) -> Clip:
    """Return the sketch with the selected bands of `joined` (T, C) applied, about what is `told` (T, 3 n)."""
    sketch, (low, high) = sketched.sampled.clip, settings.bands
    made = 3 * len(settings.synthesize)
    bands = split_bands(joined, high)
    whole = _at_rate(joined[:, :made] - bands[: low - 1, :, :made].sum(axis=0), sketch)
    columns = columns_of([*settings.texture, *([SWAY] if 0 in settings.texture else [])])
    own = split_bands(sketched.tracks[:, columns], high)[low - 1 : high].sum(axis=0)
    detail = _at_rate(bands[low - 1 : high, :, made:].sum(axis=0) - own, sketch)
    rotation, root = sketch.rotation.astype(np.float64), sketch.root_position.astype(np.float64)
    if told is not None:
        vectors = _at_rate(told, sketch)
        rotation[:, list(settings.synthesize)] = corpus.regression(settings).rotations(vectors, whole)
    else:
        for index, joint in enumerate(settings.synthesize):
            rotation[:, joint] = corpus.charts[joint].rotations(whole[:, 3 * index : 3 * index + 3])
    legs: dict[int, Float64] = {}
    for index, joint in enumerate(settings.texture):
        change = detail[:, 3 * index : 3 * index + 3]
        if joint in LEGS:
            legs[joint] = change
        else:
            chart = corpus.charts[joint]
            rotation[:, joint] = chart.rotations(chart.angles(sketch.rotation[:, joint]) + change)
    if 0 in settings.texture:
        root = root + rotate_about_vertical(detail[:, -3:], headings(sketch.rotation[:, 0]))
    return apply_foot_constraints(sketch, root, rotation, legs, corpus.charts)


def _at_rate(tracks: Float64, sketch: Clip) -> Float64:
    """Resample tracks (T, C) from 24 Hz to the sketch's samples, by a cubic spline, because they lack band 1."""
    from scipy.interpolate import CubicSpline

    if not tracks.shape[1]:
        return np.zeros((sketch.sample_count, 0))
    at = np.arange(sketch.sample_count) / sketch.sample_rate
    return np.asarray(CubicSpline(np.arange(len(tracks)) / RATE, tracks)(at))
