"""Tests of whole recordings cut into steps: sketches danced one after another, cut, added and loaded again."""

import json
import os
import tomllib
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library, plain_name
from live.library.step_folder import load_folder
from live.library.vocabulary import add_vocabulary, find_vocabulary, names_in, renamed
from live.library.vocabulary_sheet import sheet_page
from live.motion import quaternion
from live.motion.beats.music_reference import MusicReference
from live.motion.clip import Clip, read_clip
from live.motion.formats.bvh_writer import write_bvh
from live.motion.mirror import mirror_step
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.motion.formats.made_bvh import body_bvh, dance_values

RATE, BPM = 60.0, 120.0
SAMPLES = 120
"""Samples of a measure of four beats."""


@pytest.fixture(autouse=True)
def isolated_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def sketches():
    """Four movements that are unlike each other, as steps of one measure."""
    clips = load_folder(PATCHES / "steps")
    wanted = {"forward": ("walk", "long forward"), "left": ("walk", "long left"), "samba": ("samba", "in place")}
    found = {
        key: next(c for c in clips if (c.step, c.direction, c.mirrored) == (*of, False)) for key, of in wanted.items()
    }
    return found | {"right": mirror_step(found["left"])}


def danced(sketches, names) -> Clip:
    """A recording of movements one after another, each from where the last ended."""
    parts, place = [], np.zeros(3)
    for name in names:
        step = sketches[name]
        at = step.first + np.arange(SAMPLES) * (step.samples_per_measure / SAMPLES)
        root, rotation, contact = read_clip(step.clip, at)
        end = read_clip(step.clip, np.array([step.first + step.samples_per_measure]))[0][0]
        parts.append((root - root[0] * (1.0, 0.0, 1.0) + place, rotation, contact))
        place = place + (end - root[0]) * (1.0, 0.0, 1.0)
    parts.append(tuple(part[-1:].repeat(12, axis=0) for part in parts[-1]))
    root, rotation, contact = (np.concatenate(part) for part in zip(*parts, strict=True))
    rotation = np.ascontiguousarray(quaternion.align_signs(rotation), np.float32)
    return Clip("danced", root.astype(np.float32), rotation, RATE, contact)


def recording(path: Path, sketches, names) -> Path:
    path.write_text(write_bvh(danced(sketches, names)))
    return path


def on_the_beat(file, fields):
    return fields | {"bpm": BPM, "first_beat_s": 0.0}, {}, None


PIECE = ["forward", "left", "samba", "samba", "forward", "left", "right", "samba", "forward", "left"]


@pytest.fixture
def take(tmp_path: Path, sketches) -> Path:
    return recording(tmp_path / "rehearsal.bvh", sketches, PIECE)


