"""Recording: what a TOML file says about one step in one motion file (the vocabulary of motion files)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from live.base.errors import PersonError
from live.base.toml_lines import KeyPath, line_of

SHOWN_PROBLEMS: Final = 8

Word = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[^\p{Cc}]*[^\p{Cc}\s][^\p{Cc}]*$")]
FileName = Annotated[str, Field(min_length=1, max_length=1000)]


class Recording(BaseModel):
    """One step in one recording; the TOML keys are the field names."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    file: FileName
    """The motion file (BVH, AMC, glTF, GLB, VRM, AMASS npz), relative to the TOML file's folder."""
    name: Word
    """The step's name; steps of one name are variations of each other (T021)."""
    skeleton: FileName | None = None
    """The ASF file of an AMC file, relative to the same folder; found if it is the only one beside it."""
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """True frame rate where the file's header lies."""
    unit_m: Annotated[float, Field(gt=0, le=10)] | None = None
    """Metres per unit, to have the dancer's size checked."""
    up: Literal["Y", "Z"] | None = None
    """The axis that points up, if it is not found."""
    drop_frames: Annotated[int, Field(ge=0, le=10_000_000)] = 0
    """Leading frames that are left out; all times count from the first one kept."""
    repair: bool = False
    """Whether tracking faults are mended where that is safe (T161)."""
    bpm: Annotated[float, Field(ge=20, le=400)]
    """Tempo of the recorded dance."""
    first_beat_s: Annotated[float, Field(ge=0, le=36_000)]
    """When measure 1 begins [s]."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    start_measure: Annotated[int, Field(ge=1, le=100_000)] = 1
    """Measure in which the step begins, from 1."""
    measures: Annotated[int, Field(ge=1, le=10_000)] = 1
    """Length of the step (T020)."""
    leading_foot: Literal["left", "right"] | None = None
    begin_pose: Word | None = None
    """Pose in which it begins; only steps that end in it may come before (T136)."""
    end_pose: Word | None = None
    weight_transfer: bool | None = None
    """Whether a repeat must be danced on the other side (T135)."""
    direction: str | None = None
    """One of the nine directions, as the dancer sees them; measured if it is left out (T131)."""
    distance_m: Annotated[float, Field(ge=0, le=100)] | None = None
    """How far it gets; measured if it is left out."""
    author: Word | None = None
    style: Word | None = None
    """Stylistic variation in a word: how it is danced (T040)."""
    tags: Annotated[list[Word], Field(max_length=64)] = []
    unstructured: bool = False
    """Whether it is a stream that nobody has cut into steps: every measure is a clip, similarity alone joins (T037)."""
    mirror: bool = False
    """Whether the mirror image is a variation, too."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Something wrong: file, line, field, what was read and what is expected."""

    file: Path
    line: int | None
    field: str
    words: str

    @property
    def place(self) -> str:
        """File and line."""
        return str(self.file) if self.line is None else f"{self.file}, line {self.line}"

    def __str__(self) -> str:
        return f"{self.place}: {self.field}: {self.words}" if self.field else f"{self.place}: {self.words}"


class RecordingError(PersonError):
    """Recordings that cannot be used: for each problem file, line, field, what was read and what is allowed."""

    def __init__(self, message: str, remedy: str | None = None, problems: tuple[Problem, ...] = ()) -> None:
        super().__init__(message, remedy)
        self.problems = problems


def error_of(problems: list[Problem]) -> RecordingError:
    """All problems as one error, the first eight different ones in words."""
    words = list(dict.fromkeys(map(str, problems)))
    more = len(words) - SHOWN_PROBLEMS
    told = "; ".join(words[:SHOWN_PROBLEMS]) + (f"; and {more} more" if more > 0 else "")
    return RecordingError(told, problems=tuple(problems))


@dataclass(frozen=True, slots=True, eq=False)
class RecordingEntry:
    """A recording with the place in its TOML file, for messages."""

    recording: Recording
    toml: Path
    lines: dict[KeyPath, int]
    where: KeyPath
    """Path of the table: () or ("step", index)."""

    @property
    def path(self) -> Path:
        """The motion file."""
        return self.toml.parent / self.recording.file

    @property
    def skeleton(self) -> Path | None:
        """The file of its skeleton, if one is named."""
        return None if self.recording.skeleton is None else self.toml.parent / self.recording.skeleton

    def problem(self, field: str, words: str) -> Problem:
        """A problem with one field."""
        return problem_at(self.toml, self.lines, self.where, (field,), words)

    def error(self, field: str, words: str) -> RecordingError:
        """The same as an error."""
        return error_of([self.problem(field, words)])


def problem_at(toml: Path, lines: dict[KeyPath, int], where: KeyPath, field: KeyPath, words: str) -> Problem:
    """`field` may stand in the table `where` or, as a default for all steps, at the top of the file."""
    path = where + field if where + field[:1] in lines or field[:1] not in lines else field
    name = ".".join(str(part + 1) if isinstance(part, int) else part for part in path) or "the file"
    return Problem(toml, line_of(lines, path), name, words)
