"""Simulated MIDI clock: seeded streams with jitter, bunching, losses and tempo changes."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

PULSES = 24
Message = tuple[int, ...]


@dataclass
class Stream:
    """Arrivals [(s, message)] in order, and the true beats: (s, beat of the song from 0, bpm)."""

    events: list[tuple[float, Message]] = field(default_factory=list)
    beats: list[tuple[float, int, float]] = field(default_factory=list)


def steady(bpm: float) -> Callable[[float], float]:
    return lambda _time: bpm


def ramp(bpm: float, to: float, begin: float, end: float) -> Callable[[float], float]:
    return lambda time: bpm + (to - bpm) * min(max((time - begin) / (end - begin), 0.0), 1.0)


def swing(bpm: float, share: float, seconds: float) -> Callable[[float], float]:
    return lambda time: bpm * (1.0 + share * math.sin(2.0 * math.pi * time / seconds))


def steps(*tempos: tuple[float, float]) -> Callable[[float], float]:
    """(from which second, bpm) in order."""
    return lambda time: next(bpm for begin, bpm in reversed(tempos) if time >= begin)


def delays(kind: str, scale: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """How late pulses arrive [s]: "uniform" 0 to 2 scale, "half-normal" and "exponential" of this scale, "stalls"."""
    if kind == "uniform":
        return rng.uniform(0.0, 2.0 * scale, count)
    if kind == "half-normal":
        return np.abs(rng.normal(0.0, scale, count))
    if kind == "exponential":
        return rng.exponential(scale, count)
    late = rng.uniform(0.0, 2.0 * scale, count)  # stalls: now and then the cable stands still for up to 80 ms
    late[rng.random(count) < 0.01] += rng.uniform(0.02, 0.08)
    return late


def make_stream(
    tempo: Callable[[float], float],
    *,
    seconds: float = 30.0,
    kind: str = "uniform",
    jitter: float = 0.0,
    frame: float = 0.0,
    dropouts: tuple[tuple[float, float], ...] = (),
    start_at: float | None = 0.5,
    seed: int = 0,
) -> Stream:
    """One song from `start_at` (None: never started), clocks from 0; arrivals are quantised up to `frame` [s]."""
    rng = np.random.default_rng(seed)
    stream, sent, bpms = Stream(), [], []
    time = 0.0
    while time < seconds:
        sent.append(time)
        bpms.append(tempo(time))
        time += 60.0 / (tempo(time) * PULSES)
    times = np.array(sent)
    arrivals = times + delays(kind, jitter, times.size, rng)
    if frame:
        arrivals = np.ceil(arrivals / frame - 1e-9) * frame
    arrivals = np.maximum.accumulate(arrivals)
    first = times.size if start_at is None else int(np.searchsorted(times, start_at))
    for number in range(times.size):
        if number == first:
            just_before = (times[number - 1] + times[number]) / 2 if number else 0.0
            stream.events.append((max(just_before, arrivals[number - 1] if number else 0.0), (0xFA,)))
        if not any(begin <= times[number] < end for begin, end in dropouts):
            stream.events.append((float(arrivals[number]), (0xF8,)))
        if number >= first and (number - first) % PULSES == 0:
            stream.beats.append((float(times[number]), (number - first) // PULSES, bpms[number]))
    return stream
