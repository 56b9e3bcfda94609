"""Curves taken from music: made-up sounds and notes of which each feature is known."""

import json
from pathlib import Path

import mido
import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.measure_map import MeasureMap, steady_map
from live.control.audio.music_file import Music
from live.document.music_curves import (
    PITCH_CLASSES,
    checked_features,
    curve_tables,
    curves_of_midi,
    curves_of_sound,
)
from live.library.music_map_file import write_map
from live.show.patch.patch_reader import parse_patch
from tests.cli.command import run_live

RATE = 22_050
MEASURES = steady_map(120.0, 0.0, 4, 9)


def tones(*keys: float, seconds: float = 2.0) -> Music:
    """Return a tone for each measure, by its key on the piano."""
    time = np.arange(int(seconds * RATE)) / RATE
    parts = [0.3 * np.sin(2 * np.pi * 440.0 * 2 ** ((key - 69) / 12) * time) for key in keys]
    return Music(np.concatenate(parts).astype(np.float32)[:, np.newaxis], RATE)


def value(points: list[tuple[float, float]], at: float) -> float:
    times, values = np.array(points).T
    return float(np.interp(at, times, values))


def test_pitch_and_chroma_of_single_tones() -> None:
    keys = (57, 69, 76, 64)
    found = curves_of_sound(tones(*keys), MEASURES, ["pitch", *(f"chroma {name}" for name in PITCH_CLASSES)])
    for measure, key in enumerate(keys):
        assert value(found["pitch"], measure + 0.5) == pytest.approx((key - 21) / 87, abs=0.02)
        strongest = max(PITCH_CLASSES, key=lambda name: value(found[f"chroma {name}"], measure + 0.5))
        assert strongest == PITCH_CLASSES[key % 12]


@pytest.mark.long
def test_loudness_of_a_sound_that_fades() -> None:
    rng = np.random.default_rng(1)
    sound = rng.normal(0.0, 0.3, 16 * RATE) * np.repeat([1.0, 0.01, 1.0, 1.0], 4 * RATE)
    found = curves_of_sound(Music(sound.astype(np.float32)[:, np.newaxis], RATE), MEASURES, ["loudness"])["loudness"]
    assert value(found, 1.0) > 0.8
    assert value(found, 3.2) < 0.3
    assert value(found, 6.5) > 0.8


def midi_file(path: Path) -> Path:
    """Return two measures: four quarter notes, then one chord of three, an octave higher."""
    track = mido.MidiTrack([mido.MetaMessage("set_tempo", tempo=500_000)])
    for _ in range(4):
        track += [mido.Message("note_on", note=60, velocity=127), mido.Message("note_off", note=60, time=480)]
    track += [mido.Message("note_on", note=note, velocity=64) for note in (72, 76, 79)]
    track += [mido.Message("note_off", note=note, time=1920 if note == 72 else 0) for note in (72, 76, 79)]
    mido.MidiFile(ticks_per_beat=480, tracks=[track]).save(path)
    return path


def test_notes_of_a_midi_file(tmp_path: Path) -> None:
    found = curves_of_midi(
        midi_file(tmp_path / "a.mid"), MEASURES, ["velocity", "density", "chord", "pitch", "chroma C"]
    )
    assert value(found["velocity"], 0.5) == pytest.approx(1.0)
    assert value(found["velocity"], 1.5) == pytest.approx(0.0)  # nothing is struck there any more
    assert value(found["density"], 0.5) == pytest.approx(1 / 6, abs=0.01)
    assert value(found["chord"], 0.5) == pytest.approx(1 / 8, abs=0.01)
    assert value(found["chord"], 1.5) == pytest.approx(3 / 8, abs=0.01)
    assert value(found["pitch"], 0.5) == pytest.approx((60 - 21) / 87, abs=0.02)
    assert value(found["chroma C"], 0.5) == pytest.approx(1.0)
    assert value(found["chroma C"], 1.5) == pytest.approx(1 / 3, abs=0.02)
    (tmp_path / "b.mid").write_bytes(b"MThd")
    with pytest.raises(PersonError, match="not a MIDI file"):
        curves_of_midi(tmp_path / "b.mid", MEASURES, ["pitch"])


def test_tables_are_read_by_a_patch() -> None:
    curves = {"loudness": [(0.0, 0.5), (2.25, 1.0)], "pitch": [(3.5, 0.0), (4.0, 1.0)]}
    text = 'name = "x"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["groove"]\n' + curve_tables(curves, 5)
    first, second = parse_patch(text, "x").curve
    assert (first.measure, first.points) == (5, ((0.0, 0.5), (2.25, 1.0)))
    assert (second.measure, second.points) == (8, ((0.5, 0.0), (1.0, 1.0)))


def test_unknown_features_are_named() -> None:
    with pytest.raises(PersonError, match="no feature is called 'tempo'"):
        checked_features(["tempo"], ["pitch"])
    assert checked_features([], ["pitch", "chroma C"]) == ["pitch"]


def test_the_command(tmp_path: Path) -> None:
    write_map(MeasureMap(MEASURES.lines), tmp_path / "map.txt")
    song = str(midi_file(tmp_path / "a.mid"))
    done = run_live("music", "curves", song, "--from", str(tmp_path / "map.txt"), "--feature", "pitch", "--json")
    assert done.returncode == 0, done.stderr
    assert list(json.loads(done.stdout)) == ["pitch"]
    out = tmp_path / "curves.toml"
    assert run_live("music", "curves", song, "--out", str(out)).returncode == 0
    assert out.read_text().count("[[curve]]") == 4
    assert run_live("music", "curves", song, "--feature", "no").returncode == 2
