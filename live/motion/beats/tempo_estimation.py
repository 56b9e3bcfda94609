"""Tempo and beat estimation from feet and bounce for dances without claps; the user confirms the result.

A dance repeats after one, two, four and eight beats. The autocorrelation of foot speed and bounce gives the beat period
up to octaves. Landings give the phase, and the difference between the beats of a measure gives the first beat.

Partner dances step quick, quick, slow, so they repeat every two beats. For recordings with varying tempo the phase of
that component is tracked; its lines mark where each two beats begin.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.beats.dance_rhythm import Rhythm, find_rhythm, gaussian_smooth
from live.motion.beats.music_reference import MusicReference
from live.motion.clip import Clip

PERIODS: Final = (0.3, 1.0)
"""Seconds per beat: 200 to 60 bpm."""
CANDIDATES: Final = 600
REPEATS: Final = ((1, 1.0), (2, 1.0), (4, 1.0), (8, 1.0))
"""Lags [beats] at which a dance repeats, with weights."""
DETREND_SECONDS: Final = 1.0
"""Width [s] of the smoothing whose result is subtracted first: slower changes are no beats."""
LONGEST_LAG: Final = 6.2
"""Longest lag of the autocorrelation [s] (eight beats at 77 bpm)."""
MAX_LAG_SHARE: Final = 0.7
"""Longest lag as a share of the clip: beyond it the overlap is too short."""
USUAL_BPM: Final = 118.0
"""Of fitting octaves the one nearest to this tempo is chosen, as in the beat tracker."""
OCTAVE_SLACK: Final = 0.03
"""Relative tolerance of a peak at half or twice the period."""
PERIOD_TOLERANCE: Final = 0.02
"""Maximum relative correction of the period, so that all landings of the clip fall on beats."""
MAX_CONFIDENCE: Final = 0.6
"""Maximum confidence of an estimate."""
DECELERATION_LEAD: Final = 0.09
"""Beats from a foot's strongest deceleration to its contact (from sketched steps, which land exactly on the beat)."""
MIN_LANDING_STRENGTH: Final = 0.35
"""Below this length of the mean phase vector landings are random, and the period is not corrected."""
MIN_CONTACT_AGREEMENT: Final = 0.4
"""Minimum length of the landings' mean phase vector for them to correct the phase."""
MIN_CLIP_SECONDS: Final = 2.5
"""Minimum length of a clip for an estimate [s]."""


@dataclass(frozen=True, slots=True)
class TempoEstimate:
    """A tempo estimate with its evidence."""

    reference: MusicReference
    repetition: float
    """How well the dance repeats (mean autocorrelation over 1, 2, 4 and 8 beats), -1 to 1."""
    landing: float
    """How well feet land on the beats (length of the mean phase vector), 0 to 1."""
    contrast: float
    """Variance between the beats of a measure as a share of the total variance, 0 to 1."""
    other_bpm: tuple[float, ...]
    """Other possible tempi, best first."""


def estimate_tempo(clip: Clip, beats_per_measure: int = 4, bpm: float | None = None) -> TempoEstimate | None:
    """Estimate tempo, first beat and confidence; None for a clip that is too short or does not move.

    If the tempo is known (`bpm`, from a click) only the first beat is estimated.
    """
    if clip.sample_count < MIN_CLIP_SECONDS * clip.sample_rate:
        return None
    rhythm = find_rhythm(clip)
    repeats = _repetition(rhythm)
    if repeats is None:
        return None
    periods, scores = repeats
    peaks = _peaks(scores)
    if not peaks:
        return None
    best = _octave(periods, peaks) if bpm is None else 60.0 / bpm
    period, landing, phase = _fit_landings(rhythm, best, PERIOD_TOLERANCE if bpm is None else 0.0)
    first, contrast = _first_beat(rhythm, period, phase, beats_per_measure)
    repetition = float(scores[peaks[0]] if bpm is None else np.interp(best, periods, scores))
    confidence = MAX_CONFIDENCE * float(np.clip(repetition / 0.4, 0.0, 1.0)) ** 0.5 * (0.5 + 0.5 * landing)
    others = tuple(round(60.0 / float(periods[p]), 1) for p in peaks if abs(periods[p] / best - 1.0) > OCTAVE_SLACK)[:3]
    note = (
        f"guessed from the feet, to be confirmed: {rhythm.contact_times.size} landings, {rhythm.motion_beats.size} "
        f"motion beats, repetition {repetition:.2f}"
        + (f"; or {', '.join(f'{bpm:g}' for bpm in others)} bpm" if others else "")
    )
    reference = MusicReference(first, 60.0 / period, confidence, "feet", note)
    return TempoEstimate(reference, repetition, landing, contrast, others)


