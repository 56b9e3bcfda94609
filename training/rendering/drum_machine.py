"""Drums made from nothing: membranes, noises and metals with drawn tunings, so that no font's kit is all there is."""

from random import Random

import numpy as np
from scipy import signal

from training.music.piece import Sounding
from training.rendering.synth import RATE, Mono

_LOW, _TOMS = (
    (35, 36, 41, 64, 66, 86),
    {43: 0.0, 45: 0.15, 47: 0.3, 48: 0.45, 50: 0.6, 60: 1.0, 61: 0.7, 63: 0.5, 65: 0.8},
)
_NOISY = (38, 40, 25, 27, 28)
_WOODEN = {37: 1700.0, 31: 2100.0, 75: 2500.0, 76: 1500.0, 77: 1100.0, 33: 1800.0}
_METALS = {42: 0.05, 44: 0.04, 46: 0.5, 49: 1.6, 51: 0.9, 52: 1.2, 53: 0.8, 55: 0.7, 57: 1.8, 59: 1.0}
_SHAKEN = (54, 58, 69, 70, 71, 73, 74, 82)


class DrumMachine:
    """One drawn kit. `strike` gives the sound of a pitch; made when first asked for."""

    def __init__(self, rng: Random) -> None:
        self._draw = np.random.default_rng(rng.getrandbits(64))
        self._made: dict[int, Mono] = {}
        self.body = rng.uniform(42, 80)  # Hz of the kick
        self.snare = rng.uniform(150, 260)
        self.skin = rng.uniform(80, 140)
        self.sizzle = rng.uniform(3500, 9000)
        self.length = rng.uniform(0.5, 1.6)
        self.ring = rng.random() < 0.5  # harmonic partials, as of a tabla

    def strike(self, pitch: int) -> Mono:
        if pitch not in self._made:
            self._made[pitch] = self._make(pitch)
        return self._made[pitch]

    def _make(self, pitch: int) -> Mono:
        if pitch in _LOW:
            return self._membrane(self.body * (1.4 if pitch in (64, 66) else 1.0), 0.28, 2.5, 0.25)
        if pitch in _NOISY:
            return self._membrane(self.snare, 0.12, 0.4, 0.1) * 0.6 + self._noise(0.16, 900, 9000)
        if pitch in _TOMS:
            return self._membrane(self.skin * 2 ** (1.4 * _TOMS[pitch]), 0.3, 0.5, 0.2)
        if pitch in _WOODEN:
            return self._membrane(_WOODEN[pitch] * self.length, 0.03, 0.0, 0.3)
        if pitch in _METALS:
            return self._metal(_METALS[pitch])
        if pitch in _SHAKEN:
            return self._noise(0.05, self.sizzle * 0.6, 14000)
        if pitch == 39:
            return sum(
                (np.roll(self._noise(0.12, 700, 5000), shift) for shift in (0, 400, 900)), np.zeros(RATE, np.float32)
            )
        return self._membrane(440 * 2 ** ((pitch - 60) / 12), 0.15, 0.1, 0.15)

    def _times(self, seconds: float) -> np.ndarray:
        return np.arange(int(max(1.0, seconds * 4) * RATE)) / RATE

    def _membrane(self, base: float, decay: float, sweep: float, click: float) -> Mono:
        """Partials that die away, a pitch that falls, a click of the stick."""
        times = self._times(decay)
        decay = decay * self.length
        phase = 6.2832 * base * (times + sweep * 0.03 * (1 - np.exp(-times / 0.03)))
        ratios = (1, 2, 3, 4.01) if self.ring else (1, 1.59, 2.14, 2.65)
        sound = sum(
            0.6**order * np.sin(ratio * phase) * np.exp(-times * (1 + 0.7 * order) / decay * 2)
            for order, ratio in enumerate(ratios)
        )
        stick = self._draw.standard_normal(len(times)) * np.exp(-times / 0.004) * click
        return np.asarray((sound + stick) * np.minimum(1, times / 0.0008), np.float32)

    def _noise(self, decay: float, low: float, high: float) -> Mono:
        times = self._times(decay)
        noise = self._draw.standard_normal(len(times)) * np.exp(-times / (decay * self.length) * 2.5)
        band = signal.butter(1, (low, min(high, 0.45 * RATE)), "band", output="sos", fs=RATE)
        return np.asarray(signal.sosfilt(band, noise), np.float32)

    def _metal(self, decay: float) -> Mono:
        """Squares of unrelated pitches and noise, high-passed."""
        times = self._times(decay * 0.5)
        waves = sum(
            np.sign(np.sin(6.2832 * self.sizzle * ratio * times)) for ratio in (0.31, 0.43, 0.57, 0.71, 0.83, 1.0)
        )
        rough = (0.15 * waves + self._draw.standard_normal(len(times))) * np.exp(-times / (decay * self.length) * 2.5)
        return np.asarray(
            signal.sosfilt(signal.butter(2, self.sizzle * 0.8, "high", output="sos", fs=RATE), rough) * 0.5, np.float32
        )


def play(rng: Random, notes: list[Sounding], seconds: float) -> Mono:
    """These notes on a drawn kit; each stroke a little different in level."""
    machine = DrumMachine(rng)
    sound = np.zeros(int(seconds * RATE) + 12 * RATE, np.float32)
    for note in notes:
        start = int(note.time * RATE)
        stroke = machine.strike(note.pitch)
        if 0 <= start < len(sound) - len(stroke):
            level = (note.velocity / 127) ** 1.7 * rng.uniform(0.9, 1.1) * 0.25
            sound[start : start + len(stroke)] += level * stroke
    return sound[: int(seconds * RATE)]
