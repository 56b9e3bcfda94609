"""Adding a step to a library, for `live steps add`.

Everything is checked and cut before anything is written, and no file is overwritten with other contents.
"""

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from live.base.errors import PersonError
from live.library.beat_alignment import GUESS_COMMENT, SyncRequest, SyncResult, find_sync, guessed_fields
from live.library.cut_step import cut_step
from live.library.motion_file import read_bytes
from live.library.motion_formats import format_by_suffix, format_of
from live.library.recording_file import (
    Problem,
    Recording,
    RecordingEntry,
    StepFiles,
    combine_problems,
    parse_step_file,
    problem_text,
    read_step_files,
)
from live.library.recordings import RecordingReader
from live.library.step_writer import append_step
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.motion_format import MotionFile
from live.motion.step_clip import DIRECTIONS, StepClip

OPTION_NAMES: Final = {
    "file": "FILE", "unit_m": "--unit", "first_beat_s": "--anchor", "start_measure": "--start",
    "distance_m": "--distance", "tags": "--tag",
}  # fmt: skip
"""Options of `live steps add` whose names differ from the field's."""
READING_FIELDS: Final = ("fps", "unit_m", "up")
MUSIC_FIELDS: Final = frozenset(("bpm", "first_beat_s"))
CUT_FIELDS: Final = (
    "name", *READING_FIELDS, "drop_frames", "bpm", "first_beat_s", "beats_per_measure", "start_measure", "measures",
)  # fmt: skip


class RequestedEntry(RecordingEntry):
    """A recording as requested on the command line; problems name the option."""

    @property
    def path(self) -> Path:
        """Present path of the motion file."""
        return Path(self.recording.file)

    @property
    def skeleton(self) -> Path | None:
        """Present path of its skeleton file."""
        return None if self.recording.skeleton is None else Path(self.recording.skeleton)

    def problem(self, field: str, words: str) -> Problem:
        """Return a problem with one option."""
        return option_problem(self.path, field, words)


def option_problem(path: Path, field: str, words: str) -> Problem:
    """Return a problem with an option for the file at `path`."""
    option = OPTION_NAMES.get(field, "--" + field.replace("_", "-"))
    if field == "file":
        return Problem(path, None, "", words.removeprefix(str(path)).lstrip(" ,:"))
    return Problem(path, None, option, words)


def request_entry(source: Path, fields: Mapping[str, Any]) -> RequestedEntry:
    """Return the requested recording; RecordingError names the options that are wrong or missing."""
    try:
        recording = Recording.model_validate({"file": str(source), **fields})
    except ValidationError as error:
        problems = []
        for one in error.errors(include_url=False):
            words = "must be given" if one["type"] == "missing" else problem_text(one)
            problems.append(option_problem(source, str(one["loc"][0]), words))
        raise combine_problems(problems) from None
    named = format_by_suffix(source)
    if recording.skeleton is None and named is not None and named.skeleton is not None and source.is_file():
        try:  # the skeleton is copied into the library, too
            recording = Recording.model_validate(
                {"file": str(source), **fields, "skeleton": str(named.skeleton(source))}
            )
        except MotionFileError as error:
            raise combine_problems([option_problem(source, "file", str(error))]) from None
    entry = RequestedEntry(recording, source, {}, ())
    if recording.direction is not None and recording.direction not in DIRECTIONS:
        allowed = ", ".join(map(repr, DIRECTIONS))
        raise entry.error("direction", f"{recording.direction[:60]!r}; allowed are {allowed}")
    return entry