FEET_REPETITION: Final = 0.1
"""Least repetition of a dance whose feet can contradict another tempo: free dances have less."""
SAME_TEMPO: Final = 0.04
"""Tempi that differ by less than this share are the same."""
SIMPLE_RATIOS: Final = (0.25, 1 / 3, 0.5, 2 / 3, 0.75, 1.0, 4 / 3, 1.5, 2.0, 3.0, 4.0)
"""Ratios of the feet's tempo to the music's: feet may step on every second beat, or three times in two beats."""


def feet_contradict(estimate: TempoEstimate, bpm: float, ratios: Sequence[float] = (0.5, 1.0, 2.0)) -> bool:
    """Whether the feet repeat at another tempo than `bpm`; `ratios` to it that agree: octaves, unless given.

    Feet that hardly repeat contradict nothing.
    """
    if estimate.repetition < FEET_REPETITION:
        return False
    off = min(abs(math.log(estimate.reference.bpm / (bpm * ratio))) for ratio in ratios)
    return off > math.log1p(SAME_TEMPO)


def _repetition(rhythm: Rhythm) -> tuple[Float64, Float64] | None:
    """Return candidate periods [s] and the repetition score of each, both (CANDIDATES,)."""
    periods = np.geomspace(*PERIODS, CANDIDATES)
    longest = int(min(LONGEST_LAG, MAX_LAG_SHARE * rhythm.seconds) * rhythm.rate)
    curves = [_autocorrelation(signal, rhythm.rate, longest) for signal in (rhythm.foot_speed, rhythm.bounce)]
    known = [curve for curve in curves if curve is not None]
    if not known:
        return None
    curve = np.mean(known, axis=0)
    total, weights = np.zeros(CANDIDATES), np.zeros(CANDIDATES)
    for beats, weight in REPEATS:
        lag = beats * periods * rhythm.rate
        seen = lag <= longest - 1
        total += np.where(seen, weight * np.interp(lag, np.arange(longest), curve), 0.0)
        weights += np.where(seen, weight, 0.0)
    return periods, np.asarray(total / np.maximum(weights, 1e-9))


def _autocorrelation(signal: Float64, rate: float, longest: int) -> Float64 | None:
    """Return the normalised autocorrelation for lags from 0 to `longest` - 1 samples; None for a constant signal."""
    changes = signal - gaussian_smooth(signal, DETREND_SECONDS * rate)
    changes -= changes.mean()
    if float(changes.std()) < 1e-4:
        return None
    spectrum = np.fft.rfft(changes, 2 * changes.size)
    raw = np.fft.irfft(np.abs(spectrum) ** 2)[:longest]
    overlap = 1.0 - np.arange(longest) / changes.size
    return np.asarray(raw / raw[0] / overlap)


def _peaks(scores: Float64) -> list[int]:
    """Return the indices of local maxima, highest first."""
    inner = np.flatnonzero((scores[1:-1] > scores[:-2]) & (scores[1:-1] >= scores[2:])) + 1
    return [int(p) for p in inner[np.argsort(-scores[inner], kind="stable")]]


def _octave(periods: Float64, peaks: list[int]) -> float:
    """Return the period of the best peak, or half or twice that if it has a peak and is nearer to the usual tempo."""
    best = float(periods[peaks[0]])
    related = [best]
    for period in (0.5 * best, 2.0 * best):
        if any(abs(periods[p] / period - 1.0) < OCTAVE_SLACK for p in peaks):
            related.append(period)
    return min(related, key=lambda period: abs(np.log2(60.0 / period / USUAL_BPM)))


