"""Curves of a piece over its measures: loudness, onsets, brightness, pitch, chroma; from sound or MIDI (T016)."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import mido
import numpy as np
import numpy.typing as npt
from shapely import LineString, simplify

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.clock.map_clock import MapClock
from live.clock.measure_map import MeasureMap
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.music_file import Music
from live.control.events.events import MusicHeard
from live.show.score.music_reactions import FULL_CHORD, FULL_DENSITY, NAMES, music_level

PITCH_CLASSES: Final = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")
SOUND_FEATURES: Final = (*NAMES, "pitch", *(f"chroma {name}" for name in PITCH_CLASSES))
NOTE_FEATURES: Final = ("velocity", "density", "chord", "pitch", *(f"chroma {name}" for name in PITCH_CLASSES))
TOLERANCE: Final = 0.02
"""Largest error of a curve after points on its straight parts were left out."""
LOW_KEY, HIGH_KEY = 21, 108
"""Keys of the piano, pitch 0 and 1."""
LOW_HZ, HIGH_HZ = 55.0, 4000.0
"""Range of frequencies for chroma [Hz]."""
PITCH_HOP: Final = 512
PITCH_CONFIDENCE: Final = 0.6
BLOCK: Final = 8192

Curves = dict[str, list[tuple[float, float]]]
"""Points of each curve: measures after the first line, and the value there, 0 to 1."""


def curves_of_sound(music: Music, measures: MeasureMap, features: Sequence[str]) -> Curves:
    """Return curves of these features of a sound, a value for each beat."""
    mono = music.samples.mean(axis=1, dtype=np.float32)
    begins = _beat_times(measures, music.duration)
    values: dict[str, Float64] = {}
    if any(name in NAMES for name in features):
        values |= _heard(music, measures, begins)
    if "pitch" in features:
        values["pitch"] = _pitch(mono, music.sample_rate, begins)
    if any(name.startswith("chroma") for name in features):
        values |= _chroma(mono, music.sample_rate, begins)
    return {name: _curve(measures, begins, values[name]) for name in features}


def curves_of_midi(path: Path, measures: MeasureMap, features: Sequence[str]) -> Curves:
    """Return curves of these features of the notes of a MIDI file; PersonError if it cannot be read."""
    try:
        file = mido.MidiFile(path)
        time, notes, sounding = 0.0, list[tuple[float, float, int, int]](), dict[int, tuple[float, int]]()
        for message in file:
            time += message.time
            if message.type not in ("note_on", "note_off"):
                continue
            begun = sounding.pop(message.note, None)
            if begun is not None:
                notes.append((begun[0], time, message.note, begun[1]))
            if message.type == "note_on" and message.velocity:
                sounding[message.note] = time, message.velocity
    except Exception as error:  # mido raises many kinds for damaged files
        raise PersonError(f"{path}: not a MIDI file: {error}") from None
    notes += [(begun, time, note, velocity) for note, (begun, velocity) in sounding.items()]
    if not notes:
        raise PersonError(f"{path}: no notes in it")
    begins = _beat_times(measures, max(note[1] for note in notes))
    columns = np.array(notes, np.float64).T
    rows = {name: np.zeros(begins.size) for name in NOTE_FEATURES}
    pitch = 0.5
    for index, (begin, end) in enumerate(zip(begins, np.append(begins[1:], np.inf), strict=True)):
        struck = (columns[0] >= begin) & (columns[0] < end)
        heard = (columns[0] < end) & (columns[1] > begin)
        if heard.any():
            pitch = float(np.clip((columns[2][heard].mean() - LOW_KEY) / (HIGH_KEY - LOW_KEY), 0.0, 1.0))
        rows["velocity"][index] = columns[3][struck].mean() / 127.0 if struck.any() else 0.0
        rows["density"][index] = min(int(struck.sum()) / FULL_DENSITY, 1.0)
        rows["chord"][index] = min(int(heard.sum()) / FULL_CHORD, 1.0)
        rows["pitch"][index] = pitch
        share = np.bincount(columns[2][heard].astype(np.int64) % 12, minlength=12) / max(int(heard.sum()), 1)
        for name, value in zip(PITCH_CLASSES, share, strict=True):
            rows[f"chroma {name}"][index] = value
    return {name: _curve(measures, begins, rows[name]) for name in features}


def _beat_times(measures: MeasureMap, duration: float) -> Float64:
    """Return the times of the beats from the first line on, while the piece lasts [s]."""
    count = max(int(measures.beat_at(duration)), 1)
    return np.array([measures.time_at(float(beat)) for beat in range(count)])


def _curve(measures: MeasureMap, begins: Float64, values: Float64) -> list[tuple[float, float]]:
    """Return the points of a curve at beats, those on straight parts left out."""
    rows = [(measures.measure_at(time), float(value)) for time, value in zip(begins, values, strict=True)]
    if len(rows) < 2:
        return [*rows, *((rows[0][0] + 1.0, rows[0][1]) for _ in range(2 - len(rows)))]
    kept = simplify(LineString(rows), TOLERANCE, preserve_topology=False)
    return [(round(x, 4), round(min(max(y, 0.0), 1.0), 3)) for x, y in kept.coords]


def _heard(music: Music, measures: MeasureMap, begins: Float64) -> dict[str, Float64]:
    """Return the features that a show hears, at each beat."""
    clock = MapClock(measures, music.duration + 1.0)
    analysis = AudioAnalysis(music.sample_rate, energy=True, measures=clock)
    heard: list[MusicHeard] = []
    for at in range(0, music.samples.shape[0], BLOCK):
        events = analysis.feed(music.samples[at : at + BLOCK], lambda position: position)
        heard += [event for event in events if isinstance(event, MusicHeard)]
    if not heard:
        return {name: np.full(begins.size, 0.5) for name in NAMES}
    times = np.array([event.beat_time for event in heard])
    return {name: np.interp(begins, times, [music_level(event, name) for event in heard]) for name in NAMES}


def _pitch(mono: npt.NDArray[np.float32], rate: int, begins: Float64) -> Float64:
    """Return the pitch in each beat, on the piano's keys 0 to 1; without a clear one that of the beat before."""
    import aubio

    finder = aubio.pitch("yinfast", 4 * PITCH_HOP, PITCH_HOP, rate)
    finder.set_unit("midi")
    found: list[tuple[float, float]] = []
    for at in range(0, mono.size - PITCH_HOP, PITCH_HOP):
        key = float(finder(mono[at : at + PITCH_HOP])[0])
        if LOW_KEY <= key <= HIGH_KEY and finder.get_confidence() >= PITCH_CONFIDENCE:
            found.append((at / rate, key))
    times, keys = np.array(found or [(0.0, 60.0)]).T
    values, last = np.empty(begins.size), 0.5
    for index, (begin, end) in enumerate(zip(begins, np.append(begins[1:], np.inf), strict=True)):
        inside = keys[(times >= begin) & (times < end)]
        last = float((np.median(inside) - LOW_KEY) / (HIGH_KEY - LOW_KEY)) if inside.size else last
        values[index] = last
    return values


