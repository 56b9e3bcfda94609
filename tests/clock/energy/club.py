"""Seeded club music: grooves, breaks, build-ups and drops at known beats."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Sound = npt.NDArray[np.float32]
BPM = 120.0
BEAT = 60.0 / BPM


def club(parts: Sequence[tuple[str, int]], rate: int = 44_100, gain: float = 0.3, seed: int = 0) -> Sound:
    """Parts, each a kind and a number of beats of half a second; returns shape (n,).

    `groove`: bass drum, bass, hi-hats. `half`: the same with a bass drum on every fourth beat only. `break`: chords
    and hi-hats without bass. `build`: a roll that doubles and a noise that rises and opens. `silence`.
    """
    rng = np.random.default_rng(seed)
    pieces = [_part(kind, beats, rate, rng) for kind, beats in parts]
    sound = gain * np.concatenate(pieces)
    return (sound + rng.normal(0.0, 1e-5, sound.size)).astype(np.float32)


def _part(kind: str, beats: int, rate: int, rng: np.random.Generator) -> npt.NDArray[np.float64]:
    n = round(beats * BEAT * rate)
    sound = np.zeros(n + rate)
    t = np.arange(n) / rate
    kick_t = np.arange(int(0.3 * rate)) / rate
    kick = np.sin(2 * np.pi * (50 * kick_t + 4 * (1 - np.exp(-kick_t / 0.03)))) * np.exp(-kick_t / 0.1)
    if kind == "silence":
        return sound[:n]
    if kind in ("groove", "half"):
        for beat in range(beats):
            if kind == "groove" or beat % 4 == 0:
                _add(sound, beat * BEAT, kick, rate)
            _add(sound, (beat + 0.5) * BEAT, 0.3 * _hat(rate, rng), rate)
        if kind == "groove":
            sound[:n] += 0.3 * np.sin(2 * np.pi * 55 * t) * (0.6 + 0.4 * np.sin(2 * np.pi * t / BEAT))
        sound[:n] += _chord(t)
    elif kind == "break":
        for beat in range(beats):
            _add(sound, (beat + 0.5) * BEAT, 0.3 * _hat(rate, rng), rate)
        sound[:n] += _chord(t)
    elif kind == "build":
        at = 0.0
        while at < beats:
            rise = at / beats
            _add(sound, at * BEAT, (0.1 + 0.4 * rise) * _hat(rate, rng, 0.03), rate)
            at += 0.5 if rise < 0.4 else 0.25 if rise < 0.75 else 0.125
        noise = rng.normal(0.0, 1.0, n)
        spectrum = np.fft.rfft(noise)
        high = np.fft.irfft(spectrum * (np.fft.rfftfreq(n, 1 / rate) > 3000), n)
        middle = np.fft.irfft(
            spectrum * ((np.fft.rfftfreq(n, 1 / rate) > 300) & (np.fft.rfftfreq(n, 1 / rate) < 3000)), n
        )
        x = np.arange(n) / n
        sound[:n] += 0.05 * (0.3 + x) * middle + 0.25 * x**2 * high
        sound[:n] += 0.7 * _chord(t)
    return sound[:n]


def _chord(t: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.asarray(sum(0.05 * np.sin(2 * np.pi * f * t + f) for f in (220.0, 277.2, 329.6, 440.0)))


def _hat(rate: int, rng: np.random.Generator, decay: float = 0.02) -> npt.NDArray[np.float64]:
    t = np.arange(int(0.1 * rate)) / rate
    return np.diff(rng.normal(0.0, 1.0, t.size + 1)) * np.exp(-t / decay)


def _add(sound: npt.NDArray[np.float64], at: float, what: npt.NDArray[np.float64], rate: int) -> None:
    start = round(at * rate)
    sound[start : start + what.size] += what[: max(sound.size - start, 0)]
