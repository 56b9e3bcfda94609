"""The sound of a made-up band: kick, snare and hat, enough for a beat tracker and a pair of ears."""

import wave
from itertools import takewhile
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.rehearse.band import FakeBand, Played

Float32 = npt.NDArray[np.float32]
RATE: Final = 44100


def sound_of(band: FakeBand, seconds: float, *, seed: int = 0) -> Float32:
    """The band's first `seconds`, mono at RATE, shape (samples,), within [-1, 1]."""
    chance = np.random.default_rng([seed, 0x50BD])
    out = np.zeros(int(seconds * RATE), np.float32)
    kick, snare, hat = _kick(), _noise(chance, 0.16, 0.05), _noise(chance, 0.05, 0.012)
    for played in takewhile(lambda beat: beat.time < seconds, band.played()):
        for when, sound, level in _strokes(played, chance, kick, snare, hat):
            begin = int(when * RATE)
            end = min(begin + len(sound), len(out))
            if 0 <= begin < end:
                out[begin:end] += level * sound[: end - begin]
    peak = float(np.abs(out).max()) if len(out) else 0.0
    return out / np.float32(max(peak * 1.05, 1e-6))


def _strokes(
    played: Played, chance: np.random.Generator, kick: Float32, snare: Float32, hat: Float32
) -> list[tuple[float, Float32, float]]:
    """Kick on the one and in the middle, snare between, hats on eighths; in a fill the snare alone, in sixteenths."""
    time, period = played.time, played.period
    if played.fill:
        places = time + period * (np.arange(4) + chance.uniform(-0.08, 0.08, 4)) / 4.0
        return [(float(place), snare, float(chance.uniform(0.3, 0.8))) for place in places]
    strokes = [(time, hat, 0.35), (time + 0.5 * period, hat, 0.25)]
    if played.beat % 2 == 0:
        strokes.append((time, kick, 1.0 if played.beat == 0 else 0.8))
    else:
        strokes.append((time, snare, 0.6))
    return strokes


def write_sound(path: Path, sound: Float32) -> None:
    """Write it as a 16-bit WAV file. OSError if that cannot be."""
    with wave.open(str(path), "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE)
        out.writeframes((np.clip(sound, -1.0, 1.0) * 32767.0).astype("<i2").tobytes())


def _kick() -> Float32:
    time = np.arange(int(0.25 * RATE)) / RATE
    sweep = 2.0 * np.pi * (48.0 * time + 90.0 * 0.03 * (1.0 - np.exp(-time / 0.03)))
    return (np.sin(sweep) * np.exp(-time / 0.08)).astype(np.float32)


def _noise(chance: np.random.Generator, seconds: float, decay: float) -> Float32:
    time = np.arange(int(seconds * RATE)) / RATE
    return (chance.standard_normal(len(time)) * np.exp(-time / decay) * 0.4).astype(np.float32)