def _chroma(mono: npt.NDArray[np.float32], rate: int, begins: Float64) -> dict[str, Float64]:
    """Return the share of each pitch class in the spectrum of each beat, the strongest 1."""
    rows = np.zeros((begins.size, 12))
    ends = np.append(begins[1:], mono.size / rate)
    for index, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        part = mono[max(int(begin * rate), 0) : max(int(end * rate), 0)]
        if part.size < 64:
            continue
        power = np.abs(np.fft.rfft(part * np.hanning(part.size))) ** 2
        hertz = np.fft.rfftfreq(part.size, 1.0 / rate)
        inside = (hertz >= LOW_HZ) & (hertz <= HIGH_HZ)
        classes = np.rint(69.0 + 12.0 * np.log2(hertz[inside] / 440.0)).astype(np.int64) % 12
        rows[index] = np.bincount(classes, power[inside], minlength=12)
    rows /= np.maximum(rows.max(axis=1, keepdims=True), 1e-12)
    return {f"chroma {name}": rows[:, column] for column, name in enumerate(PITCH_CLASSES)}


def curve_tables(curves: Curves, first_measure: int) -> str:
    """Return curves as tables of a patch."""
    blocks = []
    for name, points in curves.items():
        shift = points[0][0]
        begin = int(shift)  # a curve begins with a whole measure
        rows = ", ".join(f"[{x - begin:g}, {y:g}]" for x, y in points)
        blocks.append(f'[[curve]]\nname = "{name}"\nmeasure = {first_measure + begin}\npoints = [{rows}]\n')
    return "\n".join(blocks)


def checked_features(names: Sequence[str], known: Sequence[str]) -> list[str]:
    """Return the features that were asked for; PersonError, with what there is, for an unknown one."""
    if not names:
        return [name for name in known if not name.startswith("chroma")]
    for name in names:
        if name not in known:
            raise PersonError(f"no feature is called {name!r}", f"there are: {', '.join(known)}")
    return list(dict.fromkeys(names))