def _fit_landings(rhythm: Rhythm, period: float, fine: float) -> tuple[float, float, float]:
    """Return the period corrected by the landings, how well they fit (0 to 1), and the phase of the beats [s].

    The relative correction is at most `fine`. Feet decelerate before contact, so the phase is taken from the contacts
    if they agree.
    """
    time = np.arange(rhythm.foot_deceleration.size) / rhythm.rate
    # neighbours differ by an eighth of a beat over the whole clip at most, or the best would lie between them
    count = 1 + 2 * max(40, int(8.0 * fine * rhythm.seconds / period)) if fine else 1
    tries = period * (1.0 + np.linspace(-fine, fine, count))
    vectors = np.array([np.exp((-2j * np.pi / one) * time) @ rhythm.foot_deceleration for one in tries])
    vectors /= max(float(rhythm.foot_deceleration.sum()), 1e-9)
    lengths = np.abs(vectors)
    best = int(np.argmax(lengths))
    if lengths[best] < MIN_LANDING_STRENGTH:
        best = tries.size // 2
    exact, landing = float(tries[best]), float(np.abs(vectors[best]))
    phase = (DECELERATION_LEAD - float(np.angle(vectors[best])) / (2.0 * np.pi)) * exact
    if rhythm.contact_times.size >= 4:
        mean = complex(np.mean(np.exp(2j * np.pi * (rhythm.contact_times - phase) / exact)))
        if abs(mean) >= MIN_CONTACT_AGREEMENT:
            phase += float(np.angle(mean)) / (2.0 * np.pi) * exact
    return exact, landing, phase % exact


def _first_beat(rhythm: Rhythm, period: float, phase: float, beats_per_measure: int) -> tuple[float, float]:
    """Return the time of the first beat of the first whole measure [s], and the contrast of the measure's beats.

    Dancers rest before a measure begins (salsa holds its fourth beat): the beat after the one with the least footwork
    is the first.
    """
    beats = np.arange(phase, rhythm.seconds - period, period)
    if beats.size < 2 * beats_per_measure:
        return phase, 0.0
    edges = np.concatenate(([0.0], np.cumsum(rhythm.foot_speed))) / rhythm.rate
    places = np.arange(edges.size) / rhythm.rate
    work = np.interp(beats + 0.25 * period, places, edges) - np.interp(beats - 0.75 * period, places, edges)
    measures = beats.size // beats_per_measure
    folded = work[: measures * beats_per_measure].reshape(measures, beats_per_measure)
    means = folded.mean(axis=0)
    total = float(folded.var())
    contrast = float(means.var()) / total if total > 1e-12 else 0.0
    first = (int(np.argmin(means)) + 1) % beats_per_measure
    return float(beats[first]), contrast


STEADY_SECONDS: Final = 60.0
"""A recording up to this long [s] is taken to keep its tempo."""
LINE_SMOOTHING: Final = 8.0
"""Standard deviation of the window in which the phase of the beats is tracked [s]."""
MAX_TEMPO_CHANGE: Final = 0.08
"""Largest relative change of tempo that is followed."""
TRIED_PERIODS: Final = 33
WINDOW_HALF: Final = 10.0
WINDOW_STEP: Final = 2.5
"""Periods tried in each window, half its length and the distance of windows [s]."""
CHANGE_COST: Final = 4.0
"""What a change of the period between windows costs: a tenth of a wave's strength for 2.5 per cent."""
FOLLOWER_INTERVAL: Final = 0.1
"""Interval at which the tempo is limited [s]."""
MIN_GAIN: Final = 0.1
"""How much better landings have to fit the followed beats than even ones (length of the mean phase vector)."""


