"""A folder of recordings as steps: cut at the beats, aligned to the stage, with errors by file and line."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from live.library import recordings
from live.library.recording_file import RecordingError, read_step_files
from live.library.step_folder import load_folder
from live.motion import quaternion
from live.motion.mirror import mirror_step, swap_sides
from live.motion.step_clip import StepClip, measured_direction, measured_distance
from tests.fixtures.mocap import MOCAP, mocap_file
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, column, dance_values, still

ONE = """
file = "dance.bvh"
name = "sway"
bpm = 120
first_beat_s = 2.5
measures = 2
"""


@pytest.fixture(autouse=True)
def isolated_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("LIVE_CACHE_DIR", str(path))
    return path


def folder(tmp_path: Path, toml: str, values: np.ndarray | None = None) -> Path:
    """A folder with dance.bvh (10 s at 60 frames/s unless given) and steps.toml."""
    (tmp_path / "dance.bvh").write_text(body_bvh(dance_values(601) if values is None else values))
    (tmp_path / "steps.toml").write_text(toml)
    return tmp_path


def pose_at(step: StepClip, sample: float) -> tuple[np.ndarray, float]:
    """Position of the hips [m] and heading [rad] at a fractional sample."""
    before = min(math.floor(sample), step.clip.sample_count - 2)
    part = sample - before
    root = step.clip.root_position
    q = quaternion.slerp(step.clip.rotation[before, 0], step.clip.rotation[before + 1, 0], np.asarray(part))
    x, _, z = quaternion.rotate(q, np.array((0.0, 0.0, 1.0)))
    return root[before] * (1 - part) + root[before + 1] * part, math.atan2(x, z)


def problems_of(directory: Path) -> str:
    with pytest.raises(RecordingError) as caught:
        load_folder(directory)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_top_level_recording_is_one_step(tmp_path: Path) -> None:
    (step,) = load_folder(folder(tmp_path, ONE))
    assert (step.step, step.measures, step.beats_per_measure, step.bpm) == ("sway", 2, 4, 120.0)
    assert step.samples_per_measure == pytest.approx(120.0)
    assert step.clip.sample_rate == 60.0
    assert step.first >= step.samples_per_measure  # a whole measure of lead-in
    assert step.first + 240.0 <= step.clip.sample_count - 1
    assert step.direction == measured_direction(step)
    assert step.distance_m == measured_distance(step) > 0.05
    assert not step.mirrored


@pytest.mark.parametrize("first_beat", [2.5, 3.3217, 0.0])
def test_hips_are_centred_facing_audience_at_first_downbeat(tmp_path: Path, first_beat: float) -> None:
    (step,) = load_folder(folder(tmp_path, ONE.replace("2.5", str(first_beat))))
    place, heading = pose_at(step, step.first)
    assert np.hypot(place[0], place[2]) < 1e-4
    assert abs(heading) < 1e-3
    assert place[1] > 0.7


def test_beats_between_samples_are_exact(tmp_path: Path) -> None:
    """A body that turns by 20 degrees per second: the heading gives the time of every sample."""
    values = still(601)
    values[:, column("Hips", "Y")] = np.linspace(0.0, 200.0, 601)
    toml = ONE.replace("2.5", "2.51").replace("120", "97.3") + "start_measure = 2\n"
    (step,) = load_folder(folder(tmp_path, toml, values))
    measure = 4 * 60 / 97.3
    assert step.samples_per_measure == pytest.approx(measure * 60)
    for measures in (0.0, 0.5, 1.0, 2.0, -0.9):
        _, heading = pose_at(step, step.first + measures * step.samples_per_measure)
        assert math.degrees(heading) == pytest.approx(20.0 * measures * measure, abs=0.01)


@pytest.mark.long
def test_first_sample_is_held_when_recording_begins_late(tmp_path: Path) -> None:
    (step,) = load_folder(folder(tmp_path, ONE.replace("2.5", "0.5")))
    held = int(step.first - 0.5 * 60)
    assert held >= 89
    np.testing.assert_array_equal(step.clip.root_position[:held], step.clip.root_position[[0] * held])
    assert not np.allclose(step.clip.root_position[held + 5], step.clip.root_position[0])
    (early,) = load_folder(folder(tmp_path, ONE))
    assert not np.allclose(early.clip.root_position[10], early.clip.root_position[0])


@pytest.mark.long
def test_dropped_frames_do_not_count_as_time(tmp_path: Path) -> None:
    values = still(601)
    values[:, column("Hips", "Y")] = np.linspace(0.0, 200.0, 601)
    values[:30, column("Spine", "X")] = 80.0
    (whole,) = load_folder(folder(tmp_path, ONE.replace("2.5", "3.0") + "plant_feet = false\n", values))
    (kept,) = load_folder(folder(tmp_path, ONE + "plant_feet = false\ndrop_frames = 30\n", values))
    first = int(whole.first)
    np.testing.assert_allclose(
        kept.clip.rotation[first : first + 200], whole.clip.rotation[first : first + 200], atol=1e-5
    )


@pytest.mark.long
def test_given_frame_rate_scales_time(tmp_path: Path) -> None:
    (step,) = load_folder(folder(tmp_path, ONE + "fps = 30\nstart_measure = 7\n"))
    assert step.first == pytest.approx(120.0)
    assert "measures: the step ends with measure 4, but dance.bvh has 3 whole measures" in problems_of(
        folder(tmp_path, ONE + "start_measure = 3\n")
    )


def test_steps_of_one_file_share_common_keys(tmp_path: Path) -> None:
    toml = """
