"""Files of sheets: the same bytes each time, fonts embedded, nothing of others replaced; marks for the musician."""

import io
import re
import zlib
from pathlib import Path

import mido
import pytest
from PIL import Image

from live.base.errors import PersonError
from live.clock.measure_map import MeasureMap
from live.document.sheets.drawn_pages import DPI
from live.document.sheets.score_markers import labels_of, midi_of, piece_map, score_marks
from live.document.sheets.sheet_book import SheetBook
from live.document.sheets.sheet_files import LIST, SheetFolder, SheetsWritten, dancer_stem, sheet_names, write_sheets
from live.library.music_map_file import read_map
from live.show.loader import LoadedShow
from live.show.patch.section_music import MusicLine

pytestmark = pytest.mark.xdist_group("sheets")


def write(to: Path, loaded: LoadedShow, book: SheetBook, *, pictures: bool = False) -> SheetsWritten:
    return write_sheets(SheetFolder(to), loaded.patch, book, "a4", pictures=pictures)


def bytes_in(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.long
def test_files_are_the_same_each_time(tmp_path: Path, loaded: LoadedShow, book: SheetBook) -> None:
    done = write(tmp_path / "one", loaded, book, pictures=True)
    write(tmp_path / "two" / "deeper", loaded, book, pictures=True)
    first = bytes_in(tmp_path / "one")
    assert first == bytes_in(tmp_path / "two" / "deeper")
    assert set(sheet_names(loaded.patch)) <= set(first)
    assert done.pdfs == 1 + len(book.dancers)
    assert done.pages == done.pictures
    assert "dancer-6-ember.pdf" in first  # who has come in from the wings has a sheet, too
    with Image.open(io.BytesIO(first["pictures/storyboard-1.png"])) as picture:
        assert picture.size == (round(210 / 25.4 * DPI), round(297 / 25.4 * DPI))
        assert picture.convert("L").getextrema() == (0, 255)
    write(tmp_path / "one", loaded, book)  # what it wrote itself is replaced


def test_fonts_are_embedded_and_nothing_else_is_used(tmp_path: Path, loaded: LoadedShow, book: SheetBook) -> None:
    write(tmp_path, loaded, book)
    for path in tmp_path.glob("*.pdf"):
        data = path.read_bytes()
        used = set(re.findall(rb"/BaseFont /([A-Za-z+-]+)", data))
        assert used <= {b"AAAAAA+BitstreamVeraSans-Roman", b"AAAAAA+BitstreamVeraSans-Bold"}, used
        assert data.count(b"/FontFile2") == len(used) == 2
        assert b"/CreationDate (D:20000101" in data  # not that of today
        assert len(data) < 200_000


def test_nothing_of_others_is_replaced_or_deleted(tmp_path: Path, loaded: LoadedShow, book: SheetBook) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "dancer-1-ember.pdf").write_text("mine")
    before = bytes_in(tmp_path)
    folder = SheetFolder(tmp_path)
    with pytest.raises(PersonError, match=r"dancer-1-ember\.pdf is there already"):
        folder.check(sheet_names(loaded.patch))
    with pytest.raises(PersonError, match="there already"):
        write(tmp_path, loaded, book)
    assert {name: data for name, data in bytes_in(tmp_path).items() if name in before} == before
    (tmp_path / "dancer-1-ember.pdf").unlink()
    write(tmp_path, loaded, book)
    with (tmp_path / "storyboard.pdf").open("ab") as written:
        written.write(b"% a note in it")
    with pytest.raises(PersonError, match="no longer"):
        SheetFolder(tmp_path).check(sheet_names(loaded.patch))
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.long
def test_files_of_an_earlier_run_are_told_not_deleted(tmp_path: Path, loaded: LoadedShow, book: SheetBook) -> None:
    write(tmp_path, loaded, book, pictures=True)
    left = write(tmp_path, loaded, book).left
    assert "pictures/storyboard-1.png" in left
    assert (tmp_path / left[0]).is_file()


