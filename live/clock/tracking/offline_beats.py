"""Beats and measure lines of a whole piece, from the network's probabilities, with the future known (T007).

The most probable sequence of beat intervals, and then of beats in measures, is found by dynamic programming over the
model of the live tracker (Krebs, Böck and Widmer, ISMIR 2015; Viterbi 1967). What a person corrected is certain.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.clock.bar_pointer.metre import FIRST_SLOT, METRES, metre_shares
from live.clock.bar_pointer.observation_model import MIN_PROBABILITY
from live.clock.bar_pointer.state_space import BarPointerModel

TEMPO_CHANGE: Final = 100.0
"""As in the model; a whole piece shows more clearly than its past how constant its tempo is."""
HALF_BEAT: Final = 0.3
"""Exponent of a beat's likelihood in the middle between beats."""
LEAST_METRE: Final = 1e-3
"""Least prior of a metre that a person gave for some of the measures."""
DOWNBEAT_SHARPNESS: Final = 0.5
TEMPO_JUMP: Final = 1e-4
"""Probability at each beat of any other tempo; these were chosen on 15 of the 29 songs of a test set."""
CERTAIN: Final = 60.0
"""Log-odds of what a person said."""
QUIET: Final = 6
"""Frames to each side of a beat that a person gave in which there is no other."""
REFINE: Final = 3
"""Frames to each side of a beat in which its exact time is looked for."""
OFF_BEAT: Final = (0.35, 0.65)
"""A beat that lies so far between two found ones says that the off-beats were taken for the beats."""
LOW_BPM, HIGH_BPM = 38.0, 260.0


@dataclass(frozen=True, slots=True)
class Activations:
    """Probabilities of a beat and of a downbeat in each frame, shape (T,), with their times [s]."""

    time: Float64
    beat: Float64
    downbeat: Float64


@dataclass(frozen=True, slots=True)
class Beats:
    """Beats of a piece."""

    time: Float64
    """Their times [s], (B,)."""
    number: npt.NDArray[np.int64]
    """Position of each in its measure, from 0, (B,)."""
    metre: npt.NDArray[np.int64]
    """Beats of the measure that it belongs to, (B,)."""


def find_beats(
    activations: Activations,
    *,
    bpm_range: tuple[float, float] = (LOW_BPM, HIGH_BPM),
    downbeats: Sequence[float] = (),
    metres: Sequence[tuple[float, int]] = (),
) -> Beats:
    """Return the beats of a whole piece.

    A person may limit the tempo [bpm], give times of `downbeats` [s], and metres: from a time [s] on, so many beats.
    ValueError if no tempo lies in the range.
    """
    model = BarPointerModel()
    time, beat, downbeat = activations.time, activations.beat.copy(), activations.downbeat.copy()
    given = sorted({int(np.abs(time - each).argmin()) for each in downbeats}) if time.size else []
    if time.size < 2:
        return Beats(np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int64))
    plain = _beat_frames(_log_odds(beat, model), model, bpm_range)
    for frame in given:
        around = slice(max(frame - QUIET, 0), frame + QUIET + 1)
        beat[around] = np.minimum(beat[around], model.beat_share / 4.0)
        beat[frame] = downbeat[frame] = 1.0 - MIN_PROBABILITY
    frames = plain
    if given and not _on_off_beat(plain, given[0]):
        odds = _log_odds(beat, model)
        odds[given] += CERTAIN
        frames = _beat_frames(odds, model, bpm_range)
    elif given:
        frames = _shifted(plain, given[0], time.size)
    times = _refined(frames, activations, np.array(given, np.int64))
    slots = _measure_slots(frames, times, beat, downbeat, given, metres, model)
    return Beats(times, np.array([k for _, k in slots], np.int64), np.array([m for m, _ in slots], np.int64))


