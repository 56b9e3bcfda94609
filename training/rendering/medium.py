"""Media that change time: vinyl wow, a pitch fader; the sound is resampled and the times of the beats with it."""

import numpy as np

from training.rendering.synth import RATE, Mono


class Warp:
    """Playback at a changing speed. `at` maps seconds of the original to seconds heard."""

    def __init__(self, speed: np.ndarray, seconds: float) -> None:
        knots = np.linspace(0, seconds, len(speed))
        heard = np.concatenate([[0.0], np.cumsum(np.diff(knots) / (0.5 * (speed[1:] + speed[:-1])))])
        self._knots, self._heard = knots, heard

    def at(self, times: np.ndarray) -> np.ndarray:
        return np.asarray(np.interp(times, self._knots, self._heard))

    def play(self, sound: Mono) -> Mono:
        heard = np.arange(int(self._heard[-1] * RATE)) / RATE
        source = np.interp(heard, self._heard, self._knots) * RATE
        return np.asarray(np.interp(source, np.arange(len(sound)), sound), np.float32)


def wow(rng: np.random.Generator, seconds: float) -> Warp:
    """An eccentric record: the speed swings once per turn by up to 1.5 %, and drifts."""
    times = np.linspace(0, seconds, int(seconds * 100))
    turn = rng.choice([33.333, 45.0]) / 60
    swing = rng.uniform(0.002, 0.015) * np.sin(6.2832 * (turn * times + rng.random()))
    drift = rng.normal(0, 0.005) + rng.uniform(0, 0.004) * np.sin(6.2832 * (times / rng.uniform(5, 30) + rng.random()))
    return Warp(1 + swing + drift, seconds)


def fader(rng: np.random.Generator, seconds: float) -> Warp:
    """A disc jockey's pitch fader: moved by up to 8 % once or several times, smoothly or at once."""
    times = np.linspace(0, seconds, int(seconds * 100))
    speed = np.full(len(times), 1 + rng.uniform(-0.08, 0.08))
    for _ in range(rng.integers(1, 4)):
        start, span = rng.uniform(0, seconds), rng.choice([0.1, 1.0, 4.0, 12.0])
        speed += rng.uniform(-0.06, 0.06) * np.clip((times - start) / span, 0, 1)
    return Warp(np.clip(speed, 0.8, 1.25), seconds)
