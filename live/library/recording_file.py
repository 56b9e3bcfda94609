"""Reader for the TOML files of a step folder, which describe steps in recordings.

Errors name file, line, field, the expected and the actual value. Sketches are separated from recordings.
"""

import difflib
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from live.base.body.hand_shapes import AUTO, SHAPE_NAMES
from live.base.errors import PersonError
from live.base.motion_parameters import MOOD_NAMES
from live.base.toml import KeyPath, error_line, line_of, parse_toml, toml_line_numbers, toml_remedy
from live.library.disk_cache import read_regular_file
from live.library.motion_formats import is_readable_name
from live.motion.sketch.sketch_attributes import hand_shapes
from live.motion.sketch.sketch_notation import PAIRS, PARTS
from live.motion.step_clip import DIRECTIONS

SHOWN_PROBLEMS: Final = 8

Word = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[^\p{Cc}]*[^\p{Cc}\s][^\p{Cc}]*$")]
FileName = Annotated[str, Field(min_length=1, max_length=1000)]


class Recording(BaseModel):
    """One step in one recording; the TOML keys are the field names."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    file: FileName
    """The motion file, of any format with a reader, relative to the TOML file's folder."""
    name: Word
    """The step's name; steps of one name are variations of each other (T021)."""
    skeleton: FileName | None = None
    """The file with its skeleton, if its format needs one, relative to the same folder; found if it is clear which."""
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """Frame rate, if the one in the file header is wrong."""
    unit_m: Annotated[float, Field(gt=0, le=10)] | None = None
    """Metres per unit, for a check of the dancer's size."""
    up: Literal["Y", "Z"] | None = None
    """The axis that points up, if it is not detected."""
    drop_frames: Annotated[int, Field(ge=0, le=10_000_000)] = 0
    """Leading frames to remove; all times count from the first one kept."""
    repair: bool = False
    """Whether tracking faults are repaired where that is safe (T161)."""
    plant_feet: bool = True
    """Whether standing feet are kept in place, and swinging ones off the floor."""
    bpm: Annotated[float, Field(ge=20, le=400)]
    """Tempo of the recorded dance."""
    first_beat_s: Annotated[float, Field(ge=0, le=36_000)]
    """Time at which measure 1 begins [s]."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    start_measure: Annotated[int, Field(ge=1, le=100_000)] = 1
    """Measure in which the step begins, from 1."""
    measures: Annotated[int, Field(ge=1, le=10_000)] = 1
    """Length of the step in measures (T020)."""
    leading_foot: Literal["left", "right"] | None = None
    begin_pose: Word | None = None
    """Pose in which it begins; only steps that end in it may precede (T136)."""
    end_pose: Word | None = None
    weight_transfer: bool | None = None
    """Whether a repeat must be danced on the other side (T135)."""
    direction: str | None = None
    """One of the nine directions, as seen by the dancer; left out: measured (T131)."""
    distance_m: Annotated[float, Field(ge=0, le=100)] | None = None
    """Distance travelled; left out: measured."""
    author: Word | None = None
    style: Word | None = None
    """Stylistic variation in a word (T040)."""
    tags: Annotated[list[Word], Field(max_length=64)] = []
    mood: dict[Literal[MOOD_NAMES], Annotated[float, Field(ge=-1, le=1)]] = {}  # type: ignore[valid-type]
    """The mood in which it is danced: an example from which moods are learnt, never danced itself (T143)."""
    hand_shape: str | list[dict[str, Any]] = []
    """Shape of both hands, as in `"ballet"`, or changes on beats, from 1: `[{ beat = 1, left = "fist" }]`."""
    unstructured: bool = False
    """Whether it is a stream not cut into steps: each measure is a clip, joined by similarity alone (T037)."""
    mirror: bool = False
    """Whether the mirror image is added as a variation."""

    @field_validator("hand_shape")
    @classmethod
    def _shapes_are_known(cls, value: str | list[dict[str, Any]]) -> str | list[dict[str, Any]]:
        hand_shapes(value)
        return value


@dataclass(frozen=True, slots=True)
class Problem:
    """A problem: file, line, field, and a message with the actual and the expected value."""

    file: Path
    line: int | None
    field: str
    message: str

    @property
    def location(self) -> str:
        """File and line."""
        return str(self.file) if self.line is None else f"{self.file}, line {self.line}"

    def __str__(self) -> str:
        return f"{self.location}: {self.field}: {self.message}" if self.field else f"{self.location}: {self.message}"


class RecordingError(PersonError):
    """Recordings that cannot be used: for each problem file, line, field, the value and what is allowed."""

    def __init__(self, message: str, remedy: str | None = None, problems: tuple[Problem, ...] = ()) -> None:
        super().__init__(message, remedy)
        self.problems = problems


def combine_problems(problems: list[Problem]) -> RecordingError:
    """Return one error for all problems, with the first eight different ones in its message."""
    words = list(dict.fromkeys(map(str, problems)))
    more = len(words) - SHOWN_PROBLEMS
    told = "; ".join(words[:SHOWN_PROBLEMS]) + (f"; and {more} more" if more > 0 else "")
    return RecordingError(told, problems=tuple(problems))


@dataclass(frozen=True, slots=True, eq=False)
class RecordingEntry:
    """A recording with its place in the TOML file, for messages."""

    recording: Recording
    toml: Path
    lines: dict[KeyPath, int]
    table_path: KeyPath
    """Path of the table: () or ("step", index)."""

    @property
    def path(self) -> Path:
        """The motion file."""
        return self.toml.parent / self.recording.file

    @property
    def skeleton(self) -> Path | None:
        """The skeleton file, if one is named."""
        return None if self.recording.skeleton is None else self.toml.parent / self.recording.skeleton

    def problem(self, field: str, words: str) -> Problem:
        """Return a problem with one field."""
        return problem_at(self.toml, self.lines, self.table_path, (field,), words)

    def error(self, field: str, words: str) -> RecordingError:
        """Return the same as an error."""
        return combine_problems([self.problem(field, words)])


def problem_at(toml: Path, lines: dict[KeyPath, int], where: KeyPath, field: KeyPath, words: str) -> Problem:
    """Return a problem; `field` may be in the table `where` or, as a default for all steps, at the top of the file."""
    path = where + field if where + field[:1] in lines or field[:1] not in lines else field
    name = ".".join(str(part + 1) if isinstance(part, int) else part for part in path) or "the file"
    return Problem(toml, line_of(lines, path), name, words)


EXAMPLE: Final = 'file = "walk.bvh", name = "walk", bpm = 120, first_beat_s = 0.5, measures = 2 (a line each)'
_TYPE_HINTS: Final = get_type_hints(Recording, include_extras=True)


def problem_text(problem: Any) -> str:
    """Return the message for a problem that pydantic found in a Recording."""
    kind, read, field = problem["type"], problem["input"], str(problem["loc"][0]) if problem["loc"] else ""
    if kind == "extra_forbidden":
        keys = list(Recording.model_fields)
        near = difflib.get_close_matches(field, keys, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        return f"unknown key; {hint}allowed are {', '.join(keys)}"
    if kind == "missing":
        return f"missing; it must be given, as in {EXAMPLE}"
    if kind == "string_pattern_mismatch":
        return (
            "a text that is not blank, without line breaks and other control characters, expected, "
            f"found {value_text(read)}"
        )
    return f"{expected_text(field, inside=len(problem['loc']) > 1)} expected, found {value_text(read)}"


def value_text(value: object) -> str:
    """Return the value that was read, shortened for a message."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | int | float):
        return repr(value) if len(repr(value)) <= 60 else repr(value)[:57] + "..."
    return (
        "a list" if isinstance(value, list) else "a table" if isinstance(value, dict) else f"a {type(value).__name__}"
    )