def track_lines(clip: Clip, reference: MusicReference, beats_per_measure: int) -> Float64:
    """Return the measure lines [s] of a recording whose tempo was guessed from its feet, (measures + 1,).

    Nobody keeps a tempo for half an hour: in a long recording the phase of the landings is followed. The lines are even
    in a short one, in one that does keep its tempo, and in one where there is nothing to follow.
    """
    period = 60.0 / reference.bpm
    even = np.arange(reference.first_beat_s, clip.seconds + 1e-9, period)
    if clip.seconds > STEADY_SECONDS:
        rhythm = find_rhythm(clip)
        tracked = _tracked_beats(rhythm, reference.first_beat_s, period)
        if len(tracked) > 1 and _strength(rhythm, tracked) > _strength(rhythm, even) + MIN_GAIN:
            even = tracked
    return np.asarray(even[: (len(even) - 1) // beats_per_measure * beats_per_measure + 1 : beats_per_measure])


def _strength(rhythm: Rhythm, beats: Float64) -> float:
    """Return how well feet land on `beats` [s], or always as far from them: the mean phase vector's length, 0 to 1."""
    time = np.arange(rhythm.foot_deceleration.size) / rhythm.rate
    inside = (time >= beats[0]) & (time <= beats[-1])
    landing = rhythm.foot_deceleration[inside]
    phase = np.interp(time[inside], beats, np.arange(len(beats)))
    return float(np.abs(landing @ np.exp(-2j * np.pi * phase)) / max(float(landing.sum()), 1e-9))


def _tracked_beats(rhythm: Rhythm, first: float, period: float) -> Float64:
    """Return beats [s] from `first` on that follow the landings, as a wave of about `period` [s] would."""
    time = np.arange(rhythm.foot_deceleration.size) / rhythm.rate
    near = np.cumsum(1.0 / _local_periods(rhythm, time, period)) / rhythm.rate
    wave = rhythm.foot_deceleration * np.exp(-2j * np.pi * near)
    wide = LINE_SMOOTHING * rhythm.rate
    read = gaussian_smooth(wave.real, wide) + 1j * gaussian_smooth(wave.imag, wide)
    heard = near + np.unwrap(np.angle(read)) / (2.0 * np.pi)
    at = np.arange(first, time[-1], FOLLOWER_INTERVAL)
    turns = np.interp(at, time, heard)
    least, most = (FOLLOWER_INTERVAL / period * (1.0 + sign * MAX_TEMPO_CHANGE) for sign in (-1, 1))
    for n in range(1, len(turns)):  # where the phase jumps the beats go over to it, no faster than a tempo changes
        turns[n] = turns[n - 1] + min(max(turns[n] - turns[n - 1], least), most)
    return np.asarray(np.interp(np.arange(turns[0], turns[-1], 1.0), turns, at)) if len(turns) else np.zeros(0)


def _local_periods(rhythm: Rhythm, time: Float64, period: float) -> Float64:
    """Return the period of the beats [s] at each `time` (T,), within MAX_TEMPO_CHANGE of `period`.

    Of all ways through periods whose waves fit the landings in windows, the best that changes little (Viterbi).
    """
    share = np.linspace(-MAX_TEMPO_CHANGE, MAX_TEMPO_CHANGE, TRIED_PERIODS)
    middles = np.arange(0.0, time[-1] + WINDOW_STEP, WINDOW_STEP)
    fit = np.zeros((len(middles), TRIED_PERIODS))
    for n, middle in enumerate(middles):
        own = slice(*np.searchsorted(time, (middle - WINDOW_HALF, middle + WINDOW_HALF)))
        part = rhythm.foot_deceleration[own] * np.cos(0.5 * np.pi * (time[own] - middle) / WINDOW_HALF)
        waves = np.exp((-2j * np.pi / period) * time[own, None] / (1.0 + share))
        fit[n] = np.abs(part @ waves) / max(float(part.sum()), 1e-9)
    change = CHANGE_COST * np.abs(share[:, None] - share)
    best, back = fit[0], np.zeros(fit.shape, np.int64)
    for n in range(1, len(fit)):
        ways = best[:, None] - change
        back[n] = ways.argmax(axis=0)
        best = ways.max(axis=0) + fit[n]
    chosen = np.zeros(len(fit), np.int64)
    chosen[-1] = int(best.argmax())
    for n in range(len(fit) - 1, 0, -1):
        chosen[n - 1] = back[n, chosen[n]]
    return np.asarray(np.interp(time, middles, period * (1.0 + share[chosen])))


SHORTEST_TWO_BEATS: Final = 0.6
LONGEST_TWO_BEATS: Final = 1.2
"""Seconds of two beats: 200 to 100 bpm."""
TWO_BEATS_TOLERANCE: Final = 0.06
"""Relative tolerance of a given duration of two beats."""
PHASE_SMOOTHING: Final = 2.5
"""Standard deviation of the window for the phase [s]."""
SLOW_HALF_WIDTH: Final = 0.5
"""Half the width [s] of the moving average that is subtracted first."""
MIN_TWO_BEATS: Final = 6.0
"""Minimum length of a recording in units of two beats."""
RELIABLE_STRENGTH: Final = 0.3
"""Minimum strength of reliable lines: noise has 0.2, salsa 0.4 to 0.6."""
PADDING: Final = 16
"""Zero padding of spectra, as a multiple of the recording's length."""


@dataclass(frozen=True, slots=True, eq=False)
class TwoBeatLines:
    """Lines at every second beat of a recording."""

    lines: Float64
    """Times at which two beats begin [s], ascending, (n,)."""
    strength: float
    """Amplitude of the component relative to a pure wave with the power of the signal, 0 to 1."""

    def beats(self, last: float) -> Float64:
        """Return lines and midpoints, extended by one line at each end, from 0 to `last` [s]."""
        length = float(np.diff(self.lines).mean())
        lines = np.concatenate((self.lines[:1] - length, self.lines, self.lines[-1:] + length))
        beats = np.sort(np.concatenate((lines, 0.5 * (lines[1:] + lines[:-1]))))
        return np.asarray(beats[(beats >= 0.0) & (beats <= last)])


def find_two_beat_lines(clips: Sequence[Clip], two_beats: float | None = None) -> TwoBeatLines | None:
    """Return the common lines of clips of one dance; None if they are too short or nothing moves.

    All clips have the same rate and start time. `two_beats` [s]: duration of two beats, if known.
    """
    rate = clips[0].sample_rate
    count = min(clip.sample_count for clip in clips)
    longest = LONGEST_TWO_BEATS if two_beats is None else two_beats * (1.0 + TWO_BEATS_TOLERANCE)
    if count < MIN_TWO_BEATS * longest * rate:
        return None
    signal = np.sum([_feet(clip, count) for clip in clips], axis=0)
    size = float(signal.std())
    if size < 1e-6:
        return None
    period = _period(signal / size, rate, two_beats)
    time = np.arange(count) / rate
    wave = signal / size * np.exp(-2j * np.pi * time / period)
    read = gaussian_smooth(wave.real, PHASE_SMOOTHING * rate) + 1j * gaussian_smooth(wave.imag, PHASE_SMOOTHING * rate)
    turns = np.maximum.accumulate(time / period + np.unwrap(np.angle(read)) / (2.0 * np.pi))
    whole = np.arange(np.ceil(turns[0]), np.floor(turns[-1]) + 1.0)
    lines = np.interp(whole, turns, time)
    strength = float(np.abs(read).mean() * np.sqrt(2.0))
    return TwoBeatLines(lines, strength) if len(lines) >= MIN_TWO_BEATS - 1.0 else None


def _feet(clip: Clip, count: int) -> Float64:
    """Return the foot speed without slow changes, normalised to unit deviation, (count,)."""
    feet = find_rhythm(clip).foot_speed[:count]
    half = max(1, round(SLOW_HALF_WIDTH * clip.sample_rate))
    mean = np.convolve(np.pad(feet, half, mode="edge"), np.full(2 * half + 1, 1.0 / (2 * half + 1)), mode="valid")
    return np.asarray((feet - mean) / max(float((feet - mean).std()), 1e-9))


def _period(signal: Float64, rate: float, two_beats: float | None) -> float:
    """Return the strongest period of a signal (T,) between the shortest and longest two beats, or near `two_beats`."""
    low, high = (
        (SHORTEST_TWO_BEATS, LONGEST_TWO_BEATS)
        if two_beats is None
        else (two_beats / (1.0 + TWO_BEATS_TOLERANCE), two_beats * (1.0 + TWO_BEATS_TOLERANCE))
    )
    size = PADDING * len(signal)
    strength = np.abs(np.fft.rfft(signal * np.hanning(len(signal)), size))
    hertz = np.fft.rfftfreq(size, 1.0 / rate)
    inside = np.flatnonzero((hertz >= 1.0 / high) & (hertz <= 1.0 / low))
    return float(1.0 / hertz[inside[int(np.argmax(strength[inside]))]])
