"""Clap detection and clap sync (T018, Fig 2.4).

Claps are sharp minima of the distance between the hands. Sync decides which claps are the count and where the music
begins in the recording.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion.beats.beat_grid_fit import MAX_DISTANCE, BeatFit, fit_free_period, fit_known_period
from live.motion.beats.music_reference import BPM_RANGE, MusicReference
from live.motion.retarget.body_tracks import BodyTracks

Int = npt.NDArray[np.int64]

MAX_PALM_DISTANCE: Final = 0.22
"""Palms nearer than this [m] may touch: the hand's centre is off the palm, and retargeting adds distance."""
MIN_OPENING: Final = 0.07
"""Minimum distance [m] by which the hands separate before and after, within `REACH`."""
OPENING_WINDOW: Final = 0.4
"""Window before and after a clap [s]."""
MIN_CLOSING_SPEED: Final = 0.5
"""Minimum closing speed just before [m/s]."""
MIN_SHARPNESS: Final = 0.9
"""Minimum change of the distance's slope [m/s] from just before to just after: a V, not a U."""
FIT_SECONDS: Final = 0.03
"""Seconds on each side over which the sides of the V are fitted; at least two frames."""
MIN_REBOUND_COSINE: Final = 0.2
"""Minimum cosine between the directions before and after: clapping hands bounce back, passing hands cross."""
MIN_INTERVAL: Final = 0.12
"""Minimum time between two claps [s]."""


@dataclass(frozen=True, slots=True)
class Clap:
    """One clap."""

    time_s: float
    """Time of contact with subframe precision, from the first kept frame [s]."""
    distance_m: float
    """Smallest recorded distance of the palms."""
    sharpness: float
    """Change of the distance's slope [m/s]."""


def find_claps(tracks: BodyTracks, start: int = 0) -> list[Clap]:
    """Return all candidate claps from frame `start` on, in order.

    The time of contact is where lines through the frames on both sides of the V meet. If the hands rest on each other,
    it is where the first line reaches that distance. The sync functions decide which candidates are claps.
    """
    apart = tracks.palms[start:, 0] - tracks.palms[start:, 1]
    distance = np.linalg.norm(apart, axis=-1)
    found: list[Clap] = []
    for frame in _minima(distance):
        clap = _clap(apart, distance, int(frame), tracks.rate)
        if clap is None:
            continue
        if found and clap.time_s - found[-1].time_s < MIN_INTERVAL:
            if clap.sharpness > found[-1].sharpness:
                found[-1] = clap
            continue
        found.append(clap)
    return found


def _minima(distance: Float64) -> Int:
    """Return frames that are lower than the one before and not higher than the one after."""
    if distance.size < 5:
        return np.zeros(0, np.int64)
    down = distance[1:-1] < distance[:-2]
    up = distance[1:-1] <= distance[2:]
    low = distance[1:-1] < MAX_PALM_DISTANCE
    return np.flatnonzero(down & up & low) + 1


def _clap(apart: Float64, distance: Float64, frame: int, rate: float) -> Clap | None:
    side, reach = max(2, round(FIT_SECONDS * rate)), max(3, round(OPENING_WINDOW * rate))
    end = frame  # of the frames in which the hands rest on each other
    while (
        end + 1 < distance.size and abs(distance[end + 1] - distance[frame]) < 0.1 * MIN_OPENING and end - frame < reach
    ):
        end += 1
    if frame < side + 1 or end + side + 1 >= distance.size:
        return None
    before, after = distance[max(frame - reach, 0) : frame], distance[end + 1 : end + 1 + reach]
    if min(before.max(), after.max()) - distance[frame] < MIN_OPENING:
        return None
    closing, opening = _line(distance, frame - side, frame, rate), _line(distance, end + 1, end + side + 1, rate)
    turn = opening[0] - closing[0]
    if -closing[0] < MIN_CLOSING_SPEED or turn < MIN_SHARPNESS:
        return None
    ways = apart[frame - side], apart[end + side]
    cosine = float(ways[0] @ ways[1]) / max(float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1])), 1e-9)
    if cosine < MIN_REBOUND_COSINE:
        return None
    if end - frame >= 2:
        time = (float(np.median(distance[frame : end + 1])) - closing[1]) / closing[0]
    else:
        time = (closing[1] - opening[1]) / turn
    if not frame - 1.5 <= time * rate <= frame + 1.5:
        return None
    return Clap(float(time), float(distance[frame]), float(turn))