def test_wrong_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(PersonError, match="that is a file"):
        SheetFolder(tmp_path / "file")
    with pytest.raises(PersonError, match="cannot be made"):
        SheetFolder(tmp_path / "file" / "below")
    for text in ("", "[]", '{"files": {}}', '{"made_by": "live sheets", "files": {"a": 1}}'):
        (tmp_path / LIST).write_text(text)
        with pytest.raises(PersonError, match="no list of live sheets"):
            SheetFolder(tmp_path)


def test_names_of_groups_are_safe_as_files() -> None:
    assert dancer_stem(6, "../Sün & Moon", 24) == "dancer-07-s-n-moon"
    assert dancer_stem(0, "舞", 200) == "dancer-001"


def test_markers_stand_where_the_score_says(tmp_path: Path, loaded: LoadedShow, book: SheetBook) -> None:
    marks = score_marks(book.record, book.scenes)
    measures = piece_map(loaded.patch, book.record)
    path = tmp_path / "markers.mid"
    path.write_bytes(midi_of("x", measures, book.record, marks))
    again = read_map(path)  # other programs' maps are read so, too
    assert [line.time_s for line in again.lines] == pytest.approx([2.0 * k for k in range(8)], abs=1e-4)
    time, found = 0.0, {}
    for message in mido.MidiFile(path):
        time += message.time
        if message.type == "marker":
            found[message.text] = time
    assert found["wait waits for GO: counts start again"] == pytest.approx(12.0, abs=1e-3)
    assert found["to there (ember), there at 4:1"] == 0.0
    assert found["enter 1"] == pytest.approx(0.5, abs=1e-3)
    labels = labels_of(measures, book.record, marks).decode().splitlines()
    assert "0.000000\t6.000000\tto back (tide), there at 4:1" in labels
    assert "8.000000\t8.000000\t1" in labels  # counts start again in each section
    assert labels == sorted(labels, key=lambda line: float(line.split("\t")[0]))


def test_markers_follow_the_lines_of_the_piece(loaded: LoadedShow, book: SheetBook) -> None:
    lines = tuple(MusicLine(time_s=time, measure=k + 5, beats=4) for k, time in enumerate((1.5, 3.5, 6.0)))
    patch = loaded.patch.model_copy(update={"music": loaded.patch.music.model_copy(update={"line": lines})})
    measures = piece_map(patch, book.record)
    assert isinstance(measures, MeasureMap)
    assert [line.time_s for line in measures.lines][:5] == [1.5, 3.5, 6.0, 8.5, 11.0]
    labels = labels_of(measures, book.record, score_marks(book.record, book.scenes)).decode()
    assert "1.500000\t8.500000\tto there (ember)" in labels
    data = midi_of("x", measures, book.record, [])
    starts = [time for time, text in _markers(data) if text.startswith("measure")]
    assert starts[:3] == pytest.approx([1.5, 3.5, 6.0], abs=1e-3)


def _markers(data: bytes) -> list[tuple[float, str]]:
    time, found = 0.0, []
    for message in mido.MidiFile(file=io.BytesIO(data)):
        time += message.time
        if message.type == "marker":
            found.append((time, message.text))
    return found


def test_pdf_has_the_words_of_its_page(tmp_path: Path, loaded: LoadedShow, book: SheetBook) -> None:
    """Both drawings show one page model: there are as many words in the PDF as on the page."""
    from base64 import a85decode

    from live.document.sheets.drawn_pages import pdf_of
    from live.document.sheets.page import Words
    from live.document.sheets.storyboard_pages import storyboard_pages

    page = storyboard_pages(book, "a4")[0]
    data = pdf_of([page], "x")
    streams = re.findall(rb"/Filter \[ /ASCII85Decode /FlateDecode \].*?stream\r?\n(.*?)endstream", data, re.S)
    content = zlib.decompress(a85decode(b"<~" + streams[-1].strip(), adobe=True))
    drawn = content.count(b" Tj")
    assert drawn >= sum(isinstance(item, Words) for item in page.items)
