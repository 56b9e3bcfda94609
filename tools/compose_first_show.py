"""Compose the music of the first show: ``python tools/compose_first_show.py [OUT.ogg]``.

Forty measures of 112 bpm, made of nothing but numpy and one seed. All sounds are laid on a circle of 4,114,286
samples (40 measures to a third of a sample), echoes and reverb too, so the end meets the beginning; the first kick
is the first sample. Opus, because its encoder comes with PyAV, at its own 48 kHz.
"""

import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

Sound = npt.NDArray[np.float64]

RATE: Final = 48_000
TEMPO: Final = 112
BEAT: Final = RATE * 60 / TEMPO
SIXTEENTH: Final = BEAT / 4
MEASURE: Final = 4 * BEAT
MEASURES: Final = 40
LENGTH: Final = round(MEASURES * MEASURE)
SWING: Final = 0.14
"""How much of a sixteenth every second sixteenth comes late."""

BREAK: Final = range(20, 24)
CHORDS: Final = ((57, 60, 64, 67), (59, 62, 64, 69), (59, 62, 64, 67), (60, 64, 67, 71))
"""Fmaj9, G6, Em7, Am9 (MIDI notes, voiced close so that hardly a finger moves), one a measure."""
ROOTS: Final = (41, 43, 40, 45)
BASS: Final = (
    (0, 0, 1.5), (2, 12, 0.8), (3, 0, 0.7), (6, 12, 1.0), (7, 0, 0.7), (10, 0, 1.0), (11, 7, 0.8), (14, 12, 1.0),
)  # fmt: skip
"""(sixteenth, semitones over the root, length in sixteenths)."""
STABS: Final = ((0, 2.6), (3, 0.8), (6, 1.6), (11, 1.0), (14, 1.2))
MOTIF: Final = (
    ((0, 76, 3), (3, 79, 1), (4, 76, 2), (8, 72, 2), (10, 74, 2), (14, 72, 2)),
    ((0, 74, 3), (3, 76, 1), (4, 74, 2), (8, 71, 3), (12, 67, 4)),
    ((0, 71, 3), (3, 74, 1), (4, 76, 2), (8, 74, 2), (10, 71, 2), (14, 69, 2)),
    ((0, 72, 4), (6, 76, 2), (8, 79, 2), (10, 81, 4), (14, 79, 2)),
)
"""The tune, one tuple a measure: (sixteenth, MIDI note, length in sixteenths)."""


def seconds(duration: float) -> Sound:
    """Times of the samples of a sound of `duration` [s]."""
    return np.arange(int(duration * RATE)) / RATE


def hertz(note: float) -> float:
    """Frequency of a MIDI note."""
    return float(440.0 * 2.0 ** ((note - 69.0) / 12.0))


def fade_out(sound: Sound, duration: float = 0.006) -> Sound:
    """End without a click."""
    count = min(int(duration * RATE), sound.shape[0])
    sound[sound.shape[0] - count :] *= np.linspace(1.0, 0.0, count)
    return sound


def noise(duration: float, low: float, high: float, seed: int) -> Sound:
    """White noise between two frequencies [Hz], RMS 1."""
    sound = np.random.default_rng(seed).standard_normal(int(duration * RATE))
    spectrum = np.fft.rfft(sound)
    frequency = np.fft.rfftfreq(sound.shape[0], 1.0 / RATE)
    spectrum *= 1.0 / (1.0 + (low / np.maximum(frequency, 1.0)) ** 6) / (1.0 + (frequency / high) ** 6)
    sound = np.fft.irfft(spectrum, sound.shape[0])
    return np.asarray(sound / np.sqrt(np.mean(sound**2)))


@cache
def kick() -> Sound:
    """A sine that falls from 170 to 47 Hz, with the beater's click."""
    t = seconds(0.34)
    phase = 2.0 * np.pi * np.cumsum(47.0 + 123.0 * np.exp(-t / 0.028)) / RATE
    body = np.sin(phase) * np.exp(-t / 0.13)
    click = noise(0.34, 2_000.0, 9_000.0, 1) * np.exp(-t / 0.003) * 0.12
    return fade_out(np.tanh(1.6 * body) + click, 0.03)


@cache
def clap() -> Sound:
    """Four hands that do not quite agree, over a snare's body."""
    t = seconds(0.30)
    hands = sum(np.where(t >= d, np.exp(-(t - d) / 0.008), 0.0) for d in (0.0, 0.009, 0.019))
    tail = np.where(t >= 0.026, np.exp(-(t - 0.026) / 0.075), 0.0)
    body = np.sin(2.0 * np.pi * 186.0 * t) * np.exp(-t / 0.05) * 0.5
    return fade_out(noise(0.30, 900.0, 5_200.0, 2) * (hands * 0.5 + tail * 0.7) * 0.42 + body)


