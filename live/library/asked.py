"""What is asked of `live steps add`: a recording as the options describe it, and what the library knows of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from live.base.errors import PersonError
from live.library.guesses import guessed_fields
from live.library.motion_file import skeleton_beside
from live.library.recording import Problem, Recording, RecordingEntry, error_of
from live.library.recording_file import read_step_files
from live.library.recording_words import problem_words
from live.library.sync import GUESS
from live.motion.formats.file_error import MotionFileError
from live.motion.step_clip import DIRECTIONS

OPTIONS: Final = {
    "file": "FILE", "unit_m": "--unit", "first_beat_s": "--anchor", "start_measure": "--start",
    "distance_m": "--distance", "tags": "--tag",
}  # fmt: skip
"""Options of `live steps add` that are not called like the field."""
READING: Final = ("fps", "unit_m", "up")
MUSIC: Final = frozenset(("bpm", "first_beat_s"))
CUT: Final = (
    "name", *READING, "drop_frames", "bpm", "first_beat_s", "beats_per_measure", "start_measure", "measures",
)  # fmt: skip


class AskedEntry(RecordingEntry):
    """A recording as it was asked for on the command line; problems name the option."""

    @property
    def path(self) -> Path:
        """The motion file, where it lies now."""
        return Path(self.recording.file)

    @property
    def skeleton(self) -> Path | None:
        """The file of its skeleton, where it lies now."""
        return None if self.recording.skeleton is None else Path(self.recording.skeleton)

    def problem(self, field: str, words: str) -> Problem:
        """A problem with one option."""
        return asked_problem(self.path, field, words)


def asked_problem(path: Path, field: str, words: str) -> Problem:
    """A problem with what was asked of the file at `path`, by the option's name."""
    option = OPTIONS.get(field, "--" + field.replace("_", "-"))
    if field == "file":
        return Problem(path, None, "", words.removeprefix(str(path)).lstrip(" ,:"))
    return Problem(path, None, option, words)


def asked_entry(source: Path, fields: Mapping[str, Any]) -> AskedEntry:
    """The recording that is asked for; RecordingError that names the options that are wrong or missing."""
    try:
        recording = Recording.model_validate({"file": str(source), **fields})
    except ValidationError as error:
        problems = []
        for one in error.errors(include_url=False):
            words = "must be given" if one["type"] == "missing" else problem_words(one)
            problems.append(asked_problem(source, str(one["loc"][0]), words))
        raise error_of(problems) from None
    if recording.skeleton is None and source.suffix.lower() == ".amc" and source.is_file():
        try:  # it must come into the library, too
            recording = Recording.model_validate(
                {"file": str(source), **fields, "skeleton": str(skeleton_beside(source))}
            )
        except MotionFileError as error:
            raise error_of([asked_problem(source, "file", str(error))]) from None
    entry = AskedEntry(recording, source, {}, ())
    if recording.direction is not None and recording.direction not in DIRECTIONS:
        allowed = ", ".join(map(repr, DIRECTIONS))
        raise entry.error("direction", f"{recording.direction[:60]!r}; allowed are {allowed}")
    return entry


def known_of(library: Path, source: Path, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """What the library says already of reading the recording `source` and of its music, where `given` is silent.

    With it the comments behind tempo and first beat that say that they are guesses: they are, as long as nobody has
    taken the comments away. Both are taken over together with the frames left out, for times count from the first one
    kept.
    """
    try:
        files = read_step_files(library)
        entries = [entry for group in files.recordings.values() for entry in group]
        entry = next((entry for entry in entries if _is_same(entry.path, source)), None)
    except (OSError, ValueError, PersonError):
        return {}, {}
    known = None if entry is None else entry.recording
    if entry is None or known is None or any(given.get(k, getattr(known, k)) != getattr(known, k) for k in READING):
        return {}, {}
    keys = READING if MUSIC & given.keys() else (*READING, *MUSIC, "drop_frames", "beats_per_measure")
    told = {key: getattr(known, key) for key in keys if key in known.model_fields_set and key not in given}
    if told.keys() >= MUSIC and given.get("drop_frames", known.drop_frames) != known.drop_frames:
        return {key: value for key, value in told.items() if key not in MUSIC}, {}
    return told, {key: GUESS for key in guessed_fields(entry, files.texts[entry.toml]) if key in told}


def refuse_again(library: Path, asked: AskedEntry) -> None:
    """PersonError if the library has this cut of this recording under this name already."""
    try:
        entries = [entry for group in read_step_files(library).recordings.values() for entry in group]
        same = [entry for entry in entries if all(_said(entry, key) == _said(asked, key) for key in CUT)]
        there = next((entry for entry in same if _is_same(entry.path, asked.path)), None)
    except (OSError, ValueError, PersonError):
        return
    if there is not None:
        raise PersonError(
            f"the step {asked.recording.name!r} is there already: {there.problem('name', '').place}",
            "change it there, or choose other measures or another name",
        )


def _said(entry: RecordingEntry, key: str) -> object:
    return getattr(entry.recording, key)


def _is_same(path: Path, source: Path) -> bool:
    if path.resolve() == source.resolve():
        return True
    return path.is_file() and path.stat().st_size == source.stat().st_size and path.read_bytes() == source.read_bytes()