def expected_text(field: str, *, inside: bool = False) -> str:
    """Return a description of the values allowed for a field; `inside`: for one element of its list."""
    if field == "hand_shape":
        return f'"ballet", or changes as [{{ beat = 1, left = "fist" }}], of {", ".join((AUTO, *SHAPE_NAMES))},'
    if field == "mood":
        return f"moods as in {{ energy = -1.0 }}, {', '.join(MOOD_NAMES)}, each from -1 to 1"
    return _type_text(_TYPE_HINTS.get(field), inside)


def _type_text(hint: Any, inside: bool) -> str:
    if get_origin(hint) in (Union, UnionType):
        return _type_text(next(one for one in get_args(hint) if one is not NoneType), inside)
    kind, low, high, above = hint, None, None, None
    if get_origin(hint) is Annotated:
        kind, *notes = get_args(hint)
        for note in notes:
            for rule in getattr(note, "metadata", []):
                low = getattr(rule, "ge", getattr(rule, "min_length", low))
                high = getattr(rule, "le", getattr(rule, "max_length", high))
                above = getattr(rule, "gt", above)
    if get_origin(kind) is list:
        if inside:
            return _type_text(get_args(kind)[0], False)
        return f'a list of at most {high} texts, like ["slow", "low"],'
    if get_origin(kind) is Literal:
        return " or ".join(f'"{value}"' for value in get_args(kind))
    if kind is bool:
        return "true or false"
    if kind is str:
        return "a text in quotes" if high is None else f"a text in quotes of {low} to {high} characters"
    number = "a whole number" if kind is int else "a number"
    return f"{number} above {above:g} and up to {high:g}" if above is not None else f"{number} from {low:,} to {high:,}"


