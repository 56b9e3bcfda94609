"""Adding a step to a library: everything is checked and cut before anything is written; nothing is written over."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.library.asked import AskedEntry
from live.library.cut_step import cut_step
from live.library.recording import RecordingEntry
from live.library.recording_file import StepFiles, parse_step_file
from live.library.recording_reader import RecordingReader
from live.library.step_writer import with_step
from live.motion.step_clip import StepClip

MOST_NAMES: Final = 1000


@dataclass(frozen=True, slots=True, eq=False)
class Added:
    """What was added, and where."""

    step: StepClip
    entry: RecordingEntry
    toml: Path
    file: Path
    """The recording in the library."""
    copied: bool


def add_step(
    library: Path,
    entry: AskedEntry,
    *,
    comments: Mapping[str, str] | None = None,
    reader: RecordingReader | None = None,
) -> Added:
    """Cut the step, then bring its recording and its description into the folder `library`, which may be new.

    A recording that lies in the library already is named where it is; another is copied. The description joins the
    TOML file of the recording's name. `comments` stand behind the lines of their fields. Raises PersonError; then the
    library is as it was.
    """
    step = cut_step(entry, (reader or RecordingReader()).clip(entry))
    if not entry.path.resolve().is_relative_to(library.resolve()):
        _refuse_parts(entry)
    try:
        library.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PersonError(f"cannot make the library {library}: {error.strerror}", "--library DIR") from None
    made: list[Path] = []
    try:
        file = _brought_in(library, entry.path, made)
        fields = entry.recording.model_dump(exclude_unset=True, exclude_none=True)
        fields["file"] = file.relative_to(library.resolve()).as_posix()
        if entry.skeleton is not None:
            fields["skeleton"] = _brought_in(library, entry.skeleton, made).relative_to(library.resolve()).as_posix()
        toml = _described(library, Path(entry.path.name).stem, fields, comments, made)
    except OSError as error:
        _take_back(made)
        raise PersonError(f"cannot write into the library {library}: {error.strerror}", "--library DIR") from None
    except BaseException:
        _take_back(made)
        raise
    return Added(step, entry, toml, file, copied=file in made)


def _refuse_parts(entry: AskedEntry) -> None:
    """RecordingError for a .gltf file that keeps its motion in other files: they would be left behind."""
    if entry.path.suffix.lower() != ".gltf":
        return
    buffers = json.loads(entry.path.read_bytes()).get("buffers", [])  # it was read before: it is well formed
    others = [one["uri"] for one in buffers if not one.get("uri", "data:").startswith("data:")]
    if others:
        words = f"its motion lies in {others[0]}; export it as one file (.glb), or put both into the library first"
        raise entry.error("file", words)


def _take_back(made: list[Path]) -> None:
    for path in made:
        path.unlink(missing_ok=True)


def _names(folder: Path, stem: str, ending: str) -> Iterator[Path]:
    yield folder / f"{stem}{ending}"
    for number in range(2, MOST_NAMES):
        yield folder / f"{stem}-{number}{ending}"


def _brought_in(library: Path, source: Path, made: list[Path]) -> Path:
    """The file inside the library that is `source`: itself, one of the same contents, or a copy under a free name."""
    inside, whole = library.resolve(), source.resolve()
    if whole.is_relative_to(inside):
        return whole
    contents = whole.read_bytes()
    for path in _names(inside, source.stem, source.suffix):
        try:
            with path.open("xb") as file:
                made.append(path)
                file.write(contents)
            return path
        except FileExistsError:
            if path.is_file() and path.stat().st_size == len(contents) and path.read_bytes() == contents:
                return path
    raise PersonError(f"{library} holds {MOST_NAMES} recordings called {source.name}", "give the file another name")


def _described(
    library: Path, stem: str, fields: Mapping[str, Any], comments: Mapping[str, str] | None, made: list[Path]
) -> Path:
    """The TOML file that now holds the description: the first of the stem's names that can take it."""
    for path in _names(library, stem, ".toml"):
        before = path.read_bytes().decode("utf-8", errors="replace") if path.is_file() else ""
        if path.exists() and ("\ufffd" in before or not path.is_file()):
            continue
        text = with_step(before, fields, comments)
        if text is None or not _is_good(text, path):
            continue
        if path.exists():
            _replace(path.resolve(), text)
        else:
            with path.open("xb") as file:
                made.append(path)
                file.write(text.encode())
        return path
    raise PersonError(f"{library} holds {MOST_NAMES} files called {stem}.toml", "give the recording another name")


def _is_good(text: str, path: Path) -> bool:
    """Whether a file can be read with the step added; one that could not be read before is left alone."""
    files = StepFiles()
    parse_step_file(text, path, files)
    return not files.problems and bool(files.recordings.get(path))


def _replace(path: Path, text: str) -> None:
    """All of the new text or all of the old, whatever happens in between."""
    handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=".tmp", dir=path.parent)
    unfinished = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(text.encode())
            file.flush()
            os.fsync(file.fileno())
        shutil.copymode(path, unfinished)
        unfinished.replace(path)
    except BaseException:
        unfinished.unlink(missing_ok=True)
        raise
