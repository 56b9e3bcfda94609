"""A new show for the studio: from a song and a number of dancers, or a copy of an example."""

from pathlib import Path

import pytest

from live.app.services import new_show
from live.app.services.new_show import MAX_DANCERS, examples, make_show
from live.base.errors import PersonError
from live.clock.measure_map import MeasureLine, MeasureMap
from live.rehearse.lint import lint_show
from live.show.loader import load_show
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.fixtures.mostly_long import mostly_long
from tests.places import SHARED

SONG = PATCHES / "music" / "first_show.ogg"


def counted(monkeypatch: pytest.MonkeyPatch, metre: int) -> None:
    lines = [MeasureLine(0.5 + 2.0 * index, index + 1, metre) for index in range(24)]
    monkeypatch.setattr(new_show, "read_measures", lambda song: MeasureMap(lines))


@mostly_long(
    ("metre", "dancers"),
    [(4, 12), (4, 1), (3, 5), *(pytest.param(*one, marks=pytest.mark.long) for one in ((4, 120), (2, 8), (5, 9)))],
    quick=[1],
)
def test_a_song_becomes_a_show_that_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, metre: int, dancers: int
) -> None:
    counted(monkeypatch, metre)
    path = make_show(tmp_path / "deep" / 'my "first"_piece', song=SONG, dancers=dancers)
    loaded = load_show(path)
    patch = loaded.patch
    assert patch.name == 'My "first" piece'
    assert patch.dancer_count == dancers
    assert patch.clock.beats_per_measure == metre
    assert [line.time_s for line in patch.music.line] == [0.5 + 2.0 * index for index in range(24)]
    assert loaded.music_path == path.parent / SONG.name
    assert patch.segment[0].formation == patch.formation[0]["name"]
    show = loaded.start()
    for tick in range(1, 400):
        show.tick(tick / 64)
    warnings = [words for section in lint_show(loaded.start(begin=False)) for words in section.warnings]
    assert not [words for words in warnings if "outside" in words or "off the stage" in words]
    assert sorted(one.name for one in tmp_path.iterdir()) == ["deep"]


@mostly_long(
    "example",
    [pytest.param(name, marks=[pytest.mark.long] * (place % 8 != 4)) for place, name in enumerate(examples())],
    quick=[],
)
def test_an_example_is_copied_with_its_files(tmp_path: Path, example: str) -> None:
    path = make_show(tmp_path / "copy", example=example)
    loaded = load_show(path)
    assert loaded.patch.name == "Copy"
    own = load_show(PATCHES / "first_show.toml" if example == "first_show" else PATCHES / example / "show.toml")
    assert loaded.patch.model_copy(update={"name": own.patch.name}) == own.patch
    assert loaded.music_path is None or loaded.music_path.is_relative_to(tmp_path)
    assert not (path.parent / ".history").exists()


def test_nothing_is_written_if_it_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    counted(monkeypatch, 7)
    full = tmp_path / "full"
    full.mkdir()
    (full / "mine.txt").write_text("kept")
    wrong = tmp_path / "wrong.ogg"
    wrong.write_text("no music")
    for where, how in (
        (tmp_path / "a", {"song": SONG}),
        (tmp_path / "a", {}),
        (tmp_path / "a", {"song": SONG, "example": "samba"}),
        (tmp_path / "a", {"example": "../samba"}),
        (tmp_path / "a", {"example": "samba", "dancers": 4}),
        (tmp_path / "a", {"song": SONG, "dancers": MAX_DANCERS + 1}),
        (tmp_path / "a", {"song": SONG, "dancers": 0}),
        (full, {"example": "samba"}),
        (full / "mine.txt" / "x", {"example": "samba"}),
    ):
        with pytest.raises(PersonError):
            make_show(where, **how)
    monkeypatch.undo()
    with pytest.raises(PersonError):
        make_show(tmp_path / "a", song=wrong)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["full", "wrong.ogg"]
    assert (full / "mine.txt").read_text() == "kept"


@pytest.mark.long
def test_an_empty_folder_is_taken_and_measures_are_heard(tmp_path: Path) -> None:
    song = SHARED / "beats" / "open" / "o04_band_125_live.ogg"
    if not song.is_file():
        pytest.skip("the shared songs are absent")
    (tmp_path / "empty").mkdir()
    patch = load_show(make_show(tmp_path / "empty", song=song)).patch
    assert patch.dancer_count == 12
    assert len(patch.music.line) > 10


def test_the_command_names_what_is_wrong(tmp_path: Path) -> None:
    done = run_live("studio", str(tmp_path / "new"), "--from", "nothing", "--no-browser")
    assert done.returncode == 2
    assert "there is no example 'nothing'" in done.stderr