def _line(distance: Float64, first: int, stop: int, rate: float) -> tuple[float, float]:
    """Return slope [m/s] and value at time 0 [m] of the line through frames `first` to `stop` - 1."""
    time = np.arange(first, stop) / rate
    middle = time.mean()
    slope = float(((time - middle) * distance[first:stop]).sum() / ((time - middle) ** 2).sum())
    return slope, float(distance[first:stop].mean()) - slope * float(middle)


SCATTER: Final = 0.03
"""Scatter of claps about the beat [s] that reduces confidence by a third."""
MAX_GAP_BEATS: Final = 4.5
"""Maximum gap within a count [beats]."""
MIN_CLAPS: Final = 4
"""Minimum claps of a count without a click."""
GROUP_PAUSE: Final = 5.0
"""Claps after a pause of this length [s] are another count, or part of the dance."""
CLAPS_PER_MISS: Final = 4
"""Without a click, a count may leave out one of its beats for every so many claps after the first two."""
MAX_STRAY_SHARE: Final = 0.25
"""Most touches off the beat within such a count, as a share of its claps."""
MAX_COUNT_SCATTER: Final = 0.04
"""Largest scatter [s] of such a count about the beat."""
MAX_CLAPS: Final = 64
"""Maximum claps per group and maximum groups, to bound the run time."""
MAX_SONG_CLAPS: Final = 24
"""Maximum claps matched to a song's first beats."""
FIRST_COUNT_SHARE: Final = 0.75
"""The first count is chosen if its score is at least this share of the best: people clap before they dance."""
TEMPO_TOLERANCE: Final = 0.03
"""If the tempo of the claps differs by more than this share from the click's, the frame rate is doubtful."""


@dataclass(frozen=True, slots=True)
class AssignedClap:
    """A clap and its assignment to a beat."""

    clap: Clap
    beat: int | None
    """Number of its beat, from 1 for the first beat of the count (or of the song); None if it is on no beat."""
    residual_ms: float | None
    """Lateness relative to the nearest beat [ms]; None without beats."""


@dataclass(frozen=True, slots=True)
class ClapSync:
    """A music reference with the claps it is derived from."""

    reference: MusicReference
    claps: tuple[AssignedClap, ...]


def sync_to_click(claps: list[Clap], bpm: float, count: int | None = None) -> ClapSync | None:
    """Sync the claps as a count of `count` beats to a click of `bpm`; None if no clap fits.

    The tempo is the click's; the offset is that of most claps. The first beat is the first beat of the count, clapped
    or not: with `count`, the run of that many beats with most claps (the first of several); without, the first clap.
    """
    if not claps:
        return None
    period = 60.0 / bpm
    fits = [
        fit_known_period(times, period) for times in _groups(_times(claps), max(GROUP_PAUSE, MAX_GAP_BEATS * period))
    ]
    fit = _extend_fit(_select_fit(fits), _times(claps))
    first, own = _count(fit, count)
    confidence = _confidence(fit, own, count or _span(own))
    notes = [_summary(own, count, fit)]
    free = sync_to_claps(claps)
    if (
        free is not None
        and abs(free.reference.bpm / bpm - 1.0) > TEMPO_TOLERANCE
        and free.reference.confidence > confidence
    ):
        confidence *= 0.2
        notes.append(f"the claps themselves are at {free.reference.bpm:.1f} bpm: is the frame rate right?")
    return _build_sync(claps, fit, first, own, MusicReference(0.0, bpm, confidence, "click", "; ".join(notes)))


