"""What else is heard: pink noise, babble of a crowd, applause, whoops; all made of noise."""

import numpy as np
from scipy import signal

from training.rendering.synth import RATE, Mono


def pink(rng: np.random.Generator, count: int) -> Mono:
    """Noise of equal power per octave."""
    white = rng.standard_normal(count).astype(np.float32)
    b, a = [0.049922, -0.095993, 0.050613, -0.004409], [1, -2.494956, 2.017266, -0.522190]
    return np.asarray(signal.lfilter(b, a, white), np.float32)


def babble(rng: np.random.Generator, count: int) -> Mono:
    """A crowd talking: noise in vowel bands, each voice with syllables of its own; made at a quarter of the rate."""
    few = count // 4 + 1
    total = np.zeros(few, np.float32)
    noise = rng.standard_normal(2 * few).astype(np.float32)
    for _ in range(rng.integers(5, 12)):
        knots = max(4, int(count / RATE * rng.uniform(3, 6)))
        gates = np.clip(rng.normal(0.3, 0.6, knots), 0, None)
        envelope = np.interp(np.linspace(0, knots - 1, few), np.arange(knots), gates)
        formant = rng.uniform(250, 2600)
        own = noise[(start := int(rng.integers(0, few))) : start + few]
        band = signal.butter(1, (formant * 0.7, formant * 1.4), "band", output="sos", fs=RATE / 4)
        total += (signal.sosfilt(band, own) * envelope).astype(np.float32)
    return np.asarray(signal.resample_poly(total, 4, 1)[:count], np.float32)


def applause(rng: np.random.Generator, count: int) -> Mono:
    """Many hands: short noise bursts at random times, more and fewer as time goes on."""
    rate = rng.uniform(40, 300)
    strikes = (rng.random(count) < rate / RATE) * rng.uniform(0.2, 1, count)
    decay = np.exp(-np.arange(600) / rng.uniform(60, 200)) * rng.standard_normal(600)
    found = signal.oaconvolve(strikes, decay)[:count]
    band = signal.butter(1, (rng.uniform(500, 1200), rng.uniform(2500, 7000)), "band", output="sos", fs=RATE)
    swell = np.interp(np.linspace(0, 6, count), np.arange(7), rng.uniform(0.2, 1.0, 7))
    return np.asarray(signal.sosfilt(band, found) * swell, np.float32)


def crackle(rng: np.random.Generator, count: int) -> Mono:
    """A worn record: clicks, and a hiss under them."""
    clicks = (rng.random(count) < rng.uniform(3, 40) / RATE) * rng.exponential(1.0, count) * rng.choice([-1, 1], count)
    short = signal.lfilter([1.0], [1.0, -rng.uniform(0.3, 0.8)], clicks)
    return np.asarray(short + 0.01 * rng.standard_normal(count), np.float32)


def add(sound: Mono, noise: Mono, snr: float) -> Mono:
    """The sum, with so many dB from sound to noise (mean power of the parts that sound)."""
    loud = np.sqrt(np.mean(sound**2) + 1e-12)
    return np.asarray(sound + noise * (loud / (np.sqrt(np.mean(noise**2)) + 1e-9) * 10 ** (-snr / 20)), np.float32)
