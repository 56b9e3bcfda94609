"""`live music map`: a song's measures, corrected by a few words, and written for other programs."""

import json
from pathlib import Path
from typing import Any

import mido
import numpy as np
import pytest

from live.app.offline.music_map import Fix, MapProposal, hear, map_values, read_fixes
from live.base.errors import PersonError
from live.clock.measure_map import MeasureLine, MeasureMap, Phrase
from live.clock.tracking.offline_beats import Activations
from live.control.audio.music_file import Music, read_music
from live.library.music_map_file import read_map, write_map
from tests.cli.command import run_live
from tests.clock.clicks import groove
from tests.clock.tracking.test_offline_beats import activations
from tests.places import SHARED

SONGS = SHARED / "beats" / "open"
FIXES: dict[str, list[dict[str, Any]]] = {
    "o01_band_080": [], "o02_band_090_live": [], "o03_band_104": [], "o04_band_125_live": [], "o06_band_170": [],
    "o07_band_186": [], "o13_loops_dj_140": [], "o16_pop_keys_116": [], "o17_pop_34": [], "o25_crowd_room_098": [],
    "o05_band_141": [{"do": "move", "line": 1, "at": 0}],
    "o09_drums_rock_060": [{"do": "half"}],
    "o15_piano_pop_slow": [{"do": "metre", "beats": 4}, {"do": "move", "line": 1, "at": 0}],
}  # fmt: skip
"""Corrections of steady and slow songs; `at`: the number of the true line that a line is moved to."""


def true_lines(song: str) -> list[float]:
    rows = (line.split() for line in (SONGS / f"{song}.beats").read_text().splitlines() if line)
    return [float(time) for time, beat in rows if beat == "1"]


@pytest.mark.parametrize(
    "song", [pytest.param(song, marks=[pytest.mark.long] * (place != 1)) for place, song in enumerate(FIXES)]
)
def test_steady_and_slow_songs_need_three_corrections_at_most(song: str) -> None:
    if not SONGS.is_dir():
        pytest.skip("the shared songs are absent")
    wanted = true_lines(song)
    proposal = MapProposal(hear(read_music(SONGS / f"{song}.ogg")))
    assert len(FIXES[song]) <= 3
    for fix in FIXES[song]:
        given = {key: value for key, value in fix.items() if key != "at"}
        proposal.correct(Fix(**given, **({"time_s": wanted[fix["at"]]} if "at" in fix else {})))
    found = np.array([line.time_s for line in proposal.map().lines])
    assert np.abs(found[:, np.newaxis] - wanted).min(axis=0).max() < 0.07
    inside = found[(found > wanted[0] - 0.1) & (found < wanted[-1] + 0.1)]
    assert len(inside) == len(wanted)


def test_a_piece_is_heard_both_ways() -> None:
    """The first beats are known from what comes, the last ones from what came; time runs as in the piece."""
    bpm, seconds = 110.0, 16.0
    found = hear(Music(groove(bpm, 44_100, seconds)[:, np.newaxis], 44_100))
    assert (np.diff(found.time) > 0.0).all()
    assert (found.downbeat <= found.beat + 1e-12).all()
    phase = found.time * bpm / 60.0
    on = np.abs(phase - np.round(phase)) < 0.05
    for first, last in ((0.3, 3.0), (seconds - 3.0, seconds - 0.3)):
        part = (found.time > first) & (found.time < last)
        assert found.beat[part & on].mean() > 4.0 * found.beat[part & ~on].mean()


def proposal() -> MapProposal:
    beats = 1.0 + np.arange(64) * 0.5
    return MapProposal(activations(beats, beats[::4], 33.5))


def test_lines_are_counted_from_the_first_measure() -> None:
    found = proposal().map()
    first = next(line for line in found.lines if abs(line.time_s - 1.0) < 0.02)
    assert first.beats == 4
    assert found.bpm == pytest.approx(120.0, abs=0.5)
    values = map_values(found)
    assert values["lines"][0].keys() == {"time_s", "measure", "beats", "tempo"}
    assert values["measure_s"] == pytest.approx(2.0, abs=0.02)


@pytest.mark.long
def test_corrections_act_in_order() -> None:
    made = proposal()
    lines = made.map().lines
    made.correct(Fix(do="insert", time_s=lines[3].time_s + 1.0))
    made.correct(Fix(do="delete", line=2))
    made.correct(Fix(do="ramp", line=5))
    made.correct(Fix(do="phrase", line=3, name="B"))
    found = made.map()
    assert len(found.lines) == len(lines)
    assert found.lines[0].beats == 8
    assert found.lines[4].tempo == "ramp"
    assert found.phrases == (Phrase(3, "B"),)
    with pytest.raises(PersonError, match="there is no line 99"):
        made.correct(Fix(do="delete", line=99))


