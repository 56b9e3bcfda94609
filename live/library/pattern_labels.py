"""Labels that a person gives to the patterns of recorded couples (H021, H022): a TOML file beside the pairs.

A pattern is eight beats long. Its times are kept, not its number, so that labels stay where they are when beats are
found anew.
"""

import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.errors import PersonError
from live.base.toml import error_line, line_of, parse_toml, toml_line_numbers
from live.library.disk_cache import read_regular_file
from live.library.whole_file import write_atomically

MAX_BYTES: Final = 1_000_000
MAX_PATTERNS: Final = 10_000
MAX_LABELS: Final = 30
SHOWN_PROBLEMS: Final = 6
MAX_OVERLAP_S: Final = 0.1
"""Two patterns of a take may overlap so much: a person cuts where it is heard [s]."""

LabelName = Annotated[str, Field(pattern=r"^[^\W_][\w .+'/-]{0,39}$")]
"""A label: letters, digits, blanks, `-`, `.`, `+`, `'` and `/`; it begins with a letter or a digit."""
TakeName = Annotated[str, Field(min_length=1, max_length=64)]


class LabelledPattern(BaseModel):
    """One pattern of one take."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    take: TakeName
    """Name of the pair."""
    from_s: Annotated[float, Field(ge=0, le=36_000)]
    to_s: Annotated[float, Field(ge=0, le=36_000)]
    label: LabelName


class LabelsFile(BaseModel):
    """The contents of a file of labels."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    labels: Annotated[list[LabelName], Field(max_length=MAX_LABELS)] = []
    """All labels to choose from, in the order of their keys."""
    pattern: Annotated[list[LabelledPattern], Field(max_length=MAX_PATTERNS)] = []


@dataclass(frozen=True, slots=True)
class PatternLabels:
    """Labels of some takes, each take's in their order."""

    labels: tuple[str, ...]
    patterns: tuple[LabelledPattern, ...]

    def of(self, take: str) -> tuple[LabelledPattern, ...]:
        """Return the patterns of a take, ascending."""
        return tuple(one for one in self.patterns if one.take == take)

    def at(self, take: str, time: float) -> str | None:
        """Return the label of a take at a time [s], None where nobody gave one."""
        return next((one.label for one in self.of(take) if one.from_s <= time < one.to_s), None)


NO_LABELS: Final = PatternLabels((), ())


def labels_path(pairs: Path) -> Path:
    """Return where the labels of a file of pairs are."""
    return pairs.with_suffix(".labels.toml")


def read_labels(path: Path) -> PatternLabels:
    """Read a file of labels; PersonError with file, line and field for anything invalid."""
    try:
        held = read_regular_file(path, MAX_BYTES)
        if len(held) > MAX_BYTES:
            raise PersonError(f"{path}: more than {MAX_BYTES} bytes")
        text = held.decode("utf-8-sig")
    except OSError as error:
        raise PersonError(f"cannot read the labels {path}: {error.strerror}", "--labels FILE.toml") from None
    except UnicodeDecodeError as error:
        raise PersonError(f"{path}: not a text in UTF-8 (byte {error.start})") from None
    try:
        data = parse_toml(text)
    except tomllib.TOMLDecodeError as error:
        raise PersonError(f"{path}, line {error_line(str(error), text)}: not valid TOML: {error}") from None
    except RecursionError:
        raise PersonError(f"{path}: brackets in brackets too deep") from None
    lines = toml_line_numbers(text)
    try:
        found = LabelsFile.model_validate(data)
    except ValidationError as error:
        told = [
            f"{path}, line {line_of(lines, tuple(one['loc']))}: {_field(one['loc'])}: {_problem(one)}"
            for one in error.errors(include_url=False)
        ]
        raise PersonError(
            "; ".join(told[:SHOWN_PROBLEMS]), "`live couple label PAIRS.toml` writes such a file"
        ) from None
    ordered = sorted(enumerate(found.pattern), key=lambda one: (one[1].take, one[1].from_s))
    for n, one in enumerate(found.pattern):
        if not one.from_s < one.to_s:
            raise PersonError(f"{path}, line {line_of(lines, ('pattern', n))}: to_s after from_s expected")
    for (_, one), (n, other) in pairwise(ordered):
        if one.take == other.take and other.from_s < one.to_s - MAX_OVERLAP_S:
            raise PersonError(
                f"{path}, line {line_of(lines, ('pattern', n))}: {other.take} has two labels at {other.from_s:g} s: "
                f"{one.label!r} and {other.label!r}", "one label at a time",
            )  # fmt: skip
    return _in_order(found.labels, [one for _, one in ordered])