@cache
def hat(decay: float, seed: int) -> Sound:
    """A hi-hat: bright noise that dies away in `decay` [s]."""
    t = seconds(6.0 * decay)
    return fade_out(noise(6.0 * decay, 7_500.0, 15_500.0, seed) * np.exp(-t / decay))


@cache
def tom(note: int) -> Sound:
    """A tom, tuned."""
    t = seconds(0.32)
    phase = 2.0 * np.pi * np.cumsum(hertz(note) * (1.0 + 0.5 * np.exp(-t / 0.03))) / RATE
    return fade_out(np.sin(phase) * np.exp(-t / 0.11) + noise(0.32, 400.0, 3_000.0, 5) * np.exp(-t / 0.012) * 0.2)


@cache
def crash() -> Sound:
    """A cymbal that sings for two seconds."""
    t = seconds(2.2)
    return fade_out(noise(2.2, 4_000.0, 14_000.0, 6) * np.exp(-t / 0.55), 0.2)


@cache
def saw(frequency: float, duration: float, bright: float, closing: float) -> Sound:
    """A sawtooth whose harmonics fade from `bright` (harmonics at 1/e) to a third of it within `closing` [s]."""
    t = seconds(duration)
    cutoff = bright * (1.0 / 3.0 + 2.0 / 3.0 * np.exp(-t / closing))
    sound = np.zeros_like(t)
    for harmonic in range(1, min(28, int(14_000.0 / frequency)) + 1):
        weight = np.exp(-(harmonic - 1) / cutoff) / harmonic
        sound += weight * np.sin(2.0 * np.pi * harmonic * frequency * t)
    return sound


@cache
def bass(note: int, duration: float) -> Sound:
    """A round, plucked bass with its octave below."""
    t = seconds(duration + 0.05)
    envelope = np.minimum(t / 0.004, 1.0) * (0.55 + 0.45 * np.exp(-t / 0.12)) * np.where(t < duration, 1.0, 0.0)
    envelope = np.convolve(envelope, np.ones(400) / 400.0, "same")
    tone = saw(hertz(note), duration + 0.05, 5.0, 0.09) + 0.35 * np.sin(np.pi * hertz(note) * t)
    return fade_out(np.tanh(1.5 * tone) * envelope)


@cache
def piano(note: int, duration: float, velocity: float) -> Sound:
    """An electric piano by frequency modulation: tine and bell, with a soft release."""
    t = seconds(duration + 0.16)
    f = hertz(note)
    bell = 0.22 * velocity * np.sin(2.0 * np.pi * 14.0 * f * t) * np.exp(-t / 0.05)
    modulator = (0.4 + 1.9 * velocity * np.exp(-t / 0.22)) * np.sin(2.0 * np.pi * f * t)
    release = np.where(t < duration, 1.0, np.exp(-(t - duration) / 0.04))
    return fade_out(
        np.sin(2.0 * np.pi * f * t + modulator + bell) * np.exp(-t / 0.7) * release * np.minimum(t / 0.002, 1)
    )


@cache
def pad(note: int, duration: float, detune: float) -> Sound:
    """A warm string machine, `detune` [semitones] beside the note."""
    t = seconds(duration + 0.3)
    tone = saw(hertz(note + detune), duration + 0.3, 4.0, 30.0) + saw(
        hertz(note - 0.4 * detune), duration + 0.3, 3.0, 30.0
    )
    return fade_out(tone * np.minimum(t / 0.25, 1.0) * np.clip((duration + 0.3 - t) / 0.3, 0.0, 1.0))


@cache
def lead(note: int, duration: float) -> Sound:
    """The voice of the tune: two saws in unison with a late vibrato."""
    t = seconds(duration + 0.12)
    bend = 0.10 * np.sin(2.0 * np.pi * 5.4 * t) * np.clip((t - 0.16) / 0.2, 0.0, 1.0)
    phase = 2.0 * np.pi * np.cumsum(hertz(note) * 2.0 ** (bend / 12.0)) / RATE
    tone = sum(
        np.sin(h * phase * spread) * np.exp(-(h - 1) / (3.0 + 4.0 * np.exp(-t / 0.1))) / h
        for h in range(1, 13)
        for spread in (1.0, 1.0035)
    )
    release = np.where(t < duration, 1.0, np.exp(-(t - duration) / 0.03))
    return fade_out(np.asarray(tone) * np.minimum(t / 0.006, 1.0) * (0.7 + 0.3 * np.exp(-t / 0.15)) * release)


