"""Soundtrack of a film: its music, a click track and tap-shoe sounds, synthesized without samples (T130)."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.base.stage_snapshot import StageView
from live.render.film.streams import FilmSound
from live.show.dancers.footfalls import Footfall, FootfallDetector
from live.show.show import Show

TAP_SECONDS: Final = 0.12
CLICK_SECONDS: Final = 0.035
ACCENT_HZ: Final = 1760.0
BEAT_HZ: Final = 1175.0
VARIANTS: Final = 6
"""Number of variants of each tap sound, so that unison taps do not sound mechanical."""


@dataclass(frozen=True, slots=True)
class _Plate:
    """Resonances of a part of the shoe, (frequency [Hz], decay [s], level): the metal plate and the wooden floor."""

    metal: tuple[tuple[float, float, float], ...]
    wood: tuple[tuple[float, float, float], ...]
    noise: float
    """Level of the noise at first contact."""


_BALL: Final = _Plate(
    metal=((2350.0, 0.012, 0.9), (3720.0, 0.008, 0.7), (5480.0, 0.005, 0.5)),
    wood=((310.0, 0.016, 0.45), (520.0, 0.010, 0.35)),
    noise=0.9,
)
_HEEL: Final = _Plate(
    metal=((1480.0, 0.016, 0.8), (2610.0, 0.010, 0.6), (4300.0, 0.005, 0.3)),
    wood=((165.0, 0.030, 0.9), (270.0, 0.020, 0.6)),
    noise=0.6,
)


def tap_voices(seed: int, rate: int) -> list[list[Float32]]:
    """Return VARIANTS sounds each for ball, heel and flat foot, of `TAP_SECONDS` at `rate` [Hz] with peak 1.

    The same seed gives the same sounds.
    """
    chance = np.random.default_rng([seed, 0x7A9])
    ball = [_strike(_BALL, chance, rate) for _ in range(VARIANTS)]
    heel = [_strike(_HEEL, chance, rate) for _ in range(VARIANTS)]
    late = max(1, round(0.002 * rate))  # heel and ball of a flat foot land slightly apart
    flat = [_normalize(h + 0.8 * np.concatenate((np.zeros(late), b[:-late]))) for b, h in zip(ball, heel, strict=True)]
    return [[voice.astype(np.float32) for voice in voices] for voices in (ball, heel, flat)]


def click_voices(rate: int) -> tuple[Float32, Float32]:
    """Return the clicks of a measure's first beat and of the other beats, at `rate` [Hz] with peak 1."""
    return _click(ACCENT_HZ, rate), _click(BEAT_HZ, rate)


def _strike(plate: _Plate, chance: np.random.Generator, rate: int) -> Float64:
    time = np.arange(round(TAP_SECONDS * rate)) / rate
    detune = 1.0 + 0.05 * chance.uniform(-1.0, 1.0)
    sound = plate.noise * np.diff(chance.standard_normal(len(time) + 1)) * np.exp(-time / 0.0015)
    for ring, spread in ((plate.metal, 0.03), (plate.wood, 0.06)):
        for frequency, decay, level in ring:
            hertz = frequency * detune * (1.0 + spread * chance.uniform(-1.0, 1.0))
            if hertz < 0.45 * rate:
                sound += level * np.sin(2.0 * math.pi * hertz * time) * np.exp(-time / decay)
    return _normalize(sound * _fade_out(len(time)))


def _click(hertz: float, rate: int) -> Float32:
    time = np.arange(round(CLICK_SECONDS * rate)) / rate
    sound = np.sin(2.0 * math.pi * hertz * time) * np.exp(-time / 0.007)
    return _normalize(sound * _fade_out(len(time))).astype(np.float32)


def _fade_out(count: int) -> Float64:
    return np.asarray(np.minimum(1.0, 8.0 * np.arange(count, 0, -1) / count))


def _normalize(sound: Float64) -> Float64:
    return np.asarray(sound / max(float(np.abs(sound).max()), 1e-9))


RATE: Final = 48000
"""Default sample rate, without music [Hz]."""
MAX_VOICES: Final = 64
"""Maximum number of simultaneous taps; further ones are dropped."""
CLICK_LEVEL: Final = 0.22
TAP_LEVEL: Final = 0.55
MUSIC_LEVEL: Final = 0.8
"""Level of the music when mixed with click or taps; alone it is unchanged."""
WIDTH: Final = 0.8
"""Stereo pan of a dancer at the edge of the stage, 0 to 1."""
MAX_LATENESS: Final = 0.5
"""Clicks and taps that are late by more than this are dropped [s]; others begin at once."""