file = "dance.bvh"
bpm = 120
first_beat_s = 0.0
[[step]]
name = "one"
[[step]]
name = "two"
start_measure = 3
direction = "long left"
tags = ["slow", "low"]
leading_foot = "left"
begin_pose = "plie"
weight_transfer = true
distance_m = 0.4
author = "Ana"
style = "soft"
[[step]]
name = "two"
bpm = 60
mirror = true
"""
    steps = load_folder(folder(tmp_path, toml))
    assert [(s.step, s.bpm, s.mirrored) for s in steps] == [
        ("one", 120.0, False),
        ("two", 120.0, False),
        ("two", 60.0, False),
        ("two", 60.0, True),
    ]
    two = steps[1]
    assert (two.direction, two.distance_m, two.leading_foot, two.begin_pose) == ("long left", 0.4, "left", "plie")
    assert (two.weight_transfer, two.tags, two.author, two.style) == (True, ("slow", "low"), "Ana", "soft")
    assert (steps[0].weight_transfer, steps[0].tags, steps[0].leading_foot) == (False, (), "")
    assert steps[3].direction == swap_sides(measured_direction(steps[2]))
    np.testing.assert_array_equal(steps[3].clip.rotation, mirror_step(steps[2]).clip.rotation)


def test_files_are_read_in_name_order_without_pairs(tmp_path: Path) -> None:
    directory = folder(tmp_path, ONE)
    (directory / "a.toml").write_text(ONE.replace("sway", "first"))
    (directory / "pairs.toml").write_text('[[pair]]\nleader = { file = "x.bvh" }\n')
    assert [step.step for step in load_folder(directory)] == ["first", "sway"]


@mostly_long(
    ("old", "new", "words"),
    [
        ("measures = 2", "measures = 4", "line 6: measures: the step ends with measure 4, but dance.bvh has 3 whole"),
        ("measures = 2", "start_measure = 9", "line 6: start_measure: the step ends with measure 9"),
        ("first_beat_s = 2.5", "first_beat_s = 9", "line 5: first_beat_s: the step ends with measure 2, but"),
        ("measures = 2", "measures = 0", "line 6: measures: a whole number from 1 to 10,000 expected, found 0"),
        ("measures = 2", "measures = 1.5", "line 6: measures: "),
        ("bpm = 120", "", "line 1: bpm: missing; it must be given, as in file ="),
        ("first_beat_s = 2.5", "", "line 1: first_beat_s: missing"),
        ("bpm = 120", 'bpm = "fast"', "line 4: bpm: a number from 20 to 400 expected, found 'fast'"),
        ("bpm = 120", "bpm = nan", "line 4: bpm: "),
        ("bpm = 120", "bpm = 1e9", "line 4: bpm: a number from 20 to 400 expected, found 1000000000.0"),
        ("bpm = 120", "bmp = 120", "line 4: bmp: unknown key; did you mean 'bpm'? allowed are file, name"),
        ('"dance.bvh"', '"dnace.bvh"', "line 2: file: "),
        ('"dance.bvh"', '"steps.toml"', "line 2: file: "),
        ('"dance.bvh"', '"a\\u0000b"', "line 2: file: "),
        ("measures = 2", "drop_frames = 601", "line 6: drop_frames: 601, but the recording has 601 frames"),
        ("measures = 2", "unit_m = 1.0", "line 6: unit_m: unit_m 1.0: the dancer of"),
        ("measures = 2", 'up = "X"', "line 6: up: "),
        ("measures = 2", 'direction = "north"', "line 6: direction: 'north'; allowed are 'in place', 'short forward'"),
        ("measures = 2", "tags = [1]", "line 6: tags.1: "),
        ("measures = 2", 'mirror = "yes"', "line 6: mirror: "),
        ("measures = 2", "measures = ", "line 6: not valid TOML"),
        ("measures = 2", "step = 4", "line 6: step: a list of tables expected, each begun by [[step]]"),
    ], quick=[9, 16, 20, 21],
)  # fmt: skip
def test_invalid_field_is_reported_with_file_and_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in ONE
    message = problems_of(folder(tmp_path, ONE.replace(old, new)))
    assert f"steps.toml, {words}" in message


def test_broken_recording_is_reported(tmp_path: Path) -> None:
    directory = folder(tmp_path, ONE)
    text = (directory / "dance.bvh").read_text()
    (directory / "dance.bvh").write_text(text[: len(text) // 2])
    message = problems_of(directory)
    assert "steps.toml, line 2: file: " in message
    assert "dance.bvh, line " in message
    assert "the file is cut off" in message
    (directory / "dance.bvh").write_bytes(bytes(range(256)) * 50)
    assert "a BVH file begins with HIERARCHY" in problems_of(directory)


def test_truncated_recording_is_reported_unless_one_frame_is_missing(tmp_path: Path) -> None:
    directory = folder(tmp_path, ONE)
    lines = (directory / "dance.bvh").read_text().splitlines(keepends=True)
    (directory / "dance.bvh").write_text("".join(lines[:-1]))
    assert len(load_folder(directory)) == 1
    (directory / "dance.bvh").write_text("".join(lines[:-40]))
    assert "is cut off: it declares 601 frames and has 561" in problems_of(directory)


def test_several_problems_are_reported_together(tmp_path: Path) -> None:
    toml = '[[step]]\nfile = "no.bvh"\nname = ""\n[[step]]\nname = "b"\nbpm = 3\ncolour = 1\n'
    message = problems_of(folder(tmp_path, toml))
    for words in ("line 3: step.1.name", "step.1.bpm: missing", "line 6: step.2.bpm", "line 7: step.2.colour: unknown"):
        assert words in message
    many = "".join(f'[[step]]\nfile = "no{n}.bvh"\nname = "n"\nbpm = 120\nfirst_beat_s = 0\n' for n in range(20))
    assert "; and 12 more" in problems_of(folder(tmp_path, many))


def test_invalid_common_key_is_reported_at_its_line(tmp_path: Path) -> None:
    toml = 'file = "dance.bvh"\nfirst_beat_s = 0\nbpm = 9\n[[step]]\nname = "a"\n'
    assert "line 3: bpm: a number from 20 to 400 expected, found 9" in problems_of(folder(tmp_path, toml))


def test_folder_without_usable_files_is_refused(tmp_path: Path) -> None:
    assert "there is no folder" in problems_of(tmp_path / "nowhere")
    assert "no TOML file" in problems_of(tmp_path)
    (tmp_path / "dance.bvh").write_text(body_bvh(still(3)))
    message = problems_of(tmp_path)
    assert "describes steps in its 1 recordings" in message
    assert 'steps.toml with file = "walk.bvh", name = "walk", bpm = 120, first_beat_s = 0.5, measures = 2' in message
    (tmp_path / "deep.toml").write_text("x = " + "[" * 5000 + "]" * 5000)
    assert "deep.toml" in problems_of(tmp_path)
    (tmp_path / "deep.toml").write_bytes(b"\xff\xfe")
    assert "not a text in UTF-8 (byte 0)" in problems_of(tmp_path)
    (tmp_path / "deep.toml").unlink()
    (tmp_path / "folder.toml").mkdir()
    assert "folder.toml: not a file" in problems_of(tmp_path)


def test_recording_is_read_once_for_all_its_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[Path] = []
    read_motion = recordings.read_motion
    monkeypatch.setattr(
        recordings, "read_motion", lambda path, **options: read.append(path) or read_motion(path, **options)
    )
    toml = 'file = "dance.bvh"\nbpm = 120\nfirst_beat_s = 0\n' + '[[step]]\nname = "a"\n' * 5
    assert len(load_folder(folder(tmp_path, toml))) == 5
    assert len(read) == 1


def fail_on_rebuild(entries: object) -> list[StepClip]:
    pytest.fail("cut again although nothing changed")


def test_cached_steps_are_reused_until_their_files_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    directory = folder(tmp_path, ONE + "mirror = true\n")
    (directory / "other.bvh").write_text(body_bvh(dance_values(601, seed=7)))
    (directory / "other.toml").write_text(ONE.replace("dance.bvh", "other.bvh").replace("sway", "other"))
    first = load_folder(directory)
    with monkeypatch.context() as patched:
        patched.setattr(recordings, "_build_steps", fail_on_rebuild)
        again = load_folder(directory)
    assert [step.step for step in again] == ["other", "sway", "sway"]
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a.clip.rotation, b.clip.rotation)
        np.testing.assert_array_equal(a.clip.root_position, b.clip.root_position)
        assert (a.first, a.direction, a.distance_m, a.mirrored) == (b.first, b.direction, b.distance_m, b.mirrored)

    built: list[str] = []
    build = recordings._build_steps
    monkeypatch.setattr(
        recordings, "_build_steps", lambda entries: built.append(entries[0].recording.name) or build(entries)
    )
    (directory / "dance.bvh").write_text(body_bvh(dance_values(601, seed=9)))
    changed = load_folder(directory)
    assert built == ["sway"]
    assert not np.array_equal(changed[1].clip.rotation, first[1].clip.rotation)
    (directory / "other.toml").write_text((directory / "other.toml").read_text() + 'style = "soft"\n')
    assert load_folder(directory)[0].style == "soft"
    assert built == ["sway", "other"]


def test_missing_recording_is_reported_despite_cache(tmp_path: Path) -> None:
    directory = folder(tmp_path, ONE)
    load_folder(directory)
    (directory / "dance.bvh").unlink()
    assert "line 2: file: " in problems_of(directory)


def test_recording_without_read_permission_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    directory = folder(tmp_path, ONE)
    read = Path.read_bytes

    def denied(path: Path) -> bytes:
        if path.suffix == ".bvh":
            raise PermissionError(13, "Permission denied", str(path))
        return read(path)

    monkeypatch.setattr(Path, "read_bytes", denied)
    assert "line 2: file: " in problems_of(directory)
    assert "dance.bvh: cannot be read: Permission denied" in problems_of(directory)


def test_problems_of_all_files_are_reported_together(tmp_path: Path) -> None:
    directory = folder(tmp_path, ONE.replace("measures = 2", "measures = 9"))
    (directory / "b.toml").write_text(ONE.replace("bpm = 120", "bpm = 1"))
    message = problems_of(directory)
    assert "b.toml, line 4: bpm: " in message
    assert "steps.toml, line 6: measures: " in message


def salsa_toml() -> str:
    """Both dancers of two takes, two measures at a time, with the estimated beats."""
    mocap_file("salsa/60_01.bvh")
    lines = ["fps = 60", "drop_frames = 6"]
    for take in json.loads((MOCAP / "beats_estimated.json").read_text()):
        for file in take["files"]:
            if file in ("salsa/60_01.bvh", "salsa/61_01.bvh", "salsa/60_03.bvh", "salsa/61_03.bvh"):
                for start in range(1, take["measures_of_4"] - 2, 4):
                    lines += ["[[step]]", f'file = "{MOCAP / file}"', 'name = "salsa"', f"bpm = {60 / take['beat_s']}"]
                    lines += [f"first_beat_s = {take['phase_of_4beats_s']}", f"start_measure = {start}", "measures = 2"]
    return "\n".join(lines)


@pytest.mark.long
@pytest.mark.shared
def test_real_salsa_recordings_load_as_steps(tmp_path: Path) -> None:
    (tmp_path / "salsa.toml").write_text(salsa_toml())
    assert sum(map(len, read_step_files(tmp_path).recordings.values())) == 22
    steps = load_folder(tmp_path)
    assert len(steps) == 22
    for step in steps:
        place, heading = pose_at(step, step.first)
        assert np.hypot(place[0], place[2]) < 1e-3
        assert abs(heading) < 0.02
        assert 1.4 < step.samples_per_measure / 60.0 < 1.5
        height = step.clip.root_position[:, 1]
        assert height.min() > 0.3
        assert height.max() < 1.15
        speed = np.linalg.norm(np.diff(step.clip.root_position, axis=0), axis=-1) * 60.0
        assert speed.max() < 4.0
        assert 0.1 < step.clip.contact.mean() < 1.0
