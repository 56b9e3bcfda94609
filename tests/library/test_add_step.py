"""Adding a step: checked before writing, copied once, no file overwritten, undone on failure."""

import tomllib
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.library import add_step as add_step_module
from live.library.add_step import AddedStep, add_step, known_fields, refuse_duplicate, request_entry
from live.library.recording_file import RecordingError
from live.library.recordings import RecordingReader
from live.library.step_folder import load_folder
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, dance_values

FIELDS = {"name": "sway", "bpm": 120.0, "first_beat_s": 2.5, "measures": 2}


@pytest.fixture(autouse=True)
def isolated_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))


@pytest.fixture
def take(tmp_path: Path) -> Path:
    path = tmp_path / "take one.bvh"
    path.write_text(body_bvh(dance_values(601)))
    return path


def add(library: Path, take: Path, **fields: object) -> AddedStep:
    return add_step(library, request_entry(take, FIELDS | fields))


@pytest.mark.long
def test_new_library_contains_recording_and_description(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "new" / "library"
    added = add(library, take, tags=["slow"], leading_foot="left")
    assert added.copied
    assert added.file.read_bytes() == take.read_bytes()
    assert tomllib.loads(added.toml.read_text())["step"] == [
        {"file": "take one.bvh", **FIELDS, "tags": ["slow"], "leading_foot": "left"}
    ]
    (step,) = load_folder(library)
    assert (step.step, step.measures, step.tags, step.leading_foot) == ("sway", 2, ("slow",), "left")
    assert (step.clip.rotation == added.step.clip.rotation).all()


@pytest.mark.long
def test_second_step_is_appended_and_recording_copied_once(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    first = add(library, take)
    first.toml.write_text("# mine\n" + first.toml.read_text())
    second = add(library, take, name="other", start_measure=2)
    assert second.toml == first.toml
    assert not second.copied
    assert first.toml.read_text().startswith("# mine\n")
    assert sorted(path.name for path in library.iterdir()) == ["take one.bvh", "take one.toml"]
    assert [step.step for step in load_folder(library)] == ["sway", "other"]


@pytest.mark.long
def test_recording_inside_library_is_referenced_in_place(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    (library / "may").mkdir(parents=True)
    inside = library / "may" / "take.bvh"
    inside.write_bytes(take.read_bytes())
    added = add(library, inside)
    assert not added.copied
    assert tomllib.loads(added.toml.read_text())["step"][0]["file"] == "may/take.bvh"
    assert len(load_folder(library)) == 1


@pytest.mark.long
def test_other_recording_of_same_name_is_not_overwritten(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    add(library, take)
    kept = take.read_bytes()
    take.write_text(body_bvh(dance_values(601, seed=8)))
    added = add(library, take, name="second")
    assert added.file.name == "take one-2.bvh"
    assert (library / "take one.bvh").read_bytes() == kept
    assert [step.step for step in load_folder(library)] == ["sway", "second"]


@mostly_long(
    "text",
    ['[[pair]]\nleader = { file = "x.bvh" }\n', "not TOML at all", 'name = "bob"\n[pelvis]\n"1" = "down 4"\n', "\xff"],
    quick=[2, 3],
)
def test_incompatible_toml_file_is_unchanged(tmp_path: Path, take: Path, text: str) -> None:
    library = tmp_path / "library"
    library.mkdir()
    (library / "take one.toml").write_bytes(text.encode("latin-1"))
    added = add(library, take)
    assert added.toml.name == "take one-2.toml"
    assert (library / "take one.toml").read_bytes() == text.encode("latin-1")


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"bpm": 1000.0}, "take one.bvh: --bpm: a number from 20 to 400 expected, found 1000.0"),
        ({"first_beat_s": -1.0}, "--anchor: a number from 0 to 36,000 expected"),
        ({"start_measure": 40}, "--start: the step ends with measure 41, but"),
        ({"unit_m": 1.0}, "--unit: unit_m 1.0: the dancer of"),
        ({"drop_frames": 601}, "--drop-frames: 601, but the recording has 601 frames"),
        ({"direction": "north"}, "--direction: 'north'; allowed are 'in place'"),
        ({"name": ""}, "--name: a text in quotes of 1 to 64 characters expected"),
        ({"tags": [""]}, "--tag: a text in quotes"),
        ({"distance_m": 1e9}, "--distance: a number from 0 to 100 expected"),
    ],
)
def test_invalid_field_is_refused_by_option_and_nothing_is_written(
    tmp_path: Path, take: Path, fields: dict[str, object], words: str
) -> None:
    library = tmp_path / "library"
    with pytest.raises(RecordingError) as caught:
        add(library, take, **fields)
    assert words in str(caught.value)
    assert not library.exists()