def sync_to_claps(claps: list[Clap]) -> ClapSync | None:
    """Sync by claps alone: tempo from the claps, first beat at the first clap; None if they are no count.

    A count has at least four claps at an even tempo, few of its beats are left out, and few touches lie between them.
    Hands that touch now and then in a dance agree with some tempo, too, but leave most of its beats out.
    """
    fits = [fit_free_period(times) for times in _groups(_times(claps), GROUP_PAUSE)]
    agreeing = [fit for fit in fits if fit is not None and _is_count(fit)]
    if not agreeing:
        return None
    fit = _extend_fit(_select_fit(agreeing), _times(claps))
    first, own = _count(fit, None)
    bpm = min(max(60.0 / fit.period_s, BPM_RANGE[0]), BPM_RANGE[1])
    confidence = _confidence(fit, own, _span(own))
    return _build_sync(claps, fit, first, own, MusicReference(0.0, bpm, confidence, "claps", _summary(own, None, fit)))


def _is_count(fit: BeatFit) -> bool:
    _, own = _count(fit, None)
    if own.size < MIN_CLAPS or _span(own) - own.size > (own.size - 2) // CLAPS_PER_MISS:
        return False
    inside = (fit.numbers >= own[0]) & (fit.numbers <= own[-1])
    return int((inside & ~fit.on_beat).sum()) <= MAX_STRAY_SHARE * own.size and fit.rms_s <= MAX_COUNT_SCATTER


def _groups(times: Float64, pause: float) -> list[Float64]:
    """Return groups of claps between pauses, each cut to the longest plausible count."""
    groups = np.split(times, np.flatnonzero(np.diff(times) > pause) + 1) if times.size else []
    return [group[:MAX_CLAPS] for group in groups[:MAX_CLAPS]]


def _select_fit(fits: list[BeatFit]) -> BeatFit:
    """Return the first fit that is nearly as good as the best."""
    worth = [
        float(np.exp(-0.5 * (fit.residuals[fit.on_beat] / SCATTER) ** 2).sum()) - 0.5 * int((~fit.on_beat).sum())
        for fit in fits
    ]
    return next(
        fit for fit, one in zip(fits, worth, strict=True) if one >= FIRST_COUNT_SHARE * max(worth) or one == max(worth)
    )


def _extend_fit(fit: BeatFit, times: Float64) -> BeatFit:
    """Return the fit of one group applied to all claps; claps of other groups are not on its beats."""
    numbers = np.round((times - fit.offset_s) / fit.period_s).astype(np.int64)
    late = times - fit.offset_s - numbers * fit.period_s
    own = np.isin(times, fit.times[fit.on_beat])
    return BeatFit(times, fit.offset_s, fit.period_s, numbers, late, own)


def sync_to_song(claps: list[Clap], beats: Float64, beats_per_measure: int = 4) -> ClapSync | None:
    """Sync the claps to the first beats of a song with beats at `beats` [s of the song]; None if no clap fits.

    Recording and song run at the same speed. The chosen offset between them puts most claps on beats and leaves fewest
    beats between claps empty. If the song's tempo is so even that several offsets fit, the first clap is the song's
    first beat. The reference's tempo is that of a line through the song's beats; its first beat is the first one inside
    the recording that is whole measures after the song's first.
    """
    if not claps or beats.size < 2:
        return None
    times = _times(claps)
    offset = _song_offset(times[:MAX_SONG_CLAPS], beats[: 8 * MAX_SONG_CLAPS + MAX_CLAPS])
    places = beats + offset
    after = np.clip(np.searchsorted(places, times), 1, places.size - 1)
    nearest = np.where(times - places[after - 1] < places[after] - times, after - 1, after)
    late = times - places[nearest]
    period = float(np.median(np.diff(beats)))
    belongs = np.abs(late) <= min(MAX_DISTANCE, 0.2 * period)
    if not belongs.any():
        return None
    shift = float(np.mean(late[belongs]))
    places, late = places + shift, late - shift
    fit = BeatFit(times, float(places[0]), period, nearest.astype(np.int64), late, belongs)
    own = np.unique(fit.numbers[belongs])
    slope, start = np.polyfit(np.arange(beats.size), places, 1)
    first = 0
    while start + first * slope < -0.5 * slope:
        first += beats_per_measure
    notes = [_summary(own, None, fit), f"the song begins at {offset + shift:+.3f} s of the recording"]
    if _is_even(beats, times.size):
        notes.append(f"its tempo is even: the first clap is assigned to its beat {int(own[0]) + 1}")
    confidence = _confidence(fit, own, _span(own))
    reference = MusicReference(
        max(0.0, float(start + first * slope)), 60.0 / float(slope), confidence, "song", "; ".join(notes)
    )
    return ClapSync(reference, _assign_claps(claps, fit, 0, own))