def checked_labels(values: Any, seconds: dict[str, float]) -> PatternLabels:
    """Return the labels that a page has sent; PersonError if they are not such, or name takes that are not there.

    `seconds`: the length of each take [s].
    """
    try:
        found = LabelsFile.model_validate(values)
    except ValidationError as error:
        one = error.errors(include_url=False)[0]
        raise PersonError(f"{_field(one['loc'])}: {_problem(one)}") from None
    for pattern in found.pattern:
        length = seconds.get(pattern.take)
        if length is None:
            raise PersonError(f"there is no take {pattern.take[:64]!r}")
        if not 0.0 <= pattern.from_s < pattern.to_s <= length + MAX_OVERLAP_S:
            raise PersonError(f"{pattern.take}: {pattern.from_s:g} to {pattern.to_s:g} s; it has {length:.2f} s")
    ordered = sorted(found.pattern, key=lambda one: (one.take, one.from_s))
    for before, after in pairwise(ordered):
        if before.take == after.take and after.from_s < before.to_s - MAX_OVERLAP_S:
            raise PersonError(f"{after.take}: two labels at {after.from_s:g} s", "one label at a time")
    return _in_order(found.labels, ordered)


def _in_order(names: list[str], patterns: list[LabelledPattern]) -> PatternLabels:
    """Labels of patterns that are not among the names come after them."""
    more = [one.label for one in patterns]
    return PatternLabels(tuple(dict.fromkeys([*names, *more])), tuple(patterns))


def _field(place: tuple[int | str, ...]) -> str:
    return ".".join(str(part + 1) if isinstance(part, int) else part for part in place) or "the labels"


def _problem(problem: Any) -> str:
    if problem["type"] == "missing":
        return "missing; it must be given"
    if problem["type"] == "extra_forbidden":
        return "unknown key"
    if problem["type"] == "string_pattern_mismatch":
        return f"a word of letters, digits, blanks and - . + ' / expected, found {str(problem['input'])[:60]!r}"
    return f"{problem['msg'][:1].lower()}{problem['msg'][1:]}, found {str(problem['input'])[:60]!r}"


def write_labels(path: Path, labels: PatternLabels) -> None:
    """Write a file of labels: wholly or not at all. PersonError if it cannot be written."""
    lines = ["# Patterns of recorded couples, labelled by a person (live couple label).", ""]
    lines += [f"labels = [{', '.join(_quoted(name) for name in labels.labels)}]", ""]
    for one in labels.patterns:
        lines += [
            "[[pattern]]", f"take = {_quoted(one.take)}", f"from_s = {one.from_s:.3f}", f"to_s = {one.to_s:.3f}",
            f"label = {_quoted(one.label)}", "",
        ]  # fmt: skip
    write_atomically("\n".join(lines).encode(), path, "the labels", synced=True)


def _quoted(text: str) -> str:
    """Return a text as a TOML string."""
    special = {"\\": "\\\\", '"': '\\"'}
    return '"' + "".join(
        special.get(letter, letter if letter.isprintable() else f"\\u{ord(letter):04X}") for letter in text
    ) + '"'  # fmt: skip
