"""The history of a document: every revision with what it changed, kept in a file beside the show.

One JSON object for each revision and line. Each holds the texts that it replaced, so that every earlier revision can
be built again from the present texts.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.errors import PersonError
from live.document.document import Document, Splice
from live.document.edit import Edit, EditRefused, Fault, Shift, parse_edit, shifted_key, shifted_number
from live.document.place import path_text, refuse
from live.show.patch.toml_model import key_text

MAX_HISTORY_BYTES: Final = 200_000_000
MEASURED: Final = frozenset(("segment", "sequence", "improvise", "element", "signal", "curve", "at", "regroup"))
"""Lists whose entries have a measure: to move one does not change their order."""
What = Literal["edit", "keep", "music", "undo", "redo", "restore", "files"]


class _Splice(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)
    file: str
    block: Annotated[int, Field(ge=0)]
    old: list[str]
    new: list[str]


class _Line(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)
    revision: Annotated[int, Field(ge=0)]
    what: What
    by: str = ""
    date: str = ""
    of: int | None = None
    edit: dict[str, Any] | None = None
    inverse: dict[str, Any] | None = None
    splices: list[_Splice] = []
    keys: list[list[str | int]] = []
    shifts: list[tuple[list[str], int, int]] = []
    texts: str


@dataclass(frozen=True, slots=True)
class Revision:
    """One step of a document's history."""

    number: int
    """From 1; 0 is the state in which the history begins."""
    what: What
    """An edit, something made live that is kept, other music, an undo or redo, a return to an earlier revision, or a
    change of the files by another program."""
    by: str = ""
    """Who made it."""
    date: str = ""
    """When, in words for people."""
    of: int | None = None
    """The revision that it undoes, redoes, or returns to."""
    edit: Edit | None = None
    inverse: Edit | None = None
    splices: tuple[Splice, ...] = ()
    keys: tuple[tuple[str | int, ...], ...] = ()
    """The keys that it changed, entries by number from 0, after it."""
    shifts: tuple[Shift, ...] = ()
    """The entries that it inserted (list, -1, index), removed (list, index, -1) or moved."""
    texts: str = ""
    """Hash of all files after it."""

    def to_json_values(self) -> dict[str, Any]:
        """Return it as values for JSON."""
        return {
            "revision": self.number, "what": self.what, "by": self.by, "date": self.date, "of": self.of,
            "edit": None if self.edit is None else self.edit.to_json_values(),
            "inverse": None if self.inverse is None else self.inverse.to_json_values(),
            "splices": [
                {"file": one.file, "block": one.block, "old": list(one.old), "new": list(one.new)}
                for one in self.splices
            ],
            "keys": [list(key) for key in self.keys],
            "shifts": [[list(names), begin, end] for names, begin, end in self.shifts],
            "texts": self.texts,
        }  # fmt: skip

    @property
    def text(self) -> str:
        """What it did, in words: `set stage.width 9`."""
        edit = self.edit
        did = "" if edit is None else f"{edit.do} {path_text(edit.at)} {'' if edit.value is None else edit.value}"[:100]
        match self.what:
            case "edit":
                return did.strip()
            case "keep" | "music":
                return f"{self.what}: {did.strip()}"
            case "files" if not self.splices:
                return "the history begins here"
            case "files":
                return f"another program changed {', '.join(dict.fromkeys(one.file for one in self.splices))}"
            case _:
                return f"{self.what} of revision {self.of}" + (f": {did.strip()}" if did else "")

    def reversed(self) -> "Revision":
        """Return what takes it back, as to its `shifts` and the `keys` that are there before and after it."""
        back = replace(self, shifts=tuple((names, end, begin) for names, begin, end in reversed(self.shifts)))
        keys = (_present_key(key, [back]) for key in self.keys)
        return replace(back, keys=tuple(key for key in keys if key is not None))

    def shifted(self, names: tuple[str, ...], number: int) -> int | None:
        """Return the number after this revision of the entry that was `number` before it; None if it was removed."""
        return shifted_number(names, number, self.shifts)


def texts_hash(texts: Mapping[str, str]) -> str:
    """Return a hash of the texts of all files by name."""
    state = hashlib.blake2b(digest_size=16)
    for name in sorted(texts):
        for part in (name, texts[name]):
            data = part.encode("utf-8", "surrogatepass")
            state.update(len(data).to_bytes(8, "little") + data)
    return state.hexdigest()


def parse_revision(line: str) -> Revision:
    """Return the revision of a line of a history; ValueError if it is damaged."""
    try:
        form = _Line.model_validate_json(line)
        edit = None if form.edit is None else parse_edit(form.edit)
        inverse = None if form.inverse is None else parse_edit(form.inverse)
    except (ValidationError, PersonError, RecursionError) as error:
        raise ValueError(str(error)) from None
    return Revision(
        form.revision, form.what, form.by, form.date, form.of, edit, inverse,
        tuple(Splice(one.file, one.block, tuple(one.old), tuple(one.new)) for one in form.splices),
        tuple(tuple(key) for key in form.keys),
        tuple((tuple(names), begin, end) for names, begin, end in form.shifts),
        form.texts,
    )  # fmt: skip


def read_history(path: Path) -> list[Revision]:
    """Return the revisions in a file, in their order; those before a damaged line are left out, a line that was cut
    off at the end, too. No file: none."""
    try:
        if path.stat().st_size > MAX_HISTORY_BYTES:
            return []
        lines = path.read_bytes().decode("utf-8", "replace").split("\n")
    except OSError:
        return []
    revisions: list[Revision] = []
    for line in filter(None, lines):
        try:
            revision = parse_revision(line)
        except ValueError:
            if line is not lines[-1]:
                revisions = []
            continue
        if revisions and revision.number != revisions[-1].number + 1:
            revisions = []
        revisions.append(revision)
    return revisions