def test_missing_options_and_files_are_reported(tmp_path: Path, take: Path) -> None:
    with pytest.raises(RecordingError, match=r"--bpm: must be given.*--anchor: must be given"):
        request_entry(take, {"name": "x"})
    with pytest.raises(RecordingError, match=r"gone\.bvh: there is no such file"):
        add(tmp_path / "library", tmp_path / "gone.bvh")
    (tmp_path / "broken.bvh").write_text(take.read_text()[:5000])
    with pytest.raises(RecordingError, match=r"broken\.bvh: line \d+: "):
        add(tmp_path / "library", tmp_path / "broken.bvh")
    assert not (tmp_path / "library").exists()


def test_failed_addition_is_undone(tmp_path: Path, take: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = tmp_path / "library"
    library.mkdir()

    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(add_step_module, "_write_description", full)
    with pytest.raises(PersonError, match=r"cannot write into the library .*No space left"):
        add(library, take)
    assert list(library.iterdir()) == []


def test_interrupted_change_keeps_old_text(tmp_path: Path, take: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = tmp_path / "library"
    before = add(library, take).toml.read_text()

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(add_step_module.os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        add(library, take, name="other")
    assert (library / "take one.toml").read_text() == before
    assert sorted(path.name for path in library.iterdir()) == ["take one.bvh", "take one.toml"]


def test_impossible_library_folder_is_refused(tmp_path: Path, take: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(PersonError, match="cannot make the library"):
        add(tmp_path / "file" / "library", take)


def test_multi_file_recording_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, take: Path) -> None:
    path = tmp_path / "parts.gltf"
    path.write_text('{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "parts.bin"}]}')
    clip = RecordingReader().clip(request_entry(take, FIELDS))
    monkeypatch.setattr(RecordingReader, "clip", lambda self, entry: clip)
    with pytest.raises(RecordingError, match=r"parts\.gltf: its motion lies in parts\.bin; export it as one file"):
        add(tmp_path / "library", path)
    path.write_text(path.read_text().replace("parts.bin", "data:application/octet-stream;base64,AAAA"))
    assert add(tmp_path / "library", path).copied


def test_known_fields_of_recording_are_reused(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    assert known_fields(tmp_path / "nowhere", take, {}) == ({}, {})
    add(library, take, fps=30.0, drop_frames=5, bpm=96.0, tags=["slow"])
    music = {"bpm": 96, "first_beat_s": 2.5, "drop_frames": 5}
    assert known_fields(library, take, {})[0] == {"fps": 30, **music}
    assert known_fields(library, take, {"fps": 30.0})[0] == music
    assert known_fields(library, take, {"fps": 60.0})[0] == {}  # at another rate all times are others
    assert known_fields(library, take, {"drop_frames": 9})[0] == {"fps": 30}
    assert known_fields(library, take, {"bpm": 100.0})[0] == {"fps": 30}
    other = tmp_path / "other.bvh"
    other.write_text(body_bvh(dance_values(601, seed=3)))
    assert known_fields(library, other, {})[0] == {}
    (library / "broken.toml").write_text("x = ")
    assert known_fields(library, take, {})[0] == {"fps": 30, **music}


def test_guess_comment_is_kept_until_removed(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    marks = {"bpm": "guess: confirm", "first_beat_s": "guess: confirm"}
    add_step(library, request_entry(take, FIELDS), comments=marks)
    assert known_fields(library, take, {})[1] == marks
    assert known_fields(library, take, {"bpm": 100.0})[1] == {}
    toml = library / "take one.toml"
    toml.write_text(toml.read_text().replace(" # guess: confirm", "", 1))
    assert known_fields(library, take, {})[1] == {"first_beat_s": "guess: confirm"}
    toml.write_text(toml.read_text().replace(" # guess: confirm", ""))
    assert known_fields(library, take, {})[1] == {}


def test_duplicate_step_is_refused(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    refuse_duplicate(library, request_entry(take, FIELDS))  # there is no library yet
    add(library, take)
    with pytest.raises(PersonError, match=r"the step 'sway' is there already: .*take one\.toml, line 3"):
        refuse_duplicate(library, request_entry(take, FIELDS | {"tags": ["other words"]}))
    for other in ({"name": "swing"}, {"start_measure": 2}, {"bpm": 96.0}, {"fps": 30.0}):
        refuse_duplicate(library, request_entry(take, FIELDS | other))
    another = tmp_path / "another.bvh"
    another.write_text(body_bvh(dance_values(601, seed=3)))
    refuse_duplicate(library, request_entry(another, FIELDS))


def test_blank_or_multiline_name_is_refused(tmp_path: Path, take: Path) -> None:
    with pytest.raises(PersonError, match=r"--name: a text that is not blank, without line breaks .* found 'a\\nb'"):
        add(tmp_path / "library", take, name="a\nb")
    with pytest.raises(PersonError, match=r"--name: a text that is not blank, .* found '  '"):
        add(tmp_path / "library", take, name="  ")
    assert not (tmp_path / "library").exists()