class Soundtrack:
    """Mixer for a film's sound: call `frame` after each frame; the encoder reads `film`.

    Tap level grows with the number of dancers, but less than proportionally, and falls with the distance from the
    camera. Thread: `frame` on the main thread, reading on the encoder's.
    """

    def __init__(self, show: Show, music: FilmSound | None, *, click: bool, taps: bool, begin: float = 0.0) -> None:
        """`music`: from the start of the show; the film begins at `begin` [s]."""
        self._show = show
        self._music = music
        self.rate = RATE if music is None else music.rate
        self._click = click_voices(self.rate) if click else None
        self._taps = tap_voices(show.seed, self.rate) if taps else None
        self._falls = FootfallDetector(show) if taps else None
        camera = show.patch.camera
        self._eye = camera.eye
        self._usual_distance = math.dist(camera.eye, camera.target)
        self._share = TAP_LEVEL / len(show.group) ** 0.6
        self._voice_ends: deque[float] = deque()
        self.dropped_taps = 0
        """Taps dropped because all voices were in use."""
        self._samples_done = round(begin * self.rate)
        self._ahead: Float32 = np.zeros((0, 2), np.float32)
        self._ahead_taps: Float32 = np.zeros((0, 2), np.float32)
        self._blocks: deque[Float32] = deque()
        self._beat: float | None = None

    @property
    def film(self) -> FilmSound:
        """The mixed sound for the film's encoder, in two channels."""
        return FilmSound(self.rate, 2, self._read)

    def frame(self, view: StageView) -> None:
        """Mix the sound up to the time of this frame, which was just filled."""
        if self._click is not None:
            self._add_clicks(view)
        if self._falls is not None:
            for fall in self._falls.detect(view):
                self._add_tap(fall)
        self._finish(max(0, math.floor(view.time * self.rate) - self._samples_done))

    def _add_clicks(self, view: StageView) -> None:
        assert self._click is not None
        timeline = self._show.timeline
        first = timeline.beat_at(self._samples_done / self.rate) - 1e-6 if self._beat is None else self._beat
        for beat in range(math.floor(first) + 1, math.floor(view.beat + 1e-9) + 1):
            place = (beat - timeline.measure_origin) % timeline.beats_per_measure
            accent = min(place, timeline.beats_per_measure - place) < 1e-3
            voice = self._click[0 if accent else 1]
            self._ahead = self._add(self._ahead, timeline.time_at(beat), voice, (CLICK_LEVEL, CLICK_LEVEL))
        self._beat = max(first, view.beat + 1e-9)

    def _add_tap(self, fall: Footfall) -> None:
        assert self._taps is not None
        voices = self._taps[fall.part]
        voice = voices[(2 * fall.dancer + fall.foot) % VARIANTS]
        while self._voice_ends and self._voice_ends[0] <= fall.time:
            self._voice_ends.popleft()
        if len(self._voice_ends) >= MAX_VOICES:
            self.dropped_taps += 1
            return
        self._voice_ends.append(fall.time + len(voice) / self.rate)
        x, z = fall.place
        near = self._usual_distance / max(math.dist(self._eye, (x, 0.0, z)), 0.3 * self._usual_distance)
        level = self._share * fall.strength * min(near, 2.0)
        side = WIDTH * min(max(2.0 * x / self._show.patch.stage.width, -1.0), 1.0)
        turn = 0.25 * math.pi * (1.0 + side)
        gains = (math.sqrt(2.0) * level * math.cos(turn), math.sqrt(2.0) * level * math.sin(turn))
        self._ahead_taps = self._add(self._ahead_taps, fall.time, voice, gains)

    def _add(self, ahead: Float32, time: float, voice: Float32, gains: tuple[float, float]) -> Float32:
        """Return the future samples with a voice added at `time` [s]; a late voice begins at once."""
        begin = round(time * self.rate) - self._samples_done
        if begin < -MAX_LATENESS * self.rate or time < 0.0:
            return ahead
        begin = max(begin, 0)
        if begin + len(voice) > len(ahead):
            ahead = np.concatenate((ahead, np.zeros((begin + len(voice) - len(ahead), 2), np.float32)))
        ahead[begin : begin + len(voice)] += voice[:, None] * np.array(gains, np.float32)
        return ahead

    def _finish(self, count: int) -> None:
        """Complete the next `count` samples."""
        block = _first(self._ahead, count) + np.tanh(_first(self._ahead_taps, count))
        self._ahead, self._ahead_taps = self._ahead[count:], self._ahead_taps[count:]
        if self._music is not None and count:
            heard = self._music.read(self._samples_done, count)
            block[: len(heard)] += MUSIC_LEVEL * heard  # mono is broadcast to both channels
        self._samples_done += count
        self._blocks.append(block)

    def _read(self, first: int, count: int) -> Float32:
        pieces: list[Float32] = []
        while count > 0 and self._blocks:
            block = self._blocks.popleft()
            if len(block) > count:
                self._blocks.appendleft(block[count:])
            pieces.append(block[:count])
            count -= len(pieces[-1])
        return np.concatenate(pieces) if pieces else np.zeros((0, 2), np.float32)


def _first(ahead: Float32, count: int) -> Float32:
    """Return the first `count` rows, padded with silence."""
    rows = np.zeros((count, 2), np.float32)
    rows[: len(ahead)] = ahead[:count]
    return rows
