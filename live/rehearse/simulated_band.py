"""Simulated band, seeded, in show time: tempo drift, stops, fills, wrong downbeats and tempo jumps.

Produces the events of a beat tracker (a beat and its music features), and audio with kick, snare and hat.
"""

import wave
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float32
from live.control.events.events import BeatHeard, ControlEvent, MusicHeard, SourceChanged

MIN_BPM: Final = 60.0
MAX_BPM: Final = 180.0
"""Tempo range of the band [bpm]."""
DRIFT: Final = 0.004
"""Standard deviation of the relative tempo change from one beat to the next."""
TEMPO_RETURN: Final = 0.02
"""Share of the difference to the nominal tempo that is corrected at each beat."""
TRACKER_DELAY: Final = 0.09
"""Delay of the tracker's events after a beat [s]."""
SALT: Final = 0xBA4D


@dataclass(frozen=True, slots=True)
class Irregularities:
    """Probabilities of the band's irregularities, per measure."""

    stop: float = 0.01
    """A rest of one to eight beats; the band resumes with a downbeat."""
    fill: float = 0.08
    """A measure with many onsets in which beats are hard to detect."""
    wrong_downbeat: float = 0.01
    """The tracker detects a wrong downbeat for one to twelve measures."""
    tempo_jump: float = 0.006
    """A tempo jump by a factor of up to about 1.5."""
    drift: float = DRIFT


@dataclass(frozen=True, slots=True)
class PlayedBeat:
    """One played beat."""

    time: float
    """When [s of the show]."""
    period: float
    """Seconds to the next one."""
    beat: int
    """Index in its measure, from 0."""
    measure: int
    """Index of its measure, from 0."""
    fill: bool
    """Whether it belongs to a fill."""
    detected_as: int
    """Index in the measure as the tracker detects it."""
    rest_before: float
    """Seconds of silence before it."""


