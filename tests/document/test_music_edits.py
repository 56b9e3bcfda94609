"""Other music for a show: one revision with its measures, told what no longer fits, undone byte by byte."""

from pathlib import Path

import pytest

from live.clock.measure_map import MeasureLine, MeasureMap, Phrase, steady_map
from live.document.document_store import DocumentStore
from live.document.edit import Edit, EditRefused
from live.document.music_edits import replace_music
from live.library.music_map_file import write_map
from live.show.patch.patch_reader import read_patch
from tests.cli.command import run_live
from tests.fixtures.mostly_long import mostly_long

HEAD = """# A show for tests.
name = "x"

[[group]]
name = "ember"
dancers = 4
steps = ["groove x2"]

[[section]]
name = "verse"
measures = 8   # the long one

[[section]]
name = "coda"
measures = 4

[[segment]]
section = "coda"
measure = 3
formation = "circle"
"""
MUSIC = """
[music]
file = "old.ogg"   # of last year
bpm = 100
one_at_s = 0.5
"""


def show_of(folder: Path, lines: int) -> Path:
    rows = "".join(
        f"\n[[music.line]]\ntime_s = {0.5 + 2.4 * k:.1f}  # by ear\nmeasure = {k + 1}\n" for k in range(lines)
    )
    path = folder / "show.toml"
    path.write_text(HEAD + MUSIC + rows + "\n[[music.phrase]]\nmeasure = 1\nname = 'A'\n" * bool(lines))
    return path


@mostly_long(("before", "after"), [(0, 12), (12, 9), (180, 220), (12, 0)], quick=[0, 1, 3])
def test_music_is_replaced_as_one_revision_that_can_be_undone(tmp_path: Path, before: int, after: int) -> None:
    path = show_of(tmp_path, before)
    text = path.read_text()
    store = DocumentStore(path)
    fresh = steady_map(130.0, 1.234567, 4, after) if after else None
    if fresh is not None:
        lines = [*fresh.lines[:-1], MeasureLine(fresh.lines[-1].time_s, after, 3, "ramp")]
        fresh = MeasureMap(lines, [Phrase(1, "intro"), Phrase(5)])
    accepted = replace_music(store, "new.ogg", fresh, by="mel")
    assert accepted.revision.number == 1
    music = read_patch(path).music
    assert (music.file, music.bpm, music.one_at_s) == ("new.ogg", None, None)
    if fresh is None:
        assert music.measures is None
    else:
        assert music.measures is not None
        assert music.measures.lines == tuple(
            MeasureLine(round(one.time_s, 6), one.measure, one.beats, one.tempo) for one in fresh.lines
        )
        assert music.measures.phrases == fresh.phrases
    assert path.read_text().startswith(HEAD)
    assert store.revisions[-1].text.startswith("music: set music.file new.ogg")
    store.undo("mel")
    assert path.read_text() == text
    store.undo("mel", redo=True)
    assert read_patch(path).music == music


def test_what_no_longer_fits_is_named_with_file_and_line(tmp_path: Path) -> None:
    path = show_of(tmp_path, 12)
    store = DocumentStore(path)
    assert replace_music(store, "new.ogg", steady_map(130.0, 1.0, 4, 12), by="mel").notes == ()
    notes = replace_music(store, "short.ogg", steady_map(130.0, 1.0, 4, 10), by="mel").notes
    lines = path.read_text().splitlines()
    assert [(note.field, note.measure) for note in notes] == [("section.2", 11), ("segment.1", 11)]
    for note in notes:
        assert note.file == str(path)
        assert note.line is not None
        assert lines[note.line - 1].startswith("[[section]]" if note.field == "section.2" else "[[segment]]")


def test_the_same_music_changes_nothing(tmp_path: Path) -> None:
    path = show_of(tmp_path, 0)
    store = DocumentStore(path)
    replace_music(store, "new.ogg", None, by="mel")
    with pytest.raises(EditRefused, match="the same music"):
        replace_music(store, "new.ogg", None, by="mel")


def test_others_edit_the_score_as_they_saw_it(tmp_path: Path) -> None:
    """Edits written before the music was replaced, and replaced back, mean the entries that their sender saw."""
    path = show_of(tmp_path, 12)
    store = DocumentStore(path)
    replace_music(store, "new.ogg", steady_map(130.0, 1.0, 4, 9), by="mel")
    store.edit(Edit("set", ("segment", 1, "formation"), "grid", by="ana", base=0))
    with pytest.raises(EditRefused, match="mel removed it meanwhile"):
        store.edit(Edit("set", ("music", "line", 12, "beats"), 3, by="ana", base=0))
    store.undo("mel")
    store.edit(Edit("set", ("music", "line", 12, "beats"), 3, by="ana"))
    store.undo("ana")
    replace_music(store, "third.ogg", None, by="mel")
    store.undo("mel")
    store.edit(Edit("set", ("music", "line", 12, "beats"), 3, by="ana", base=store.revision - 2))
    assert read_patch(path).music.line[11].beats == 3


def test_command_reads_lines_and_tells_notes(tmp_path: Path) -> None:
    path = show_of(tmp_path, 12)
    write_map(steady_map(130.0, 1.0, 4, 10), tmp_path / "lines.csv")
    (tmp_path / "new.wav").write_bytes(b"")
    told = run_live("document", "music", str(path), "none.wav")
    assert told.returncode == 2
    assert "no file 'none.wav'" in told.stderr
    told = run_live("document", "music", str(path), "new.wav", "--lines", "lines.csv")
    assert told.returncode == 2  # no sound
    assert "new.wav" in told.stderr


def test_an_undo_tells_which_entries_it_gives_back_and_changes(tmp_path: Path) -> None:
    store = DocumentStore(show_of(tmp_path, 3))
    edits = [
        Edit("set", ("segment", 1, "measure"), 2),
        Edit("insert", ("segment", 1), {"measure": 1, "formation": "line", "section": "verse"}),
        Edit("delete", ("section", 2)),
        Edit("set", ("segment", 2, "section"), "verse"),
        Edit("set", ("music", "file"), "new.ogg"),
    ]
    store.edit_together(lambda patch: edits, "keep", "ana")
    store.undo("ana")
    back = store.revisions[-1]
    assert back.shifts == ((("section",), -1, 1), (("segment",), 0, -1))
    assert {("segment", 0, "measure"), ("segment", 0, "section"), ("music", "file")} <= set(back.keys)
    assert all(key[:2] != ("segment", 1) for key in back.keys)