@pytest.mark.long
def test_steps_are_found_named_added_and_danced(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    found = find_vocabulary([take], {}, on_the_beat, library=library)
    assert [(step.name, step.found.measures, len(step.found.starts)) for step in found.steps][1:] == [
        ("step in place, arms wide", 1, 3), ("travel right", 1, 1),
    ]  # fmt: skip
    phrase = found.steps[0]
    assert (phrase.found.measures, sorted(phrase.found.starts)) == (2, [0, 4, 8])
    added = add_vocabulary(library, found, found.steps)
    assert (len(added.steps), added.cuts, added.known) == (3, 7, 0)
    assert sorted(path.name for path in library.iterdir()) == ["rehearsal.bvh", "rehearsal.toml"]
    clips = load_folder(library)
    assert sorted((clip.step, clip.measures) for clip in clips) == sorted(
        (step.name, step.found.measures) for step in found.steps for _ in step.found.starts
    )
    library_graph = build_graph(build_library(clips), window=0.25, threshold=0.35)
    assert library_graph.edge_count > 0


@pytest.mark.long
def test_cutting_again_adds_nothing_and_names_stay_the_same(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    found = find_vocabulary([take], {}, on_the_beat, library=library)
    add_vocabulary(library, found, found.steps[:2])
    before = {path: path.read_bytes() for path in library.iterdir()}
    again = find_vocabulary([take], {}, on_the_beat)
    assert [step.name for step in again.steps] == [step.name for step in found.steps]
    with pytest.raises(PersonError, match=r"all 6 cuts are in .* already"):
        add_vocabulary(library, again, again.steps[:2])
    assert {path: path.read_bytes() for path in library.iterdir()} == before
    rest = add_vocabulary(library, again, again.steps)
    assert (rest.cuts, rest.known) == (1, 6)
    assert all(path.read_bytes() == data for path, data in before.items())
    assert len(load_folder(library)) == 7


@pytest.mark.long
def test_names_of_the_library_are_not_used_again(tmp_path: Path, sketches, take: Path) -> None:
    library = tmp_path / "library"
    other = recording(tmp_path / "other.bvh", sketches, ["samba", "right"])
    first = find_vocabulary([other], {}, on_the_beat, library=library)
    add_vocabulary(library, first, first.steps)
    found = find_vocabulary([take], {}, on_the_beat, library=library)
    names = {plain_name(step.name) for step in found.steps}
    assert not names & {plain_name(name) for name in names_in(library)}
    assert "step in place, arms wide 2" in names
    with pytest.raises(PersonError, match="the library has a step called so"):
        renamed(found, {1: "Step-in_place, arms wide"}, library)
    with pytest.raises(PersonError, match="step 2 is called so"):
        renamed(found, {1: found.steps[1].name}, library)
    assert renamed(found, {2: "samba roll"}, library).steps[1].name == "samba roll"


@pytest.mark.long
def test_a_file_of_that_name_with_other_contents_is_left_alone(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    library.mkdir()
    (library / "rehearsal.bvh").write_text("mine")
    (library / "rehearsal.toml").write_text("# mine, not yet written\n")
    found = find_vocabulary([take], {}, on_the_beat)
    added = add_vocabulary(library, found, found.steps)
    assert (library / "rehearsal.bvh").read_text() == "mine"
    assert (library / "rehearsal.toml").read_text() == "# mine, not yet written\n"
    assert added.tomls == (library / "rehearsal-2.toml",)
    assert tomllib.loads(added.tomls[0].read_text())["file"] == "rehearsal-2.bvh"


@pytest.mark.long
def test_takes_are_limited_to_the_most_typical(tmp_path: Path, sketches) -> None:
    """One measure many times: one step, of which some are added."""
    file = recording(tmp_path / "groove.bvh", sketches, ["samba"] * 30)
    found = find_vocabulary([file], {}, on_the_beat)
    (step,) = found.steps
    assert len(step.found.starts) == 30
    assert add_vocabulary(tmp_path / "library", found, found.steps, takes=5).cuts == 5


@pytest.mark.long
def test_two_recordings_share_their_steps(tmp_path: Path, sketches, take: Path) -> None:
    other = recording(tmp_path / "second.bvh", sketches, ["samba", "right", "right"])
    found = find_vocabulary([take, other], {}, on_the_beat)
    samba = next(step for step in found.steps if step.name.startswith("step in place, arms wide"))
    assert sorted((t.name, n) for t, n in map(found.place, samba.found.starts)) == [
        ("rehearsal.bvh", 3), ("rehearsal.bvh", 4), ("rehearsal.bvh", 8), ("second.bvh", 1),
    ]  # fmt: skip
    added = add_vocabulary(tmp_path / "library", found, found.steps)
    assert [toml.name for toml in added.tomls] == ["rehearsal.toml", "second.toml"]
    assert len(load_folder(tmp_path / "library")) == added.cuts


@pytest.mark.long
def test_dancers_of_unlike_skeletons_are_one_vocabulary(tmp_path: Path, take: Path) -> None:
    """Another program's joints, names and units; a file that is given twice counts once."""
    other = tmp_path / "other.bvh"
    other.write_text(body_bvh(dance_values(601)))
    found = find_vocabulary([take, other, take], {}, on_the_beat)
    assert [len(one.lines) - 1 for one in found.takes] == [10, 5]
    assert sum(step.found.measures * len(step.found.starts) for step in found.steps) == 15
    add_vocabulary(tmp_path / "library", found, found.steps)
    assert {clip.clip.rotation.shape[1] for clip in load_folder(tmp_path / "library")} == {22}


def test_a_recording_shorter_than_a_measure_is_refused(tmp_path: Path, take: Path) -> None:
    def late(file, fields):
        return fields | {"bpm": BPM, "first_beat_s": 19.0}, {}, None

    with pytest.raises(PersonError, match=r"rehearsal.bvh: not one whole measure: it lasts 20\.1"):
        find_vocabulary([take], {}, late)


def test_a_read_only_folder_is_left_as_it_was(tmp_path: Path, take: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = tmp_path / "library"
    found = find_vocabulary([take], {}, on_the_beat)
    opened = Path.open

    def refuse(self, mode="r", *args, **kwargs):
        if "x" in mode and self.suffix == ".toml":
            raise PermissionError(13, "Permission denied")
        return opened(self, mode, *args, **kwargs)

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(PersonError, match="cannot write into the library"):
        add_vocabulary(library, found, found.steps)
    assert list(library.iterdir()) == []


@pytest.mark.long
def test_the_tempo_of_a_long_guess_may_change(tmp_path: Path, sketches) -> None:
    """Steps of a recording whose tempo was followed have beats of their own, and are as long as they were danced."""
    names = ["forward", "left", "samba", "right"] * 10
    clip = danced(sketches, names)
    count = clip.sample_count
    time = np.arange(count) / count
    slower = np.cumsum(1.0 + 0.06 * np.sin(2 * np.pi * time))  # up to six per cent faster and slower
    root, rotation, contact = read_clip(clip, slower * (count - 1) / slower[-1])
    warped = Clip("warped", root.astype(np.float32), np.ascontiguousarray(rotation, np.float32), RATE, contact)
    file = tmp_path / "long.bvh"
    file.write_text(write_bvh(warped))
    guess = MusicReference(0.0, BPM, 0.3, "feet", "")

    def guessed(file, fields):
        return fields | {"bpm": BPM, "first_beat_s": 0.0}, {"bpm": "guess: confirm"}, guess

    found = find_vocabulary([file], {}, guessed)
    even = find_vocabulary([file], {}, on_the_beat)
    lines = found.takes[0].lines
    true = np.interp(np.arange(0, 41) * SAMPLES, slower * (count - 1) / slower[-1], np.arange(count)) / RATE
    off = [np.abs(one[:38] - true[:38]) for one in (lines, even.takes[0].lines)]
    assert np.median(off[0]) < 0.35 * np.median(off[1])
    added = add_vocabulary(tmp_path / "library", found, found.steps)
    table = tomllib.loads(added.tomls[0].read_text())
    assert all("first_beat_s" in step and "start_measure" not in step for step in table["step"])
    assert len({clip.bpm for clip in load_folder(tmp_path / "library")}) > 3


@pytest.mark.long
def test_the_sheet_has_a_row_with_figures_for_each_step(take: Path) -> None:
    found = renamed(find_vocabulary([take], {}, on_the_beat), {2: "<b> & co"})
    page = sheet_page(found, "live steps cut take.bvh --accept all")
    assert page.count("<section") == len(found.steps)
    assert "&lt;b&gt; &amp; co" in page
    assert "3 times" in page
    assert "measures 1-2, 5-6, 9-10" in page
    assert page.count("<svg") == sum(4 * step.found.measures + 2 for step in found.steps)
    assert "http" not in page.replace("http-equiv", "")


@pytest.mark.long
def test_the_command_shows_then_adds(tmp_path: Path, take: Path) -> None:
    library, sheet = tmp_path / "library", tmp_path / "sheet.html"
    asked = ("steps", "cut", str(take), "--bpm", "120", "--anchor", "0", "--library", str(library))
    shown = run_live(*asked, "--sheet", str(sheet), "--json")
    data = json.loads(shown.stdout)
    assert [step["times"] for step in data["steps"]] == [3, 3, 1]
    assert data["steps"][0]["places"][1] == {"file": "rehearsal.bvh", "measure": 5}
    assert not library.exists()
    assert "--accept all" in sheet.read_text()
    added = run_live(*asked, "--accept", "1,3", "--rename", "1=promenade")
    assert added.returncode == 0, added.stderr
    assert "added 2 steps with 4 takes" in added.stdout
    assert {clip.step for clip in load_folder(library)} == {"promenade", "travel right"}
    refused = run_live(*asked, "--accept", "4")
    assert refused.returncode != 0
    assert "numbers from 1 to 3 expected" in refused.stderr


def test_a_recording_without_a_beat_says_so(tmp_path: Path, sketches) -> None:
    clip = danced(sketches, ["samba"])
    still = Clip("still", *(part[:1].repeat(300, axis=0) for part in (clip.root_position, clip.rotation)), RATE,
                 np.ones((300, 2), np.bool_))  # fmt: skip
    file = tmp_path / "still.bvh"
    file.write_text(write_bvh(still))
    result = run_live("steps", "cut", str(file), "--library", str(tmp_path / "library"), "--accept", "all")
    assert result.returncode != 0
    assert "--anchor SECONDS --bpm BPM" in result.stderr
    assert os.listdir(tmp_path) == ["still.bvh"] or not (tmp_path / "library").exists()
