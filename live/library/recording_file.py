"""Reading the TOML files of a step folder: which part of which recording is which step; sketches are told apart."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from live.base.toml_lines import KeyPath, error_line, toml_lines
from live.base.toml_remedy import toml_remedy
from live.base.toml_text import toml_values
from live.library.motion_file import MOTION_ENDINGS
from live.library.plain_file import read_plain
from live.library.recording import Problem, Recording, RecordingEntry, RecordingError, error_of, problem_at
from live.library.recording_words import EXAMPLE, problem_words
from live.motion.sketch.sketch_notation import PAIRS, PARTS
from live.motion.step_clip import DIRECTIONS

MAX_BYTES: Final = 1_000_000
MAX_STEPS: Final = 10_000
_SKETCH_KEYS: Final = frozenset((*PARTS, *PAIRS, "beats", "travels", "alternate", "cyclic", "bounce", "swing"))
_RECORDING_KEYS: Final = frozenset(("file", "step", "pair", "first_beat_s", "start_measure", "measures"))


@dataclass(slots=True)
class StepFiles:
    """What the TOML files of a folder hold, in the order of their names."""

    recordings: dict[Path, list[RecordingEntry]] = field(default_factory=dict)
    """The recordings of each file that describes some."""
    texts: dict[Path, str] = field(default_factory=dict)
    """The text of each of these."""
    sketches: dict[str, str] = field(default_factory=dict)
    """The text of each file that holds a sketch."""
    problems: list[Problem] = field(default_factory=list)


def read_recordings(directory: Path) -> list[RecordingEntry]:
    """The recordings that the TOML files of a folder describe; RecordingError with all problems, or if there is none.

    A file holds one recording at its top level, or an array `[[step]]`, for which keys at the top level are defaults.
    Files that list pairs (`[[pair]]`) are for partner dance and passed over, and so are sketches.
    """
    files = read_step_files(directory)
    if files.problems:
        raise error_of(files.problems)
    if not files.recordings:
        raise nothing_in(directory)
    return [entry for entries in files.recordings.values() for entry in entries]


def nothing_in(directory: Path) -> RecordingError:
    """The error for a folder in which no TOML file speaks of steps."""
    count = sum(1 for path in directory.iterdir() if path.suffix.lower() in MOTION_ENDINGS)
    return RecordingError(
        f"no TOML file in {directory} says which step is where in its {count} recordings",
        f"live steps add FILE --library {directory}; or write one beside them, like steps.toml with {EXAMPLE}",
    )


def read_step_files(directory: Path) -> StepFiles:
    """All TOML files (*.toml) of a folder; RecordingError only if the folder cannot be read."""
    try:
        if not directory.is_dir():
            raise RecordingError(f"there is no folder {directory}", "give a folder with recordings and a TOML file")
        tomls = sorted(path for path in directory.iterdir() if path.suffix == ".toml")
    except OSError as error:
        raise RecordingError(f"cannot read the folder {directory}: {error.strerror}") from None
    files = StepFiles()
    for toml in tomls:
        text = _text_of(toml, files.problems)
        if text is not None:
            parse_step_file(text, toml, files)
    return files


def _text_of(toml: Path, problems: list[Problem]) -> str | None:
    try:
        data = read_plain(toml, MAX_BYTES) if toml.is_file() else None
        if data is None or len(data) > MAX_BYTES:  # it may have grown since anybody looked
            problems.append(Problem(toml, None, "", f"not a file of at most {MAX_BYTES} bytes"))
            return None
        return data.decode("utf-8")
    except OSError as error:
        problems.append(Problem(toml, None, "", f"cannot be read: {error.strerror}"))
    except UnicodeDecodeError as error:
        problems.append(Problem(toml, None, "", f"not a text in UTF-8 (byte {error.start})"))
    return None


def parse_step_file(text: str, toml: Path, files: StepFiles) -> None:
    """Add what the text of one file holds to `files`."""
    try:
        data = toml_values(text)
    except tomllib.TOMLDecodeError as error:
        line = error_line(str(error), text)
        words = f"not valid TOML: {str(error).split(' (at ')[0]}: {toml_remedy(str(error), text, line)}"
        files.problems.append(Problem(toml, line, "", words))
    except RecursionError:
        files.problems.append(Problem(toml, None, "", "brackets in brackets too deep"))
    else:
        if not _RECORDING_KEYS & data.keys() and _SKETCH_KEYS & data.keys():
            files.sketches[str(toml)] = text
        elif "pair" not in data or "step" in data or "file" in data:
            files.texts[toml] = text
            files.recordings[toml] = _entries(toml, data, toml_lines(text), files.problems)


def _entries(
    toml: Path, data: dict[str, Any], lines: dict[KeyPath, int], problems: list[Problem]
) -> list[RecordingEntry]:
    tables: list[tuple[KeyPath, Any]] = [((), data)]
    if "step" in data:
        defaults = {key: value for key, value in data.items() if key != "step"}
        steps = data["step"]
        if not isinstance(steps, list) or not all(isinstance(step, dict) for step in steps):
            problems.append(problem_at(toml, lines, (), ("step",), "a list of tables expected, each begun by [[step]]"))
            return []
        if len(steps) > MAX_STEPS:
            problems.append(problem_at(toml, lines, (), ("step",), f"{len(steps)} steps; at most {MAX_STEPS}"))
            return []
        tables = [(("step", index), defaults | step) for index, step in enumerate(steps)]
    entries = []
    for where, table in tables:
        try:
            recording = Recording.model_validate(table)
        except ValidationError as error:
            for one in error.errors(include_url=False):
                problems.append(problem_at(toml, lines, where, tuple(one["loc"]), problem_words(one)))
            continue
        entry = RecordingEntry(recording, toml, lines, where)
        if recording.direction is not None and recording.direction not in DIRECTIONS:
            allowed = ", ".join(map(repr, DIRECTIONS))
            problems.append(entry.problem("direction", f"{recording.direction[:60]!r}; allowed are {allowed}"))
        entries.append(entry)
    return entries