class SimulatedBand:
    """Endless band: `played` yields the beats, `events` the tracker's events for them."""

    def __init__(
        self,
        seed: int,
        *,
        bpm: float = 112.0,
        beats_per_measure: int = 4,
        source: str = "audio",
        irregularities: Irregularities | None = None,
        start: float = 0.5,
    ) -> None:
        self._rng = np.random.default_rng([seed, SALT])
        self._nominal_bpm = self.bpm = bpm
        self._beats = beats_per_measure
        self._source = source
        self._irregularities = irregularities or Irregularities()
        self._time = start
        self._measure = 0
        self._beat_offset, self._offset_measures_left = 0, 0
        self.counts = {"stop": 0, "fill": 0, "wrong one": 0, "leap": 0}
        """Counts of irregularities by kind."""

    def beats(self) -> Iterator[PlayedBeat]:
        """Yield beats, endlessly."""
        while True:
            fill, silence = self._begin_measure()
            for beat in range(self._beats):
                self._drift()
                period = 60.0 / self.bpm * (1.0 + 0.01 * float(self._rng.standard_normal()))
                before, silence = silence, 0.0
                self._time += before
                heard_as = (beat + self._beat_offset) % self._beats
                yield PlayedBeat(self._time, period, beat, self._measure, fill, heard_as, before)
                self._time += period
            self._measure += 1

    def _begin_measure(self) -> tuple[bool, float]:
        """Return whether a fill begins, and the rest before the downbeat [s]."""
        manners, chance = self._irregularities, self._rng
        stop, fill, wrong, leap = chance.random(4) < (
            manners.stop,
            manners.fill,
            manners.wrong_downbeat,
            manners.tempo_jump,
        )
        if leap:
            self.counts["leap"] += 1
            self._nominal_bpm = float(np.clip(self._nominal_bpm * np.exp2(chance.uniform(-0.6, 0.6)), MIN_BPM, MAX_BPM))
            self.bpm = self._nominal_bpm
        if self._offset_measures_left:
            self._offset_measures_left -= 1
            if not self._offset_measures_left:
                self._beat_offset = 0
        elif wrong:
            self.counts["wrong one"] += 1
            self._beat_offset, self._offset_measures_left = (
                int(chance.integers(1, max(2, self._beats))),
                int(chance.integers(1, 13)),
            )
        self.counts["fill"] += int(fill)
        self.counts["stop"] += int(stop)
        return bool(fill), int(chance.integers(1, 9)) * 60.0 / self.bpm if stop else 0.0

    def _drift(self) -> None:
        step = self._irregularities.drift * float(self._rng.standard_normal())
        tempo = self.bpm * (1.0 + step) + TEMPO_RETURN * (self._nominal_bpm - self.bpm)
        self.bpm = float(np.clip(tempo, MIN_BPM, MAX_BPM))

    def events(self) -> Iterator[ControlEvent]:
        """Yield the tracker's events in order of time."""
        yield SourceChanged(time=0.0, source=self._source, state="found")
        for played in self.beats():
            if played.rest_before > 2.0:
                since = played.time - played.rest_before + 1.5
                yield SourceChanged(time=since, source=self._source, state="silent")
                yield SourceChanged(time=played.time, source=self._source, state="found")
            time = played.time + TRACKER_DELAY
            yield self._beat_event(played, time)
            yield self._music_event(played, time)

    def _beat_event(self, played: PlayedBeat, time: float) -> BeatHeard:
        chance = self._rng
        sure = chance.uniform(0.15, 0.5) if played.fill or self._beat_offset else chance.uniform(0.7, 1.0)
        return BeatHeard(
            time=time,
            source=self._source,
            beat_time=played.time + float(chance.normal(0.0, 0.03 if played.fill else 0.006)),
            period=played.period,
            confidence=float(sure),
            beat=played.detected_as,
            beats_per_measure=self._beats,
        )

    def _music_event(self, played: PlayedBeat, time: float) -> MusicHeard:
        """Return the music features: loudness in arcs of 16 measures, with a build-up and a drop at the next arc."""
        chance = self._rng
        arc = (played.measure % 16 + played.beat / self._beats) / 16.0
        loud = float(np.clip(0.25 + 0.6 * arc + 0.08 * chance.standard_normal(), 0.0, 1.0))
        return MusicHeard(
            time=time,
            source=self._source,
            beat_time=played.time,
            loudness=loud,
            density=float(chance.uniform(4.0, 8.0) if played.fill else chance.uniform(1.0, 4.0)),
            brightness=float(np.clip(0.3 + 0.5 * arc + 0.1 * chance.standard_normal(), 0.0, 1.0)),
            low=float(chance.uniform(0.3, 1.0)),
            build=float(max(0.0, 4.0 * arc - 3.0)),
            drop=played.measure % 16 == 0 and played.measure > 0 and played.beat == 0,
            loudness_db=-40.0 + 30.0 * loud,
        )


RATE: Final = 44100


def render_audio(band: SimulatedBand, seconds: float, *, seed: int = 0) -> Float32:
    """Return the audio of the band's first `seconds`, mono at RATE, shape (samples,), within [-1, 1]."""
    chance = np.random.default_rng([seed, 0x50BD])
    out = np.zeros(int(seconds * RATE), np.float32)
    kick, snare, hat = _kick(), _noise(chance, 0.16, 0.05), _noise(chance, 0.05, 0.012)
    for played in takewhile(lambda beat: beat.time < seconds, band.beats()):
        for when, sound, level in _strokes(played, chance, kick, snare, hat):
            begin = int(when * RATE)
            end = min(begin + len(sound), len(out))
            if 0 <= begin < end:
                out[begin:end] += level * sound[: end - begin]
    peak = float(np.abs(out).max()) if len(out) else 0.0
    return out / np.float32(max(peak * 1.05, 1e-6))


def _strokes(
    played: PlayedBeat, chance: np.random.Generator, kick: Float32, snare: Float32, hat: Float32
) -> list[tuple[float, Float32, float]]:
    """Return the strokes of one beat: (time, sound, level).

    Kick on even beats, snare on odd ones, hats on eighths; in a fill only the snare, in sixteenths.
    """
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
    """Write a 16-bit WAV file. Raises OSError."""
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