def _log_odds(beat: Float64, model: BarPointerModel) -> Float64:
    """Return the log-likelihood ratio of a beat in each frame, (T,)."""
    chance = np.clip(beat, MIN_PROBABILITY, 1.0 - MIN_PROBABILITY)
    odds = chance / (1.0 - chance) * (1.0 - model.beat_share) / model.beat_share
    result: Float64 = np.log(np.clip(odds**model.sharpness, model.ratio_min, model.ratio_max))
    return result


def _beat_frames(odds: Float64, model: BarPointerModel, bpm_range: tuple[float, float]) -> npt.NDArray[np.int64]:
    """Return the frames of the most probable sequence of beats, (B,)."""
    shortest, longest = (60.0 * model.frame_rate / bpm for bpm in reversed(bpm_range))
    kept = (model.intervals >= math.floor(shortest)) & (model.intervals <= math.ceil(longest))
    lengths = model.intervals[kept].astype(np.int64)
    if lengths.size == 0:
        raise ValueError(f"no tempo between {bpm_range[0]:g} and {bpm_range[1]:g} bpm can be followed")
    observed = np.convolve(odds, np.array(model.window)[::-1], "same")
    start, each = np.log(model.tempo_share()[kept] + 1e-12), np.log(model.tempo_weight()[kept])
    change = np.exp(-TEMPO_CHANGE * np.abs(lengths[np.newaxis, :] / lengths[:, np.newaxis] - 1.0))
    change /= change.sum(axis=1, keepdims=True)
    into = np.log((1.0 - TEMPO_JUMP) * change + TEMPO_JUMP / lengths.size).T.astype(np.float32)  # [to, from]
    count, tempi = odds.size, lengths.size
    best = np.full((count, tempi), -1e30, np.float32)  # a beat in this frame, and its interval since the one before
    source = np.full((count, tempi), -1, np.int16)
    rows = np.arange(tempi)
    for frame in range(count):
        score = np.where(frame <= lengths, start, -1e30)
        before = frame - lengths
        there = rows[before >= 0]
        if there.size:
            past = before[there]
            chances = best[past] + into[there]
            chosen = chances.argmax(axis=1)
            value = chances[rows[: there.size], chosen] + each[there] + HALF_BEAT * observed[past + lengths[there] // 2]
            better = value > score[there]
            score[there[better]] = value[better]
            source[frame, there[better]] = chosen[better]
        best[frame] = score + observed[frame]
    ends = [(float(best[frame, k]), frame, int(k)) for k in rows for frame in range(max(count - lengths[k], 0), count)]
    _, at, tempo = max(ends)
    found = [at]
    while (former := int(source[at, tempo])) >= 0:
        at, tempo = at - int(lengths[tempo]), former
        found.append(at)
    return np.array(found[::-1], np.int64)


def _on_off_beat(frames: npt.NDArray[np.int64], given: int) -> bool:
    """Return whether a given beat lies in the middle between two found ones."""
    index = int(np.searchsorted(frames, given))
    if not 0 < index < frames.size:
        return False
    share = (given - frames[index - 1]) / (frames[index] - frames[index - 1])
    return bool(OFF_BEAT[0] <= share <= OFF_BEAT[1])


def _shifted(frames: npt.NDArray[np.int64], given: int, count: int) -> npt.NDArray[np.int64]:
    """Return the frames in the middle between beats, all shifted alike so that one is the given frame."""
    index = int(np.searchsorted(frames, given))
    share = (given - frames[index - 1]) / (frames[index] - frames[index - 1])
    gaps = np.diff(frames)
    moved = frames + np.rint(share * np.append(gaps, gaps[-1])).astype(np.int64)
    first = moved[0] - gaps[0]
    moved = np.concatenate([[first], moved]) if first >= 0 else moved
    return moved[moved < count]


def _refined(frames: npt.NDArray[np.int64], activations: Activations, given: npt.NDArray[np.int64]) -> Float64:
    """Return the times of beats: the centre of the probabilities around each frame; of given ones, the frame's."""
    weight = np.array(BarPointerModel().window)
    found = activations.time[frames].astype(np.float64)
    for row, frame in enumerate(frames.tolist()):
        low, high = max(frame - REFINE, 0), min(frame + REFINE + 1, activations.time.size)
        near = activations.beat[low:high] ** 2 * weight[low - frame + REFINE : high - frame + REFINE]
        if near.sum() > 1e-3 and frame not in given:
            found[row] = float((activations.time[low:high] * near).sum() / near.sum())
    return found


def _measure_slots(
    frames: npt.NDArray[np.int64], times: Float64, beat: Float64, downbeat: Float64, given: Sequence[int],
    metres: Sequence[tuple[float, int]], model: BarPointerModel,
) -> list[tuple[int, int]]:  # fmt: skip
    """Return metre and position in the measure of each beat: the most probable sequence of measures."""
    known = sorted({metre.beats for metre in model.metres} | {beats for _, beats in metres})
    shares = {beats: max(share, LEAST_METRE) for beats, share in zip(METRES, metre_shares(model.metres), strict=True)}
    slots = [(metre, k) for metre in known for k in range(metre)]
    metre_of, position = (np.array(column) for column in zip(*slots, strict=True))
    first = np.empty(frames.size)
    for row, frame in enumerate(frames.tolist()):
        low = max(frame - 2, 0)
        peak = low + int(beat[low : frame + 3].argmax())
        first[row] = downbeat[peak] / max(beat[peak], MIN_PROBABILITY)
    first = np.clip(first, 0.02, 0.98)[:, np.newaxis]
    one = DOWNBEAT_SHARPNESS * np.log(first / model.downbeat_share)
    other = DOWNBEAT_SHARPNESS * np.log((1.0 - first) / (1.0 - model.downbeat_share))
    of_slot = model.accents()
    accent = np.array([of_slot[FIRST_SLOT[METRES.index(m)] + k] if m in METRES else float(k == 0) for m, k in slots])
    observed = np.log(accent * np.exp(one) + (1.0 - accent) * np.exp(other))
    for frame in given:
        observed[np.abs(frames - frame).argmin(), position != 0] -= 1e9
    for row, time in enumerate(times.tolist()):
        wanted = [beats for begin, beats in sorted(metres) if begin <= time + 1e-6]
        if wanted:
            observed[row, metre_of != wanted[-1]] -= 1e6
    prior = np.log([shares.get(metre, LEAST_METRE) / metre for metre in metre_of.tolist()])
    return [slots[k] for k in _best_path(observed, prior, _slot_changes(slots, shares, model))]


def _slot_changes(slots: Sequence[tuple[int, int]], shares: dict[int, float], model: BarPointerModel) -> Float64:
    """Return the log-probabilities from each slot of a measure to each, (S, S)."""
    change = np.full((len(slots), len(slots)), math.log(model.line_change / len(slots)))
    for row, (metre, k) in enumerate(slots):
        for column, (other, position) in enumerate(slots):
            if k < metre - 1 and (other, position) == (metre, k + 1):
                change[row, column] = math.log(1.0 - model.line_change)
            elif k == metre - 1 and position == 0:
                same = other == metre
                chance = 1.0 - model.metre_change if same else model.metre_change * shares.get(other, LEAST_METRE)
                change[row, column] = math.log(chance)
    return change


def _best_path(observed: Float64, prior: Float64, change: Float64) -> list[int]:
    """Return the most probable sequence of states for log-likelihoods (T, S) (Viterbi 1967)."""
    score = prior + observed[0]
    source = np.zeros(observed.shape, np.int64)
    for row in range(1, observed.shape[0]):
        chances = score[:, np.newaxis] + change
        source[row] = chances.argmax(axis=0)
        score = chances.max(axis=0) + observed[row]
    path = [int(score.argmax())]
    for row in range(observed.shape[0] - 1, 0, -1):
        path.append(int(source[row, path[-1]]))
    return path[::-1]
