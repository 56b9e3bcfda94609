"""What a cheap camera does to a picture: exposure, motion blur, rolling shutter, a soft lens, noise and compression.

Pictures are made of moments (sub-frames) in linear light: a row of the sensor adds up those in which it was exposed.
Shot noise and read noise follow the usual model of a sensor (EMVA standard 1288), in electrons.
"""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import av
import numpy as np

from live.base.arrays import Float32, Float64, UInt8

_LINEAR: Final = (np.linspace(0.0, 1.0, 256) ** 2.2).astype(np.float32)
_STEPS: Final = 4096
_DISPLAYED: Final = np.rint(255.0 * np.linspace(0.0, 1.0, _STEPS) ** (1.0 / 2.2)).astype(np.uint8)


@dataclass(frozen=True, slots=True)
class Sensor:
    """One camera's faults; the default is a webcam in good light."""

    shutter_s: float = 1 / 90
    """Time for which each row is exposed [s]."""
    readout_s: float = 0.012
    """Time from the exposure of the first row to that of the last [s]; 0: a global shutter."""
    moments: int = 3
    """Sub-frames of a picture; 1: neither blur nor rolling shutter."""
    electrons: float = 6000.0
    """Electrons of a white pixel: fewer are noisier."""
    read_noise: float = 6.0
    """Noise of reading a pixel, standard deviation [electrons]."""
    exposure: float = 1.0
    """Factor of the light: above 1 what is bright is clipped."""
    softness: float = 0.25
    """Share of its light that a pixel gives to its neighbours in each direction, both together."""
    kilobits: float = 1500.0
    """Rate of the compressed film [kbit/s]."""


WEBCAM: Final = Sensor()
"""A webcam in good light."""
IDEAL: Final = Sensor(moments=1, electrons=0.0, read_noise=0.0, softness=0.0, kilobits=20_000.0)
"""No faults: `electrons` of 0 mean no noise."""


def moment_times(sensor: Sensor) -> Float64:
    """Return the times of sub-frames relative to the middle of the exposure of the picture's middle row [s], (K,)."""
    if sensor.moments == 1:
        return np.zeros(1)
    span = sensor.shutter_s + sensor.readout_s
    return (np.arange(sensor.moments) + 0.5) / sensor.moments * span - 0.5 * span


def row_weights(sensor: Sensor, rows: int) -> Float32:
    """Return how much of each sub-frame each row holds, (K, rows); the sum over sub-frames is 1."""
    if sensor.moments == 1:
        return np.ones((1, rows), np.float32)
    span = sensor.shutter_s + sensor.readout_s
    half = 0.5 * span / sensor.moments
    middle = ((np.arange(rows) + 0.5) / rows - 0.5) * sensor.readout_s
    begin, end = middle - 0.5 * sensor.shutter_s, middle + 0.5 * sensor.shutter_s
    times = moment_times(sensor)[:, None]
    weights = np.clip(np.minimum(end, times + half) - np.maximum(begin, times - half), 0.0, None)
    return np.asarray(weights / weights.sum(axis=0), np.float32)


class SensorPicture:
    """Makes a camera's pictures from sub-frames of (height, width) pixels; reused from picture to picture."""

    def __init__(self, sensor: Sensor, size: tuple[int, int], seed: int) -> None:
        self._sensor = sensor
        self._weights = row_weights(sensor, size[1])[:, :, None, None]
        self._light = np.zeros((size[1], size[0], 3), np.float32)
        self._chance = np.random.default_rng((seed, 35))
        self._moment = 0

    def add(self, picture: UInt8) -> None:
        """Add the next sub-frame, (height, width, 3), displayed values."""
        if self._moment == 0:
            self._light.fill(0.0)
        self._light += _LINEAR[picture] * self._weights[self._moment]
        self._moment = (self._moment + 1) % len(self._weights)

    def develop(self) -> UInt8:
        """Return the picture of the sub-frames, (height, width, 3), displayed values."""
        sensor, light = self._sensor, self._light
        if sensor.softness > 0.0:
            light = _soft(light, sensor.softness)
        light = light * np.float32(sensor.exposure)
        if sensor.electrons > 0.0:
            variance = light / np.float32(sensor.electrons) + np.float32((sensor.read_noise / sensor.electrons) ** 2)
            light = light + np.sqrt(variance) * self._chance.standard_normal(light.shape, np.float32)
        return np.asarray(_DISPLAYED[(np.clip(light, 0.0, 1.0) * (_STEPS - 1)).astype(np.int32)])


def _soft(light: Float32, share: float) -> Float32:
    """Return a picture in which pixels give `share` of their light to the neighbours above and below, then beside."""
    for axis in (0, 1):
        sides = np.pad(light, [(1, 1) if axis == one else (0, 0) for one in range(3)], mode="edge")
        count = light.shape[axis]
        before, after = sides.take(range(count), axis=axis), sides.take(range(2, count + 2), axis=axis)
        light = (1.0 - share) * light + 0.5 * share * (before + after)
    return np.asarray(light, np.float32)


class CompressedFilm:
    """An H.264 film at a low rate, as a webcam or a phone gives it; the same pictures give the same bytes."""

    def __init__(self, path: Path, size: tuple[int, int], fps: float, kilobits: float) -> None:
        self._container: Any = av.open(str(path), "w")
        rate = Fraction(fps).limit_denominator(1001)
        self._stream: Any = self._container.add_stream("libx264", rate=rate)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._stream.bit_rate = round(kilobits * 1000.0)
        self._stream.options = {"preset": "veryfast", "tune": "zerolatency", "threads": "1"}
        self._stream.codec_context.thread_count = 1

    def write(self, picture: UInt8) -> None:
        """Add a picture, (height, width, 3)."""
        for packet in self._stream.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), "rgb24")):
            self._container.mux(packet)

    def close(self) -> None:
        """Complete the film."""
        for packet in self._stream.encode():
            self._container.mux(packet)
        self._container.close()
