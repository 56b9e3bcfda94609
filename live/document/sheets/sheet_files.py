"""The files of sheets in a folder: storyboard, a file for each dancer, pictures, marks for the musician.

`sheets.json` lists what was written, with checksums: only files that are as they were written are replaced, so neither
files of others nor notes in a sheet are lost. Nothing is ever deleted.
"""

import hashlib
import json
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.document.sheets.dancer_pages import dancer_pages
from live.document.sheets.drawn_pages import pdf_of, picture_of
from live.document.sheets.page import Page
from live.document.sheets.score_markers import labels_of, midi_of, piece_map, score_marks
from live.document.sheets.sheet_book import SheetBook
from live.document.sheets.storyboard_pages import storyboard_pages
from live.library.whole_file import write_atomically
from live.show.patch.patch import Patch

LIST: Final = "sheets.json"
MADE_BY: Final = "live sheets"
PICTURES: Final = "pictures"
MAX_LIST_BYTES: Final = 4_000_000


@dataclass(frozen=True, slots=True)
class SheetsWritten:
    """What was written."""

    pages: int
    pdfs: int
    pictures: int
    left: tuple[str, ...]
    """Files of an earlier run that do not belong to this show any more."""


class SheetFolder:
    """A folder of sheets. Check it before long work; errors name what to do."""

    def __init__(self, folder: Path) -> None:
        """PersonError if the folder can be neither made nor written, or its list cannot be read."""
        self._folder = folder
        if folder.exists() and not folder.is_dir():
            raise PersonError(f"--out {folder}: that is a file; give a folder")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PersonError(f"--out {folder}: cannot be made: {error.strerror}", "choose another folder") from None
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PersonError(f"--out {folder}: no permission to write there", "choose another folder")
        self._known = _read_list(folder / LIST)

    def check(self, names: list[str]) -> None:
        """Raise PersonError if a file of these names is there and is not as an earlier run wrote it."""
        foreign = [name for name in names if not self._may_replace(name)]
        if foreign:
            more = f" and {len(foreign) - 1} more" if len(foreign) > 1 else ""
            raise PersonError(
                f"--out {self._folder}: {foreign[0]}{more} is there already and is not, or is no longer, what "
                "live sheets wrote",
                "choose another folder, or move what you want to keep",
            )

    def _may_replace(self, name: str) -> bool:
        path = self._folder / name
        if not path.exists():
            return True
        if not path.is_file() or name not in self._known:
            return False
        try:
            return hashlib.sha256(path.read_bytes()).hexdigest() == self._known[name]
        except OSError:
            return False

    def write(self, files: Iterator[tuple[str, bytes]]) -> tuple[str, ...]:
        """Write files by name, and their list; return the names of an earlier run's other files. PersonError for one
        that is not ours."""
        known = dict(self._known)
        written: dict[str, str] = {}
        try:
            for name, data in files:
                self.check([name])
                path = self._folder / name
                path.parent.mkdir(exist_ok=True)
                write_atomically(data, path, "--out")
                written[name] = hashlib.sha256(data).hexdigest()
        except OSError as error:
            raise PersonError(f"--out {self._folder}: cannot be written: {error.strerror}") from None
        finally:
            listed = {"made_by": MADE_BY, "files": dict(sorted({**known, **written}.items()))}
            write_atomically((json.dumps(listed, indent=1) + "\n").encode(), self._folder / LIST, "--out")
        return tuple(sorted(name for name in known if name not in written and (self._folder / name).exists()))


def _read_list(path: Path) -> dict[str, str]:
    """Return the checksums of files of an earlier run; PersonError for a list of somebody else."""
    if not path.exists():
        return {}
    try:
        if path.stat().st_size > MAX_LIST_BYTES:
            raise ValueError
        found = json.loads(path.read_bytes())
        files = found["files"]
        if found["made_by"] != MADE_BY or not all(isinstance(one, str) for pair in files.items() for one in pair):
            raise ValueError
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise PersonError(f"{path}: this is no list of live sheets", "choose another folder") from None
    return dict(files)


def sheet_names(patch: Patch) -> list[str]:
    """Return the names of the files that are written for the dancers of a patch, without pictures."""
    names = ["storyboard.pdf", "markers.mid", "markers.txt"]
    dancer = 0
    for group in patch.group:
        for _ in range(group.dancers):
            names.append(dancer_stem(dancer, group.name, patch.dancer_count) + ".pdf")
            dancer += 1
    return names


def dancer_stem(dancer: int, group: str, count: int) -> str:
    """Return a dancer's file name without ending, as `dancer-07-sun`."""
    word = re.sub(r"[^a-z0-9]+", "-", group.casefold()).strip("-")[:40]
    return f"dancer-{dancer + 1:0{len(str(count))}}" + (f"-{word}" if word else "")


def write_sheets(
    folder: SheetFolder, patch: Patch, book: SheetBook, paper: str, *, pictures: bool,
    progress: Callable[[str], None] = lambda name: None,
) -> SheetsWritten:  # fmt: skip
    """Write all sheets of a book. `progress` is told the name of each file."""
    pages = pdfs = drawn = 0

    def files() -> Iterator[tuple[str, bytes]]:
        nonlocal pages, pdfs, drawn
        marks = score_marks(book.record, book.scenes)
        measures = piece_map(patch, book.record)
        yield "markers.mid", midi_of(book.title, measures, book.record, marks)
        yield "markers.txt", labels_of(measures, book.record, marks)
        for stem, title, made in _documents(patch, book, paper):
            progress(stem)
            yield f"{stem}.pdf", pdf_of(made, f"{book.title} · {title}")
            pages, pdfs = pages + len(made), pdfs + 1
            for number, page in enumerate(made if pictures else [], 1):
                yield f"{PICTURES}/{stem}-{number}.png", picture_of(page)
                drawn += 1

    left = folder.write(files())
    return SheetsWritten(pages, pdfs, drawn, left)


def _documents(patch: Patch, book: SheetBook, paper: str) -> Iterator[tuple[str, str, list[Page]]]:
    """Yield file name, title and pages of each document."""
    yield "storyboard", "storyboard", storyboard_pages(book, paper)
    for dancer in book.dancers.tolist():
        stem = dancer_stem(dancer, book.groups[int(book.record.group[0, dancer])], patch.dancer_count)
        yield stem, f"dancer {dancer + 1}", dancer_pages(book, dancer, paper)
