"""The small TOML files beside recordings: which part of which file is which step (the vocabulary of motion files)."""

import difflib
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.errors import PersonError
from live.base.toml_lines import KeyPath, error_line, line_of, toml_lines
from live.motion.step_clip import DIRECTIONS

MAX_BYTES: Final = 1_000_000
MAX_STEPS: Final = 10_000
SHOWN_PROBLEMS: Final = 8
EXAMPLE: Final = 'file = "walk.bvh", name = "walk", bpm = 120, first_beat_s = 0.5, measures = 2 (a line each)'

Word = Annotated[str, Field(min_length=1, max_length=64)]


class RecordingError(PersonError):
    """Recordings that cannot be used: for each problem file, line, field, what was read and what is allowed."""


class Recording(BaseModel):
    """One step in one recording; the TOML keys are the field names."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    file: Annotated[str, Field(min_length=1, max_length=1000)]
    """The BVH file, relative to the TOML file's folder."""
    name: Word
    """The step's name; steps of one name are variations of each other."""
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """True frame rate where the file's header lies."""
    drop_frames: Annotated[int, Field(ge=0, le=10_000_000)] = 0
    """Leading frames that are left out; all times count from the first one kept."""
    bpm: Annotated[float, Field(ge=20, le=400)]
    """Tempo of the recorded dance."""
    first_beat_s: Annotated[float, Field(ge=0, le=36_000)]
    """When measure 1 begins [s]."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    start_measure: Annotated[int, Field(ge=1, le=100_000)] = 1
    """Measure in which the step begins, from 1."""
    measures: Annotated[int, Field(ge=1, le=10_000)] = 1
    """Length of the step."""
    leading_foot: Literal["left", "right"] | None = None
    begin_pose: Word | None = None
    end_pose: Word | None = None
    weight_transfer: bool | None = None
    direction: str | None = None
    """One of the nine directions, as the dancer sees them."""
    distance_m: Annotated[float, Field(ge=0, le=100)] | None = None
    tags: list[Word] = []
    unit_m: Annotated[float, Field(gt=0, le=10)] | None = None
    """Metres per unit, to have the dancer's size checked."""
    up: Literal["Y", "Z"] | None = None
    """The axis that points up, if it is not found."""
    mirror: bool = False
    """Whether the mirror image is a variation, too."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordingEntry:
    """A recording with the place in its TOML file, for messages."""

    recording: Recording
    toml: Path
    lines: dict[KeyPath, int]
    where: KeyPath
    """Path of the table: () or ("step", index)."""

    def problem(self, field: str, words: str) -> str:
        """One problem in the form of all messages: file, line, field, words."""
        return _problem(self.toml, self.lines, self.where, (field,), words)


def _problem(toml: Path, lines: dict[KeyPath, int], where: KeyPath, field: KeyPath, words: str) -> str:
    """`field` may stand in the table `where` or, as a default for all steps, at the top of the file."""
    path = where + field if where + field[:1] in lines or field[:1] not in lines else field
    name = ".".join(str(part + 1) if isinstance(part, int) else part for part in path) or "the file"
    return f"{toml}, line {line_of(lines, path)}: {name}: {words}"


def error_of(problems: list[str]) -> RecordingError:
    """All problems as one error, the first eight in words."""
    more = len(problems) - SHOWN_PROBLEMS
    return RecordingError("; ".join(problems[:SHOWN_PROBLEMS]) + (f"; and {more} more" if more > 0 else ""))


def read_recordings(directory: Path) -> list[RecordingEntry]:
    """What the TOML files (*.toml) of a folder say, in the order of file names; RecordingError with all problems.

    A file holds one recording at its top level, or an array `[[step]]`, for which keys at the top level are defaults.
    Files that list pairs (`[[pair]]`) are for partner dance and passed over.
    """
    if not directory.is_dir():
        raise RecordingError(f"there is no folder {directory}", "give a folder with BVH files and a TOML file")
    entries: list[RecordingEntry] = []
    problems: list[str] = []
    for toml in sorted(directory.glob("*.toml")):
        _read_file(toml, entries, problems)
    if problems:
        raise error_of(problems)
    if not entries:
        found = sum(1 for _ in directory.glob("*.bvh"))
        raise RecordingError(
            f"no TOML file in {directory} says which step is where in its {found} BVH files",
            f"write one beside them, like steps.toml with {EXAMPLE}",
        )
    return entries


def _read_file(toml: Path, entries: list[RecordingEntry], problems: list[str]) -> None:
    try:
        if not toml.is_file() or toml.stat().st_size > MAX_BYTES:
            problems.append(f"{toml}: not a file of at most {MAX_BYTES} bytes")
            return
        text = toml.read_bytes().decode("utf-8")
        data = tomllib.loads(text)
    except OSError as error:
        problems.append(f"cannot read {toml}: {error.strerror}")
    except UnicodeDecodeError as error:
        problems.append(f"{toml}: not a text in UTF-8 (byte {error.start})")
    except tomllib.TOMLDecodeError as error:
        problems.append(f"{toml}, line {error_line(str(error), text)}: not valid TOML: {error}")
    except RecursionError:
        problems.append(f"{toml}: brackets in brackets too deep")
    else:
        _read_tables(toml, data, toml_lines(text), entries, problems)


def _read_tables(
    toml: Path, data: dict[str, Any], lines: dict[KeyPath, int], entries: list[RecordingEntry], problems: list[str]
) -> None:
    if "pair" in data and "step" not in data and "file" not in data:
        return
    tables: list[tuple[KeyPath, Any]] = [((), data)]
    if "step" in data:
        defaults = {key: value for key, value in data.items() if key != "step"}
        steps = data["step"]
        if not isinstance(steps, list) or not all(isinstance(step, dict) for step in steps):
            problems.append(_problem(toml, lines, (), ("step",), "a list of tables expected, each begun by [[step]]"))
            return
        if len(steps) > MAX_STEPS:
            problems.append(_problem(toml, lines, (), ("step",), f"{len(steps)} steps; at most {MAX_STEPS}"))
            return
        tables = [(("step", index), defaults | step) for index, step in enumerate(steps)]
    for where, table in tables:
        try:
            recording = Recording.model_validate(table)
        except ValidationError as error:
            for one in error.errors(include_url=False):
                problems.append(_problem(toml, lines, where, tuple(one["loc"]), _words(one)))
            continue
        entry = RecordingEntry(recording, toml, lines, where)
        if recording.direction is not None and recording.direction not in DIRECTIONS:
            allowed = ", ".join(map(repr, DIRECTIONS))
            problems.append(entry.problem("direction", f"{recording.direction[:60]!r}; allowed are {allowed}"))
        entries.append(entry)


def _words(problem: Any) -> str:
    """One problem in words: what was read, what is allowed."""
    kind, message, read = problem["type"], problem["msg"], problem["input"]
    if kind == "extra_forbidden":
        keys = list(Recording.model_fields)
        near = difflib.get_close_matches(str(problem["loc"][-1]), keys, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        return f"unknown key; {hint}allowed are {', '.join(keys)}"
    if kind == "missing":
        return f"missing; it must be given, as in {EXAMPLE}"
    shown = repr(read) if isinstance(read, str | int | float | bool) else f"a {type(read).__name__}"
    return f"{message[0].lower() + message[1:]}, found {shown[:60]}"