def _song_offset(times: Float64, beats: Float64) -> float:
    """Return the offset [s] that puts most claps on beats; of equal ones the earliest in the song."""
    best, best_worth = 0.0, -np.inf
    for number, beat in enumerate(beats[: 4 * times.size + 64]):
        for time in times:
            places = beats + (time - beat)
            late = np.abs(times[:, None] - places).min(axis=1)
            hits = np.exp(-0.5 * (late / SCATTER) ** 2).sum()
            inside = int(((places > times[0] - MAX_DISTANCE) & (places < times[-1] + MAX_DISTANCE)).sum())
            skipped = int((places < times[0] - MAX_DISTANCE).sum())
            worth = hits - 0.3 * max(inside - times.size, 0) - 0.02 * skipped - 1e-6 * number
            if worth > best_worth:
                best, best_worth = float(time - beat), worth
    return best


def _is_even(beats: Float64, count: int) -> bool:
    """Whether the song's beats shifted by one still match, over as many beats as were clapped."""
    some = np.diff(beats[: count + 2])
    return bool(some.size < 2 or np.abs(some - some.mean()).sum() < MAX_DISTANCE)


def _count(fit: BeatFit, count: int | None) -> tuple[int, Int]:
    """Return the number of the count's first beat, and its clapped beats."""
    beats = np.unique(fit.numbers[fit.on_beat])
    if count is not None:
        held = [int(((beats >= first) & (beats < first + count)).sum()) for first in beats]
        first = int(beats[int(np.argmax(held))])
        return first, np.asarray(beats[(beats >= first) & (beats < first + count)])
    runs = np.split(beats, np.flatnonzero(np.diff(beats) > MAX_GAP_BEATS) + 1)
    run = max(runs, key=len)
    return int(run[0]), np.asarray(run)


def _span(own: Int) -> int:
    return int(own[-1] - own[0]) + 1 if own.size else 0


def _confidence(fit: BeatFit, own: Int, count: int) -> float:
    """Return the clapped share of the count, reduced for scatter, few claps, and stray touches between claps."""
    inside = (fit.numbers >= own[0]) & (fit.numbers <= own[-1])
    strays = int((inside & ~fit.on_beat).sum())
    late = fit.residuals[fit.on_beat & np.isin(fit.numbers, own)]
    scatter = float(np.sqrt(np.mean(late**2))) if late.size > 1 else SCATTER
    few = own.size / (own.size + 1.0)
    return float(
        own.size
        / max(count, own.size)
        * few
        * own.size
        / (own.size + 0.5 * strays)
        / (1 + 0.5 * (scatter / SCATTER) ** 2)
    )


def _summary(own: Int, count: int | None, fit: BeatFit) -> str:
    of = f" of {count}" if count is not None else ""
    strays = int((~fit.on_beat).sum())
    words = f"{own.size}{of} beats clapped, {1e3 * fit.rms_s:.0f} ms about the beat"
    return words + (f", {strays} other touches left out" if strays else "")


def _build_sync(claps: list[Clap], fit: BeatFit, first: int, own: Int, reference: MusicReference) -> ClapSync:
    start = max(0.0, fit.offset_s + first * fit.period_s)
    return ClapSync(replace(reference, first_beat_s=float(start)), _assign_claps(claps, fit, first, own))


def _assign_claps(claps: list[Clap], fit: BeatFit, first: int, own: Int) -> tuple[AssignedClap, ...]:
    beats = set(own.tolist())
    return tuple(
        AssignedClap(clap, int(number) - first + 1 if belongs and int(number) in beats else None, 1e3 * float(late))
        for clap, number, belongs, late in zip(claps, fit.numbers, fit.on_beat, fit.residuals, strict=True)
    )


def _times(claps: list[Clap]) -> Float64:
    return np.array([clap.time_s for clap in claps], np.float64)