class Track:
    """One stereo track on the circle."""

    def __init__(self) -> None:
        self.sound = np.zeros((LENGTH, 2))

    def put(
        self, measure: int, sixteenth: float, sound: Sound, gain: float, pan: float = 0.0, late: float = 0.0
    ) -> None:
        """Add a sound: `pan` -1 (left) to 1 (right), `late` [s]; every second sixteenth swings."""
        swung = sixteenth + (SWING if sixteenth % 2 == 1 else 0.0)
        start = round(measure * MEASURE + swung * SIXTEENTH + late * RATE)
        index = np.arange(start, start + sound.shape[0]) % LENGTH
        angle = (pan + 1.0) * np.pi / 4.0
        self.sound[index, 0] += sound * gain * np.cos(angle) * np.sqrt(2.0)
        self.sound[index, 1] += sound * gain * np.sin(angle) * np.sqrt(2.0)


def kicks() -> Iterator[tuple[int, float]]:
    """(measure, sixteenth) of every kick: four on the floor, and a push before every fourth measure line."""
    for measure in range(MEASURES):
        if measure in BREAK:
            yield measure, 0
            continue
        yield from ((measure, beat) for beat in (0, 4, 8, 12))
        if measure % 4 == 3 and measure != BREAK.start - 1:
            yield measure, 11


def drums(rng: np.random.Generator) -> Track:
    """Kick, clap, hats, shaker, toms and cymbals."""
    track = Track()
    for measure, sixteenth in kicks():
        track.put(measure, sixteenth, kick(), 0.95 if sixteenth != 11 else 0.55)
    for measure in range(MEASURES):
        full = 24 <= measure < 36
        for beat in (4, 12) if measure >= 2 else ():
            track.put(measure, beat, clap(), 0.50, 0.05)
        if full and measure % 2 == 1:
            track.put(measure, 15, clap(), 0.16, -0.2)
        for step in range(16):
            loud = (0.20 if step % 4 == 2 else 0.11 if step % 2 == 0 else 0.08) * rng.uniform(0.85, 1.15)
            track.put(measure, step, hat(0.022, 11 + step % 3), loud, 0.3, rng.normal(0.0, 0.0008))
            if full and step % 4 == 2:
                track.put(measure, step, hat(0.085, 14), 0.13, 0.22)
        if measure >= 4:
            for step in range(16):
                track.put(measure, step, hat(0.035, 17), (0.024, 0.060)[step % 2], -0.55, 0.004)
    fills(track)
    return track


def fills(track: Track) -> None:
    """Toms at the ends of parts, a cymbal at their beginnings, a roll out of the break."""
    for measure in (3, 11, 19, 27, 35, 39):
        for step, note in ((10, 50), (11, 50), (12, 47), (14, 45), (15, 43)):
            track.put(measure, step, tom(note), 0.34, (note - 47) / 8.0)
    for measure in (0, 4, 12, 24, 36):
        track.put(measure, 0, crash(), 0.15 if measure else 0.08, -0.15)
    for step in range(16):
        track.put(BREAK.stop - 1, step, clap(), 0.05 + 0.022 * step, 0.1)


def basses() -> Track:
    """The bass line: octaves around the kick, and a step towards the next root."""
    track = Track()
    for measure in range(MEASURES):
        root, following = ROOTS[measure % 4], ROOTS[(measure + 1) % 4]
        if measure in BREAK:
            track.put(measure, 0, bass(root, 1.6), 0.30)
            continue
        if measure < 2:
            continue
        for step, semitones, length in BASS:
            track.put(
                measure, step, bass(root + semitones, length * SIXTEENTH / RATE), 0.34 if semitones == 0 else 0.27
            )
        track.put(measure, 15, bass(following + (2 if following < root else -1), 0.8 * SIXTEENTH / RATE), 0.27)
    return track


def chords(rng: np.random.Generator) -> Track:
    """Electric piano stabs all through, a pad from the second part on."""
    track = Track()
    for measure in range(MEASURES):
        chord = CHORDS[measure % 4]
        gain = 0.085 if measure in BREAK else 0.07 + 0.02 * min(measure / 4.0, 1.0)
        for step, length in STABS:
            if measure in BREAK and step in (3, 11):
                continue
            velocity = 0.9 if step == 0 else 0.7
            for voice, note in enumerate(chord):
                late = 0.004 * voice + rng.normal(0.0, 0.001)
                sound = piano(note, length * SIXTEENTH / RATE, velocity)
                track.put(measure, step, sound, gain * velocity, 0.25 * (voice - 1.5), abs(late))
        if 12 <= measure < 36:
            for note in chord:
                for side in (-1.0, 1.0):
                    track.put(measure, 0, pad(note, MEASURE / RATE, 0.07 * side), 0.017, 0.85 * side)
    return track