def test_silence_has_no_measures() -> None:
    quiet = Activations(np.zeros(0), np.zeros(0), np.zeros(0))
    with pytest.raises(PersonError, match="no measure was found"):
        MapProposal(quiet).map()


MAP = MeasureMap(
    [MeasureLine(1.25, 1, 4), MeasureLine(3.1, 2, 4), MeasureLine(5.0, 3, 3, "ramp"), MeasureLine(6.2, 4, 3),
     MeasureLine(7.4, 5, 4), MeasureLine(9.0, 6, 4)],
    [Phrase(1, "intro"), Phrase(3, "A new part")],
)  # fmt: skip


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".mid"])
def test_a_map_is_read_back_as_it_was_written(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"map{suffix}"
    write_map(MAP, path)
    found = read_map(path)
    assert [(line.measure, line.beats, line.tempo) for line in found.lines] == [
        (line.measure, line.beats, line.tempo) for line in MAP.lines
    ]
    assert [line.time_s for line in found.lines] == pytest.approx([line.time_s for line in MAP.lines], abs=1e-5)
    if suffix != ".csv":
        assert found.phrases == MAP.phrases


def test_a_midi_player_has_the_measures_at_their_times(tmp_path: Path) -> None:
    """mido's own playing time of each marker, and of each beat in a ramp."""
    write_map(MAP, tmp_path / "map.mid")
    time, marks, tempi = 0.0, dict[str, float](), list[float]()
    for message in mido.MidiFile(tmp_path / "map.mid"):
        time += message.time
        if message.type == "marker":
            marks[message.text] = time
        if message.type == "set_tempo":
            tempi.append(message.tempo)
    assert marks == {f"measure {line.measure}": pytest.approx(line.time_s, abs=1e-4) for line in MAP.lines}
    assert len(tempi) > 20  # the ramp


def test_labels_of_audacity_and_plain_times_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("0.5\t0.5\t1\n\\\t20\t2000\n2.5\t2.5\t2\n4,5\t4,5\t3 3\n")
    assert [(line.time_s, line.beats) for line in read_map(tmp_path / "a.txt").lines] == [(0.5, 4), (2.5, 4), (4.5, 3)]
    (tmp_path / "b.csv").write_text("TIME,LABEL\n1.0\n2.0\n")
    assert [line.measure for line in read_map(tmp_path / "b.csv").lines] == [1, 2]


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.txt", b"1.0\t1.0\t1\n0.5\t0.5\t2\n", "a.txt, line 2: the lines go back: 0.5 s is not after 1 s"),
        ("a.txt", b"1.0\t1.0\tchorus\n", "line 1: the label 'chorus' is no measure"),
        ("a.txt", b"x\t1.0\t1\n", "line 1: 'x' is no time"),
        ("a.csv", b"1.0,1 99\n", "a measure of 99 beats"),
        ("a.csv", b"nan,1\n", "0 to 36000 expected"),
        ("a.csv", b"", "needs a measure line"),
        ("a.csv", b"\xff\xfe", "UTF-8"),
        ("a.csv", b"1.0,1\n2.0,5\n", "counted on by one"),
        ("a.mid", b"no", "not a MIDI file"),
        ("a.xyz", b"", "a name that ends in"),
    ],
)  # fmt: skip
def test_faulty_files_are_refused_with_their_line(tmp_path: Path, name: str, data: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(PersonError) as caught:
        read_map(tmp_path / name)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{}", "a list of corrections expected"), ("[", "cannot read"), ('[{"do": "shake"}]', "correction 1: do"),
        ('[{"do": "half"}, {"do": "move"}]', "correction 2: move needs time_s"),
        ('[{"do": "delete", "line": 0}]', "correction 1: line"),
    ],
)  # fmt: skip
def test_faulty_corrections_are_named(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "fixes.json").write_text(text)
    with pytest.raises(PersonError) as caught:
        read_fixes(tmp_path / "fixes.json")
    assert words in str(caught.value)


@pytest.mark.long
def test_the_command_prints_and_writes(tmp_path: Path) -> None:
    if not SONGS.is_dir():
        pytest.skip("the shared songs are absent")
    (tmp_path / "fixes.json").write_text('[{"do": "phrase", "line": 5, "name": "B"}]')
    out = tmp_path / "lines.txt"
    song = str(SONGS / "o01_band_080.ogg")
    done = run_live("music", "map", song, "--fix", str(tmp_path / "fixes.json"), "--out", str(out), "--json")
    assert done.returncode == 0, done.stderr
    values = json.loads(done.stdout)
    assert values["phrases"] == [{"measure": 5, "name": "B"}]
    assert len(read_map(out).lines) == len(values["lines"])
    again = run_live("music", "map", song, "--from", str(out), "--out", str(tmp_path / "lines.mid"))
    assert again.returncode == 0, again.stderr
    assert "80.0 bpm on average" in again.stdout
    refused = run_live("music", "map", song, "--out", str(tmp_path / "x.wav"))
    assert refused.returncode == 2
