"""Evaluation of the MIDI clock decoder: replays a recorded clock and measures the errors of its beats."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.clock.midi.midi_clock import ClockBeat, ClockEvent, ClockState, MidiClock

CHECK_INTERVAL: Final = 0.1
"""Seconds between two checks for missing pulses."""

MAX_EXTRAPOLATED_BEATS: Final = 20_000
"""Maximum number of beats extrapolated from one estimate (some hours), for recordings that were left on."""

MAX_CHECKS: Final = 100
"""Maximum number of checks in one gap; further ones find nothing new."""

SETTLING_BEATS: Final = 8
"""Beats after a start or jump from which on tempo and phase errors count."""

TEMPO_STEP: Final = 0.05
TEMPO_TOLERANCE: Final = 0.01
"""Relative tempo changes: a larger change than the first is a step, a smaller error than the second is correct."""


@dataclass(frozen=True, slots=True)
class DecodedBeat:
    """A beat as last reported by the decoder before it fell."""

    time: float
    emitted: float
    """Time of that report [s]."""
    bpm: float
    beat: int
    """From 0; -1 if unknown."""
    measure: int
    """From 0; -1 if unknown."""
    first_time: float
    """Its predicted time a whole beat ahead [s]; NaN if it was not reported then."""


@dataclass(frozen=True, slots=True)
class TrueBeat:
    """A beat of the ground truth: seconds, beat of its measure from 0, bpm."""

    time: float
    beat: int
    bpm: float


@dataclass(frozen=True, slots=True)
class ClockErrors:
    """Errors against the ground truth. Milliseconds after removal of the mean delay; tempo in bpm; shares of all
    beats."""

    beats: int
    found: float
    """Share of the true beats with a reported beat within 70 ms."""
    extra: int
    """Reported beats without a true one."""
    measure_right: float
    """Share of the true beats whose number in the measure was correct."""
    mean_delay_ms: float
    phase_p95_ms: float
    phase_max_ms: float
    ahead_p95_ms: float
    """95th percentile of the errors of predictions a whole beat ahead."""
    tempo_p95_bpm: float
    tempo_max_bpm: float
    step_beats: int
    """Maximum number of beats until the tempo was within 1 % after a true tempo step; 0 without steps."""


@dataclass(frozen=True, slots=True)
class ClockReport:
    """Decoded beats, states and counters of a message stream."""

    beats: tuple[DecodedBeat, ...]
    states: tuple[ClockState, ...]
    pulses: int
    lost: int
    rejected: int


def replay(messages: Iterable[tuple[float, Sequence[int]]], *, beats_per_measure: int = 4) -> ClockReport:
    """Decode (arrival [s], bytes) in order, with the periodic checks that the watching thread makes."""
    clock = MidiClock(beats_per_measure=beats_per_measure)
    news: list[ClockEvent] = []
    looked, pulses, time = 0.0, 0, 0.0
    for time, message in messages:
        for _ in range(MAX_CHECKS):
            if looked + CHECK_INTERVAL >= time:
                break
            looked += CHECK_INTERVAL
            news += clock.advance(looked)
        else:
            looked = max(looked, time - CHECK_INTERVAL)
        news += clock.receive(message, time)
        pulses += bool(message) and message[0] == 0xF8
    states = tuple(item for item in news if isinstance(item, ClockState))
    return ClockReport(
        tuple(_decoded_beats(news, time, beats_per_measure)), states, pulses, clock.train.lost, clock.rejected
    )


def _decoded_beats(news: Sequence[ClockEvent], end: float, beats_per_measure: int) -> Iterable[DecodedBeat]:
    """Return the beats that fell, each by the last estimate before it; during a loss the last estimate is
    extrapolated."""
    estimate: ClockBeat | None = None
    first: dict[int, float] = {}
    number = 0
    for item in [*news, ClockState(end, "stopped")]:
        if isinstance(item, ClockState):
            if item.state == "stopped" and estimate is not None:
                yield from _until(estimate, number, item.time, first, beats_per_measure)
                estimate, first = None, {}
            continue
        own = item.measure * beats_per_measure + item.beat if item.anchored else _next(estimate, number, item)
        if estimate is not None:
            jumped = item.jump or item.anchored != estimate.anchored
            until = item.time - 0.5 * item.period / 24.0 if jumped else math.inf
            if jumped:
                own = own if item.anchored else 0
                yield from _until(estimate, number, until, first, beats_per_measure)
                first = {}
            else:
                yield from _up_to(estimate, number, own, first, beats_per_measure)
        if item.beat_time - item.time > 0.9 * item.period:
            first.setdefault(own, item.beat_time)
        estimate, number = item, own


def _next(estimate: ClockBeat | None, number: int, item: ClockBeat) -> int:
    """Number beats without a number by their time."""
    return 0 if estimate is None else number + round((item.beat_time - estimate.beat_time) / item.period)


def _up_to(estimate: ClockBeat, number: int, end: int, first: dict[int, float], metre: int) -> Iterable[DecodedBeat]:
    for beat in range(number, min(end, number + MAX_EXTRAPOLATED_BEATS)):
        yield _beat(estimate, number, beat, first, metre)


def _until(estimate: ClockBeat, number: int, end: float, first: dict[int, float], metre: int) -> Iterable[DecodedBeat]:
    count = math.ceil((end - estimate.beat_time) / estimate.period)
    yield from _up_to(estimate, number, number + count, first, metre)


def _beat(estimate: ClockBeat, number: int, beat: int, first: dict[int, float], metre: int) -> DecodedBeat:
    return DecodedBeat(
        time=estimate.beat_time + (beat - number) * estimate.period,
        emitted=estimate.time,
        bpm=60.0 / estimate.period,
        beat=beat % metre if estimate.anchored else -1,
        measure=beat // metre if estimate.anchored else -1,
        first_time=first.get(beat, math.nan),
    )


def clock_errors(
    beats: Sequence[DecodedBeat], truth: Sequence[TrueBeat], *, within: float = 0.07
) -> ClockErrors | None:
    """Compare reported beats with the true ones; None if there is no true beat or none was found."""
    times = np.array([beat.time for beat in beats])
    pairs = []
    for true in truth:
        index = int(np.argmin(np.abs(times - true.time))) if times.size else -1
        if index >= 0 and abs(times[index] - true.time) <= min(within, 20.0 / true.bpm):
            pairs.append((beats[index], true))
    if not pairs:
        return None
    settled = _settled([true for _, true in pairs])
    delay = np.array([beat.time - true.time for beat, true in pairs])
    ahead = np.array([beat.first_time - true.time for beat, true in pairs])[settled]
    tempo = np.abs(np.array([beat.bpm - true.bpm for beat, true in pairs]))[settled]
    phase = np.abs(delay - delay.mean())[settled]
    begin = truth[0].time - within
    inside = [beat for beat in beats if beat.beat >= 0 and begin <= beat.time <= truth[-1].time + within]
    return ClockErrors(
        beats=len(truth),
        found=len(pairs) / len(truth),
        extra=len(inside) - len({id(beat) for beat, _ in pairs}),
        measure_right=sum(beat.beat == true.beat for beat, true in pairs) / len(truth),
        mean_delay_ms=1e3 * float(delay.mean()),
        phase_p95_ms=1e3 * _p95(phase),
        phase_max_ms=1e3 * float(phase.max()),
        ahead_p95_ms=1e3 * _p95(np.abs(ahead - delay.mean())),
        tempo_p95_bpm=_p95(tempo),
        tempo_max_bpm=float(tempo.max()),
        step_beats=_step_beats(pairs),
    )


def _settled(truth: Sequence[TrueBeat]) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    """Mark the beats at least `SETTLED` beats after the last jump of the truth; if none is, the last one."""
    count, settled = 0, []
    for index, true in enumerate(truth):
        before = truth[index - 1]
        if index and abs(true.time - before.time - 60.0 / before.bpm) > 0.25 * 60.0 / before.bpm:
            count = 0
        settled.append(count >= SETTLING_BEATS)
        count += 1
    return np.array(settled if any(settled) else [*([False] * (len(truth) - 1)), True])


def _p95(values: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> float:
    values = values[np.isfinite(values)]
    return float(np.percentile(values, 95)) if values.size else math.nan


def _step_beats(pairs: Sequence[tuple[DecodedBeat, TrueBeat]]) -> int:
    """Return the largest number of beats with a wrong tempo after a step of the true tempo."""
    worst = 0
    for index in range(1, len(pairs)):
        now, was = pairs[index][1].bpm, pairs[index - 1][1].bpm
        if abs(now / was - 1.0) <= TEMPO_STEP:
            continue
        wrong = 0
        for beat, true in pairs[index:]:
            if abs(beat.bpm / true.bpm - 1.0) <= TEMPO_TOLERANCE:
                break
            wrong += 1
        worst = max(worst, wrong)
    return worst