def tune() -> Track:
    """The tune in the second part, an octave higher and doubled in the full one; broken chords in the break."""
    track = Track()
    for measure in (*range(12, 20), *range(24, 36)):
        last = measure >= 32
        for step, note, length in MOTIF[measure % 4]:
            duration = 0.92 * length * SIXTEENTH / RATE
            track.put(measure, step, lead(note, duration), 0.060, -0.1)
            if measure >= 28:
                track.put(measure, step, lead(note + (3 if last and note % 12 == 9 else 12), duration), 0.022, 0.3)
    for measure in (*BREAK, *range(28, 36)):
        chord = CHORDS[measure % 4]
        for step in range(16):
            note = chord[(0, 1, 2, 3, 2, 1)[step % 6]] + 12
            gain = (0.045 if measure in BREAK else 0.022) * (1.0 if step % 4 == 0 else 0.75)
            track.put(measure, step, piano(note, 0.10, 0.8), gain, 0.6 if step % 2 else -0.6)
    return track


def riser() -> Track:
    """Wind that rises through the last two measures of the break."""
    track = Track()
    duration = 2 * MEASURE / RATE
    t = seconds(duration) / duration
    sound = noise(duration, 600.0, 3_000.0, 21) * (1.0 - t) + noise(duration, 3_000.0, 12_000.0, 22) * t
    track.put(BREAK.stop - 2, 0, fade_out(sound * t**2, 0.02), 0.16)
    return track


def ducking() -> Sound:
    """How far the kick pushes everything else down, 0 to 1, shape (LENGTH,)."""
    curve = np.zeros(LENGTH)
    shape = np.exp(-seconds(0.32) / 0.11)
    for measure, sixteenth in kicks():
        start = round(measure * MEASURE + (sixteenth + (SWING if sixteenth % 2 else 0.0)) * SIXTEENTH)
        index = np.arange(start, start + shape.shape[0]) % LENGTH
        curve[index] = np.maximum(curve[index], shape)
    return curve


def around(sound: Sound, response: Sound) -> Sound:
    """Convolve each channel with its impulse response, around the circle."""
    spectrum = np.fft.rfft(sound, axis=0) * np.fft.rfft(response, LENGTH, axis=0)
    return np.asarray(np.fft.irfft(spectrum, LENGTH, axis=0))


def room() -> Sound:
    """Impulse response of a small bright hall, shape (samples, 2)."""
    t = seconds(1.3)
    late = np.stack([noise(1.3, 250.0, 6_500.0, seed) * np.exp(-t / 0.24) for seed in (31, 32)], axis=1)
    late[: int(0.012 * RATE)] = 0.0
    return np.asarray(late * 0.012)


def echo() -> Sound:
    """Impulse response of a dotted-eighth echo that goes from side to side."""
    response = np.zeros((int(9.2 * SIXTEENTH), 2))
    for repeat, gain in enumerate((0.34, 0.20, 0.11), start=1):
        response[round(3 * repeat * SIXTEENTH), repeat % 2] = gain
    return response


def compose(seed: int = 112) -> npt.NDArray[np.float32]:
    """The whole piece, shape (4,114,286, 2), peak 0.84: Opus overshoots by a sixth."""
    rng = np.random.default_rng(seed)
    duck = ducking()[:, None]
    beat, low, middle, high = drums(rng).sound, basses().sound, chords(rng).sound, tune().sound
    high += around(high, echo())
    low *= 1.0 - 0.55 * duck
    middle *= 1.0 - 0.65 * duck
    high *= 1.0 - 0.30 * duck
    beat, middle, high = 0.75 * beat, 2.1 * middle, 1.9 * high
    wet = around(0.25 * beat + 0.8 * middle + high + riser().sound, room()) * (1.0 - 0.5 * duck)
    mix = beat + low + middle + high + riser().sound + wet
    spectrum = np.fft.rfft(mix, axis=0)
    spectrum[: int(28.0 * LENGTH / RATE)] = 0.0  # what no loudspeaker plays
    mix = np.tanh(0.95 * np.fft.irfft(spectrum, LENGTH, axis=0))
    return np.asarray(0.84 * mix / np.max(np.abs(mix)), np.float32)


def write(sound: npt.NDArray[np.float32], path: Path, bit_rate: int = 68_000) -> None:
    """Encode as Opus in an Ogg file; the decoder drops the encoder's own delay again."""
    import av

    with av.open(str(path), "w", format="ogg", options={"fflags": "+bitexact"}) as container:
        stream: Any = container.add_stream("libopus", rate=RATE, layout="stereo")
        stream.bit_rate = bit_rate
        container.metadata["title"] = "First Show"
        for start in range(0, sound.shape[0], 960):
            block = np.ascontiguousarray(sound[start : start + 960]).reshape(1, -1)
            frame = av.AudioFrame.from_ndarray(block, format="flt", layout="stereo")
            frame.sample_rate, frame.pts = RATE, start
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "patches/music/first_show.ogg")
    out.parent.mkdir(parents=True, exist_ok=True)
    write(compose(), out)
    print(f"{out}: {MEASURES} measures, {LENGTH / RATE:.3f} s, {out.stat().st_size / 1000:.0f} kB")