def known_fields(library: Path, source: Path, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return what the library states about reading the recording `source` and about its music, for keys not in `given`.

    The second value holds the comments that mark tempo and first beat as guesses. Both are adopted together with
    `drop_frames`, because times count from the first frame kept.
    """
    try:
        files = read_step_files(library)
        entries = [entry for group in files.recordings.values() for entry in group]
        entry = next((entry for entry in entries if same_file(entry.path, source)), None)
    except (OSError, ValueError, PersonError):
        return {}, {}
    known = None if entry is None else entry.recording
    if (
        entry is None
        or known is None
        or any(given.get(k, getattr(known, k)) != getattr(known, k) for k in READING_FIELDS)
    ):
        return {}, {}
    keys = (
        READING_FIELDS
        if MUSIC_FIELDS & given.keys()
        else (*READING_FIELDS, *MUSIC_FIELDS, "drop_frames", "beats_per_measure")
    )
    told = {key: getattr(known, key) for key in keys if key in known.model_fields_set and key not in given}
    if told.keys() >= MUSIC_FIELDS and given.get("drop_frames", known.drop_frames) != known.drop_frames:
        return {key: value for key, value in told.items() if key not in MUSIC_FIELDS}, {}
    return told, {key: GUESS_COMMENT for key in guessed_fields(entry, files.texts[entry.toml]) if key in told}


def with_beats(
    file: Path,
    fields: Mapping[str, Any],
    *,
    click: float | None = None,
    count: int | None = None,
    song: Path | None = None,
) -> tuple[dict[str, Any], dict[str, str], SyncResult]:
    """Return the fields with tempo and first beat found, comments for the TOML file on how, and what was found.

    `click`, `count` and `song` as in SyncRequest. PersonError if nothing is found.
    """
    by_hand = {key for key in ("bpm", "first_beat_s") if key in fields}
    recording = request_entry(file, {"bpm": 120.0, "first_beat_s": 0.0, **fields}).recording
    # a given anchor counts from the file's first frame, unless the dropped frames are given too
    kept = recording.drop_frames if "drop_frames" in fields or "first_beat_s" in by_hand else None
    found = find_sync(
        SyncRequest(
            file=file,
            skeleton=None if recording.skeleton is None else Path(recording.skeleton),
            fps=recording.fps,
            up=recording.up,
            drop_frames=kept,
            click_bpm=click,
            count=count,
            song=song,
            anchor_s=recording.first_beat_s if "first_beat_s" in by_hand else None,
            bpm=recording.bpm if "bpm" in by_hand else None,
            beats_per_measure=recording.beats_per_measure,
        )
    )
    told, comments = dict(fields), {}
    for key, value in (
        ("bpm", round(found.reference.bpm, 3)),
        ("first_beat_s", round(found.reference.first_beat_s, 4)),
    ):
        if key not in by_hand:
            told[key], comments[key] = value, found.comment
    if kept is None and found.drop_frames:
        told["drop_frames"] = found.drop_frames
        comments["drop_frames"] = "found: a T-pose was put before the dance"
    return told, comments, found


def refuse_duplicate(library: Path, requested: RequestedEntry) -> None:
    """Raise PersonError if the library already has this cut of this recording under this name."""
    try:
        entries = [entry for group in read_step_files(library).recordings.values() for entry in group]
        same = [
            entry
            for entry in entries
            if all(_field_value(entry, key) == _field_value(requested, key) for key in CUT_FIELDS)
        ]
        there = next((entry for entry in same if same_file(entry.path, requested.path)), None)
    except (OSError, ValueError, PersonError):
        return
    if there is not None:
        raise PersonError(
            f"the step {requested.recording.name!r} is there already: {there.problem('name', '').location}",
            "change it there, or choose other measures or another name",
        )


def _field_value(entry: RecordingEntry, key: str) -> object:
    return getattr(entry.recording, key)


def same_file(path: Path, source: Path) -> bool:
    """Whether two files are one, or have the same contents."""
    if path.resolve() == source.resolve():
        return True
    return path.is_file() and path.stat().st_size == source.stat().st_size and path.read_bytes() == source.read_bytes()


MAX_NAMES: Final = 1000


@dataclass(frozen=True, slots=True, eq=False)
class AddedStep:
    """The step that was added, and its files."""

    step: StepClip
    entry: RecordingEntry
    toml: Path
    file: Path
    """The recording in the library."""
    copied: bool


def add_step(
    library: Path,
    entry: RequestedEntry,
    *,
    comments: Mapping[str, str] | None = None,
    reader: RecordingReader | None = None,
) -> AddedStep:
    """Cut the step, then add its recording and its description to the folder `library`, which may be new.

    A recording inside the library is used in place; any other is copied. The description goes to the TOML file with
    the recording's name. `comments` are written behind the lines of their fields. On a PersonError the library is
    unchanged.
    """
    step = cut_step(entry, (reader or RecordingReader()).clip(entry))
    if not entry.path.resolve().is_relative_to(library.resolve()):
        refuse_external_files(entry)
    try:
        library.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PersonError(f"cannot make the library {library}: {error.strerror}", "--library DIR") from None
    made: list[Path] = []
    try:
        file = import_file(library, entry.path, made)
        fields = entry.recording.model_dump(exclude_unset=True, exclude_none=True)
        fields["file"] = file.relative_to(library.resolve()).as_posix()
        if entry.skeleton is not None:
            fields["skeleton"] = import_file(library, entry.skeleton, made).relative_to(library.resolve()).as_posix()
        toml = _write_description(library, Path(entry.path.name).stem, fields, comments, made)
    except OSError as error:
        remove_files(made)
        raise PersonError(f"cannot write into the library {library}: {error.strerror}", "--library DIR") from None
    except BaseException:
        remove_files(made)
        raise
    return AddedStep(step, entry, toml, file, copied=file in made)


def refuse_external_files(entry: RequestedEntry) -> None:
    """Raise RecordingError for a file with its motion in other files, which would not be copied."""
    file = MotionFile(entry.path, read_bytes(entry.path), read_bytes)
    external = format_of(file.path, file.data).external
    others = () if external is None else external(file)
    if others:
        words = f"its motion lies in {others[0]}; export it as one file (.glb), or put both into the library first"
        raise entry.error("file", words)


def remove_files(made: list[Path]) -> None:
    for path in made:
        path.unlink(missing_ok=True)


def candidate_paths(folder: Path, stem: str, ending: str) -> Iterator[Path]:
    yield folder / f"{stem}{ending}"
    for number in range(2, MAX_NAMES):
        yield folder / f"{stem}-{number}{ending}"


def import_file(library: Path, source: Path, made: list[Path]) -> Path:
    """Return the file for `source` in the library: itself, one with the same contents, or a copy with a free name."""
    inside, whole = library.resolve(), source.resolve()
    if whole.is_relative_to(inside):
        return whole
    contents = whole.read_bytes()
    for path in candidate_paths(inside, source.stem, source.suffix):
        try:
            with path.open("xb") as file:
                made.append(path)
                file.write(contents)
            return path
        except FileExistsError:
            if path.is_file() and path.stat().st_size == len(contents) and path.read_bytes() == contents:
                return path
    raise PersonError(f"{library} holds {MAX_NAMES} recordings called {source.name}", "give the file another name")


def _write_description(
    library: Path, stem: str, fields: Mapping[str, Any], comments: Mapping[str, str] | None, made: list[Path]
) -> Path:
    """Write the description to the first of the stem's TOML files that can take it, and return that file."""
    for path in candidate_paths(library, stem, ".toml"):
        before = path.read_bytes().decode("utf-8", errors="replace") if path.is_file() else ""
        if path.exists() and ("\ufffd" in before or not path.is_file()):
            continue
        text = append_step(before, fields, comments)
        if text is None or not _is_valid(text, path):
            continue
        if path.exists():
            _replace_file(path.resolve(), text)
        else:
            with path.open("xb") as file:
                made.append(path)
                file.write(text.encode())
        return path
    raise PersonError(f"{library} holds {MAX_NAMES} files called {stem}.toml", "give the recording another name")


def _is_valid(text: str, path: Path) -> bool:
    """Whether the file is valid with the step added; a file that was invalid before is left alone."""
    files = StepFiles()
    parse_step_file(text, path, files)
    return not files.problems and bool(files.recordings.get(path))


def _replace_file(path: Path, text: str) -> None:
    """Replace the text atomically."""
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
