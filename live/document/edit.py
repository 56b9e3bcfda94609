"""Edits as values: the closed set of changes of a document, as people send them and as the history keeps them."""

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.errors import PersonError
from live.document.document import Splice

Action = Literal["insert", "change", "move", "resize", "copy", "delete", "rename", "set"]
ACTIONS: Final[tuple[str, ...]] = get_args(Action)
TOGETHER: Final = "together"
"""Several edits that are one: they are checked, saved and undone as one."""
MAX_TOGETHER: Final = 1000
"""Maximum number of edits that are one."""
MAX_EDIT_BYTES: Final = 1_000_000
_Key = Annotated[str, Field(min_length=1, max_length=200)] | Annotated[int, Field(ge=1, le=1_000_000)]


class _SpliceForm(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    file: Annotated[str, Field(max_length=1000)]
    block: Annotated[int, Field(ge=0, le=1_000_000)]
    old: Annotated[list[str], Field(max_length=100_000)]
    new: Annotated[list[str], Field(max_length=100_000)]


class _EditForm(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    do: Action
    at: Annotated[list[_Key], Field(min_length=1, max_length=16)]
    value: Any = None
    id: Annotated[str, Field(max_length=100)] | int | None = None
    by: Annotated[str, Field(max_length=64)] | None = None
    base: Annotated[int, Field(ge=0)] | None = None
    exact: Annotated[list[_SpliceForm], Field(max_length=1000)] | None = None


class _TogetherForm(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    do: Literal["together"]
    edits: Annotated[list[Any], Field(min_length=1, max_length=MAX_TOGETHER)]
    id: Annotated[str, Field(max_length=100)] | int | None = None
    by: Annotated[str, Field(max_length=64)] | None = None
    base: Annotated[int, Field(ge=0)] | None = None
    exact: Annotated[list[_SpliceForm], Field(max_length=1000)] | None = None


@dataclass(frozen=True, slots=True)
class Edit:
    """A change of a document, by one person."""

    do: str
    """What it does, of `ACTIONS`, or `TOGETHER`."""
    at: tuple[str | int, ...]
    """What it changes: keys from the outermost table inwards; entries by name, or by their number from 1."""
    value: Any = None
    id: str | int | None = None
    """What the sender calls it, for the answer."""
    by: str = ""
    """Who made it."""
    base: int | None = None
    """The revision that the sender saw; None: the present one."""
    exact: tuple[Splice, ...] = ()
    """Of an inverse: the texts that give the document back byte by byte, while nobody has changed them since."""
    edits: tuple["Edit", ...] = ()
    """Of `TOGETHER`: the edits, each as the document is after the one before."""

    @property
    def parts(self) -> tuple["Edit", ...]:
        """The single edits that it consists of; the first one has the exact texts."""
        if not self.edits:
            return (self,)
        first, *others = (replace(one, by=self.by, base=self.base) for one in self.edits)
        return (replace(first, exact=self.exact), *others)

    def to_json_values(self) -> dict[str, Any]:
        """Return it as values for JSON."""
        values: dict[str, Any] = {"do": self.do}
        if self.edits:
            values["edits"] = [{"do": one.do, "at": list(one.at), "value": one.value} for one in self.edits]
        else:
            values |= {"at": list(self.at), "value": self.value}
        values |= {key: value for key in ("id", "by", "base") if (value := getattr(self, key)) not in (None, "")}
        if self.exact:
            values["exact"] = [
                {"file": one.file, "block": one.block, "old": list(one.old), "new": list(one.new)} for one in self.exact
            ]
        return values


def parse_edit(values: object) -> Edit:
    """Return the edit that was sent; PersonError with its field and what is allowed."""
    if isinstance(values, dict) and values.get("do") == TOGETHER:
        return _parse_together(values)
    try:
        form = _EditForm.model_validate(values)
    except ValidationError as error:
        raise _form_error(error, _EditForm) from None
    _check_value(form.value, depth=0)
    return Edit(form.do, tuple(form.at), form.value, form.id, form.by or "", form.base, _splices(form.exact))


def _splices(forms: Sequence[_SpliceForm] | None) -> tuple[Splice, ...]:
    return tuple(Splice(one.file, one.block, tuple(one.old), tuple(one.new)) for one in forms or ())


def _parse_together(values: dict[str, Any]) -> Edit:
    try:
        form = _TogetherForm.model_validate(values)
    except ValidationError as error:
        raise _form_error(error, _TogetherForm) from None
    edits = list[Edit]()
    for number, inner in enumerate(form.edits, start=1):
        if not isinstance(inner, dict) or not {*inner} <= {"do", "at", "value"}:
            raise PersonError(f"edits: edit {number}: an object of do, at, value expected")
        if inner.get("do") == TOGETHER:
            raise PersonError(f"edits: edit {number}: {TOGETHER!r} within {TOGETHER!r}", "one list of edits expected")
        try:
            edits.append(parse_edit(inner))
        except PersonError as error:
            raise PersonError(f"edits: edit {number}: {error.message}", error.remedy) from None
    return Edit(TOGETHER, (), None, form.id, form.by or "", form.base, _splices(form.exact), tuple(edits))


def _form_error(error: ValidationError, form: type[BaseModel]) -> PersonError:
    first = error.errors(include_url=False)[0]
    where = ".".join(str(part) for part in first["loc"][:2])
    keys = ", ".join(form.model_fields)
    words = "unknown key" if first["type"] == "extra_forbidden" else first["msg"][:1].lower() + first["msg"][1:]
    remedy = f"allowed are {', '.join((*ACTIONS, TOGETHER))}" if where == "do" else f"an edit is an object of {keys}"
    return PersonError(f"{where or 'edit'}: {words}", remedy)


def parse_edits(text: str, what: str) -> list[Edit]:
    """Return the edits of a list in JSON; PersonError that names the faulty one. `what` is the text's name."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        words = error if isinstance(error, ValueError) else "its brackets are nested too deep"
        raise PersonError(f"{what}: not JSON: {words}") from None
    if not isinstance(found, list):
        raise PersonError(f"{what}: a list of edits expected", '[{"do": "set", "at": ["seed"], "value": 7}]')
    edits = []
    for number, values in enumerate(found, start=1):
        try:
            edits.append(parse_edit(values))
        except PersonError as error:
            raise PersonError(f"{what}: edit {number}: {error.message}", error.remedy) from None
    return edits


def _check_value(value: object, depth: int) -> None:
    """Raise PersonError for what TOML cannot hold; null stands alone, or for a key that is removed."""
    if depth > 16:
        raise PersonError("value: its brackets are nested too deep")
    if isinstance(value, float) and not math.isfinite(value):
        raise PersonError("value: a finite number expected")
    if isinstance(value, int) and abs(value) >> 63:
        raise PersonError("value: number with too many digits")
    if isinstance(value, str) and any("\ud800" <= letter <= "\udfff" for letter in value):
        raise PersonError("value: not a text in UTF-8")
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        if inner is None and depth > 0:
            raise PersonError("value: null only removes a key")
        _check_value(inner, depth + 1)


@dataclass(frozen=True, slots=True)
class Fault:
    """Why an edit was refused, at one place."""

    what: str
    file: str = ""
    line: int | None = None
    field: str = ""
    """The key, with entries counted from 1: `segment.3.measures`."""
    remedy: str = ""
    measure: float | None = None
    """The measure that it concerns."""
    dancers: str | None = None
    """The dancers that it concerns, as a selection."""

    def to_json_values(self) -> dict[str, Any]:
        """Return it as values for JSON."""
        keys = ("file", "line", "field", "what", "remedy", "measure", "dancers")
        return {key: getattr(self, key) for key in keys}

    def __str__(self) -> str:
        place = f"{self.file}, line {self.line}: " if self.line is not None else ""
        field_text = f"{self.field}: " if self.field else ""
        return f"{place}{field_text}{self.what}" + (f" ({self.remedy})" if self.remedy else "")


class EditRefused(Exception):
    """An edit was refused; the document is as it was."""

    def __init__(self, *faults: Fault) -> None:
        """`faults` are all errors that were found."""
        super().__init__("; ".join(map(str, faults)))
        self.faults = faults


Shift = tuple[tuple[str, ...], int, int]
"""An entry that was inserted (list, -1, index), removed (list, index, -1) or moved (list, from, to)."""


def shifted_number(names: tuple[str, ...], number: int, shifts: Iterable[Shift]) -> int | None:
    """Return the number after some shifts of the entry of a list that was `number` before; None if it was removed."""
    for there, begin, end in shifts:
        if there != names:
            continue
        if begin < 0:
            number += end <= number
        elif end < 0:
            if begin == number:
                return None
            number -= begin < number
        elif begin == number:
            number = end
        else:
            number += (end <= number < begin) - (begin < number <= end)
    return number


def shifted_key(key: tuple[str | int, ...], shifts: Sequence[Shift]) -> tuple[str | int, ...] | None:
    """Return a key, with entries by number from 0, as it is after some shifts; None if its entry was removed."""
    place = next((index for index, part in enumerate(key) if isinstance(part, int)), None)
    if place is None:
        return key
    number = shifted_number(tuple(str(part) for part in key[:place]), int(key[place]), shifts)
    return None if number is None else (*key[:place], number, *key[place + 1 :])


@dataclass(slots=True)
class Applied:
    """What an edit did to a document."""

    splices: list[Splice] = field(default_factory=list)
    """The changes of text, in order."""
    inverse: Edit | None = None
    """The edit that takes it back, without its exact texts."""
    keys: list[tuple[Any, ...]] = field(default_factory=list)
    """The keys that it changed, with entries by number from 0: ("segment", 2, "measure")."""
    shifts: list[Shift] = field(default_factory=list)
    """Entries that were inserted (list, -1, index), removed (list, index, -1) or moved (list, from, to)."""