MAX_BYTES: Final = 1_000_000
MAX_STEPS: Final = 10_000
_SKETCH_KEYS: Final = frozenset((*PARTS, *PAIRS, "beats", "travels", "alternate", "cyclic", "bounce", "swing"))
_RECORDING_KEYS: Final = frozenset(("file", "step", "pair", "first_beat_s", "start_measure", "measures"))


@dataclass(slots=True)
class StepFiles:
    """Contents of the TOML files of a folder, in the order of their names."""

    recordings: dict[Path, list[RecordingEntry]] = field(default_factory=dict)
    """Recordings by file."""
    texts: dict[Path, str] = field(default_factory=dict)
    """Texts of the same files."""
    sketches: dict[str, str] = field(default_factory=dict)
    """Texts of the files with sketches, by file name."""
    problems: list[Problem] = field(default_factory=list)


def no_steps_error(directory: Path) -> RecordingError:
    """Return the error for a folder without a TOML file that describes steps."""
    count = sum(map(is_readable_name, directory.iterdir()))
    return RecordingError(
        f"no TOML file in {directory} describes steps in its {count} recordings",
        f"live steps add FILE --library {directory}; or write one next to them, like steps.toml with {EXAMPLE}",
    )


def read_step_files(directory: Path) -> StepFiles:
    """Read all TOML files (*.toml) of a folder; RecordingError only if the folder cannot be read."""
    try:
        if not directory.is_dir():
            raise RecordingError(f"there is no folder {directory}", "give a folder with recordings and a TOML file")
        tomls = sorted(path for path in directory.iterdir() if path.suffix == ".toml")
    except OSError as error:
        raise RecordingError(f"cannot read the folder {directory}: {error.strerror}") from None
    files = StepFiles()
    for toml in tomls:
        text = _read_toml(toml, files.problems)
        if text is not None:
            parse_step_file(text, toml, files)
    return files


def _read_toml(toml: Path, problems: list[Problem]) -> str | None:
    try:
        data = read_regular_file(toml, MAX_BYTES) if toml.is_file() else None
        if data is None or len(data) > MAX_BYTES:  # the size is that of the data read, since the file may grow
            problems.append(Problem(toml, None, "", f"not a file of at most {MAX_BYTES} bytes"))
            return None
        return data.decode("utf-8")
    except OSError as error:
        problems.append(Problem(toml, None, "", f"cannot be read: {error.strerror}"))
    except UnicodeDecodeError as error:
        problems.append(Problem(toml, None, "", f"not a text in UTF-8 (byte {error.start})"))
    return None


def parse_step_file(text: str, toml: Path, files: StepFiles) -> None:
    """Parse the text of one file and add its contents to `files`."""
    try:
        data = parse_toml(text)
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
            files.recordings[toml] = _parse_entries(toml, data, toml_line_numbers(text), files.problems)


def _parse_entries(
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
                problems.append(problem_at(toml, lines, where, tuple(one["loc"]), problem_text(one)))
            continue
        entry = RecordingEntry(recording, toml, lines, where)
        if recording.direction is not None and recording.direction not in DIRECTIONS:
            allowed = ", ".join(map(repr, DIRECTIONS))
            problems.append(entry.problem("direction", f"{recording.direction[:60]!r}; allowed are {allowed}"))
        entries.append(entry)
    return entries
