"""Paths of edits: an entry by name or number, a key of it, a table, or a new entry's place in a list."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from live.base.toml import KeyPath
from live.document.document import LIST_SECTIONS, Document, Entry, Names
from live.document.edit import EditRefused, Fault, Shift, shifted_key
from live.show.patch.toml_model import key_text


@dataclass(frozen=True, slots=True)
class Place:
    """Where an edit acts."""

    names: Names
    """The list of tables; empty: keys of a table, or of the patch itself."""
    number: int | None = None
    """The entry, from 0 in the order of the patch; None: the whole list, or no list."""
    rest: KeyPath = ()
    """Keys below the entry or, without a list, from the outermost table inwards; elements of lists from 0."""
    section: str | None = None
    """The section of the score whose entries are counted."""

    def entry(self, document: Document) -> Entry:
        """Return where the entry stands."""
        assert self.number is not None
        return document.entries(self.names)[self.number]

    @property
    def key(self) -> KeyPath:
        """The keys in the patch, entries from 0: ("segment", 2, "measures")."""
        return (*self.names, *(() if self.number is None else (self.number,)), *self.rest)


def refuse(at: tuple[str | int, ...], what: str, remedy: str = "") -> EditRefused:
    """Return the refusal of an edit at a path."""
    return EditRefused(Fault(what, field=path_text(at), remedy=remedy))


def as_written(refused: EditRefused, document: Document, shifts: Sequence[Shift]) -> EditRefused:
    """Return the refusal of an edit with lines and numbers of the `document` as it is without it.

    `shifts` are those of the edit. An entry that it inserts has no line, and keeps its number.
    """
    back = [(names, end, begin) for names, begin, end in reversed(shifts)]
    faults = []
    for fault in refused.faults:
        key = tuple(int(part) - 1 if part.isdecimal() else part for part in fault.field.split("."))
        former = shifted_key(key, back)
        if fault.line is None or not fault.field:
            faults.append(fault)
        elif former is None:
            faults.append(replace(fault, line=None))
        else:
            file, line = document.location(former)
            faults.append(replace(fault, file=file, line=line, field=key_text(former)))
    return EditRefused(*faults)


def path_text(at: tuple[str | int, ...]) -> str:
    """Return a path of an edit as messages show it."""
    return ".".join(map(str, at))


def folded(name: object) -> str:
    """Return a name as names are compared."""
    return str(name).casefold().strip()


def find_place(document: Document, at: tuple[str | int, ...]) -> Place:
    """Return where the path `at` of an edit leads; EditRefused, with what there is, if an entry is missing."""
    if len(at) >= 3 and at[0] == "section" and isinstance(at[2], str) and _has_section(at[2]):
        number = _number(document, at[:2], ("section",), at[1], range(len(document.entries(("section",)))))
        section = str(document.values(document.entries(("section",))[number]).get("name", ""))
        names: Names = (at[2],)
        members = [
            index
            for index, entry in enumerate(document.entries(names))
            if folded(document.values(entry).get("section", "")) == folded(section)
        ]
        if len(at) == 3:
            return Place(names, section=section)
        return Place(names, _number(document, at[:4], names, at[3], members), _keys(at[4:]), section)
    for length in (2, 1):
        names = tuple(str(key) for key in at[:length])
        if len(names) < length or names != at[:length] or not document.is_list(names):
            continue
        if len(at) == length:
            return Place(names)
        numbers = range(len(document.entries(names)))
        return Place(names, _number(document, at[: length + 1], names, at[length], numbers), _keys(at[length + 1 :]))
    return Place((), None, _keys(at))


def _has_section(name: str) -> bool:
    """Return whether the entries of a list may belong to a section of the score."""
    section = LIST_SECTIONS.get((name,))
    return section is not None and name != "cue" and "section" in section.model_fields


def _keys(at: tuple[str | int, ...]) -> KeyPath:
    return tuple(key - 1 if isinstance(key, int) else key for key in at)


def _number(
    document: Document, at: tuple[str | int, ...], names: Names, key: str | int, among: range | list[int]
) -> int:
    """Return the number from 0 of an entry, which `key` names, or counts from 1 `among` some."""
    what = names[-1]
    entries = document.entries(names)
    if isinstance(key, str):
        found = [number for number in among if folded(document.values(entries[number]).get("name", "")) == folded(key)]
        if len(found) == 1:
            return found[0]
        if found:
            words = f"{len(found)} entries of {what} are called {key!r}"
            raise refuse(at, words, f"give its number: {', '.join(str(number + 1) for number in found[:8])}")
        if not key.isdecimal():
            known = [str(name) for number in among if (name := document.values(entries[number]).get("name"))]
            raise refuse(at, f"no {what} is called {key!r}", f"there are: {', '.join(known[:40]) or 'none'}")
        key = int(key[:9])
    if not 1 <= key <= len(among):
        raise refuse(at, f"there is no {what} {key}", f"there are {len(among)}")
    return among[key - 1]


def value_at(document: Document, place: Place) -> Any:
    """Return the value that a file gives for a place; None if none does."""
    if place.number is not None:
        values: Any = document.values(place.entry(document))
        return _inner(values, place.rest)
    found = None
    for file in document.files:
        value = _inner(file.data, place.rest)
        found = {**found, **value} if isinstance(found, dict) and isinstance(value, dict) else found
        found = value if found is None else found
    return found


def _inner(values: Any, path: KeyPath) -> Any:
    for key in path:
        try:
            values = values[key]
        except (KeyError, IndexError, TypeError):
            return None
    return values