def texts_at(document: Document, revisions: Sequence[Revision], number: int) -> dict[str, str]:
    """Return the texts of the files at a revision: those of the document, taken back revision by revision.

    LookupError if the history does not reach back so far.
    """
    files = {file.name: [block.text for block in file.blocks] for file in document.files}
    if not revisions or not revisions[0].number <= number <= revisions[-1].number:
        raise LookupError(number)
    for revision in reversed(revisions):
        if revision.number <= number:
            break
        for splice in reversed(revision.splices):
            blocks = files.setdefault(splice.file, [])
            end = splice.block + len(splice.new)
            if tuple(blocks[splice.block : end]) != splice.new:
                raise LookupError(revision.number)
            blocks[splice.block : end] = splice.old
    return {name: "".join(blocks) for name, blocks in files.items() if blocks}


def differences(old: Mapping[str, Iterable[str]], new: Mapping[str, Iterable[str]]) -> list[Splice]:
    """Return the splices from the blocks of all files by name to other ones: at most one for each file."""
    splices = []
    for name in sorted({*old, *new}):
        before, after = tuple(old.get(name, ())), tuple(new.get(name, ()))
        if before == after:
            continue
        if not before or not after:
            splices.append(Splice(name, 0, before, after))
            continue
        begin = 0
        while begin < min(len(before), len(after)) and before[begin] == after[begin]:
            begin += 1
        end = 0
        while end < min(len(before), len(after)) - begin and before[-1 - end] == after[-1 - end]:
            end += 1
        if begin + end in (len(before), len(after)):  # nothing is left on one side: take a neighbour along
            begin, end = (begin - 1, end) if begin > 0 else (begin, end - 1)
        splices.append(Splice(name, begin, before[begin : len(before) - end], after[begin : len(after) - end]))
    return splices


def history_line(revision: Revision) -> bytes:
    """Return the line of a revision."""
    return json.dumps(revision.to_json_values(), ensure_ascii=False, separators=(",", ":")).encode() + b"\n"


def in_force(revisions: Sequence[Revision]) -> list[Revision]:
    """Leave out pairs of neighbours of which the second takes back the first: together they change nothing."""
    kept: list[Revision] = []
    for one in revisions:
        if kept and one.what in ("undo", "redo") and one.of == kept[-1].number:
            kept.pop()
        else:
            kept.append(one)
    return kept


def rebased(edit: Edit, later: Sequence[Revision]) -> Edit:
    """Return an edit as it is written after some `later` revisions: entries that it counts have other numbers then.

    EditRefused if its entry was removed, or if nobody can say any more which one it is.
    """
    at = list(edit.at)
    place = next((index for index, key in enumerate(at) if isinstance(key, int)), None)
    if place is None or not later:
        return edit
    names = tuple(str(key) for key in at[:place])
    number = int(at[place]) - 1
    for revision in later:
        by = revision.by or "another program"
        if revision.what in ("files", "restore"):
            raise refuse(edit.at, f"{by} changed the document since, and numbers may mean others now", "look again")
        if len(names) == 3 and any(there == names[2:] for there, _, _ in revision.shifts):
            raise refuse(edit.at, f"{by} inserted, moved or removed entries of {names[2]} meanwhile", "look again")
        found = revision.shifted(names, number)
        if found is None:
            raise refuse(edit.at, f"{by} removed it meanwhile, in revision {revision.number}")
        number = found
    at[place] = number + 1
    return replace(edit, at=tuple(at))


def check_conflict(edit: Edit, keys: Sequence[tuple[str | int, ...]], later: Sequence[Revision]) -> None:
    """Raise EditRefused if somebody else changed one of the `keys` of an edit in a later revision that is in force."""
    numbers = {revision.number for revision in later}
    undone = {revision.of for revision in later if revision.what == "undo"}
    for index, revision in enumerate(later):
        if revision.by == edit.by and revision.what != "files":
            continue
        if revision.number in undone or (revision.what == "undo" and revision.of in numbers):
            continue
        for changed in revision.keys:
            there = _present_key(changed, later[index + 1 :])
            if there is not None and any(_overlap(there, key) for key in keys):
                who = revision.by or "somebody else"
                fault = Fault(f"{who} changed it meanwhile, in revision {revision.number}", field=key_text(there))
                raise EditRefused(replace(fault, remedy="look at it, and change it again"))


def check_order(edits: Sequence[Edit], later: Sequence[Revision]) -> None:
    """Raise EditRefused if edits that are one count entries after they changed their numbers, of a list that somebody
    changed in a later revision: then nobody can say which entries they mean."""
    counted = set[str]()
    for edit in reversed(edits):
        name = str(edit.at[0])
        moves = edit.do == "move" and (isinstance(edit.value, dict) or name in MEASURED)
        changes_numbers = edit.do in ("insert", "copy", "delete", "move") and not moves
        changes_numbers |= moves and isinstance(edit.value, dict) and "number" in edit.value
        changed = any(key[0] == name for one in later for key in (*one.keys, *(names for names, _, _ in one.shifts)))
        if changes_numbers and name in counted and changed:
            raise refuse(edit.at, f"somebody changed entries of {name} meanwhile", "look again, and repeat it")
        if len(edit.at) > 1:
            counted.add(name)


def _present_key(key: tuple[str | int, ...], later: Sequence[Revision]) -> tuple[str | int, ...] | None:
    """Return a key that a revision changed, with its entry's number after `later` ones; None if it is gone."""
    return shifted_key(key, [shift for revision in later for shift in revision.shifts])


def _overlap(a: tuple[str | int, ...], b: tuple[str | int, ...]) -> bool:
    shared = min(len(a), len(b))
    return a[:shared] == b[:shared]
