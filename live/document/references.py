"""Where a document uses the name of a thing, so that a new name can be given everywhere at once."""

import re
from collections.abc import Callable, Iterator
from typing import Any, Final, NamedTuple

from live.control.registry.registry import REGISTRY
from live.document.document import Document
from live.document.place import Place, folded
from live.show.desk.parameter_table import LOOK, VIEW
from live.show.patch.section_music import CURVE_PREFIX


class Reference(NamedTuple):
    """One use of a name."""

    place: Place
    value: Any
    """The value there, with the new name."""
    key: str | None = None
    """For a key that holds the name, the new key."""


Rename = Callable[[Any], Any]
"""Returns a value with the new name for the old one."""

ARGUMENT_NAMES: Final = {"looks": "look", "mocap": "performer"}
"""What arguments call the things of a list, where that is not the list's own name."""
_PLACED: Final = ("segment", "sequence", "at", "signal", "curve", "element", "improvise", "regroup")
FIELDS: Final[dict[str, tuple[tuple[str, str], ...]]] = {
    "section": (
        *((kind, "section") for kind in _PLACED),
        ("cue", "section"), ("section", "then"),
    ),
    "curve": (("signal", "curve"),),
    "scene": (("cue", "scene"), ("at", "scene")),
    "signal": (("at", "signal"), ("react", "on")),
    "formation": (
        ("segment", "formation"), ("group", "formation"),
        *((kind, key) for kind, keys in (("formation", ("like", "along", "into")), ("evolution", ("along", "into")))
          for key in keys),
    ),
    "evolution": (("segment", "evolution"), ("evolution", "like")),
    "group": (
        *((kind, "group") for kind in ("sequence", "segment", "element", "improvise", "regroup", "react")),
        ("improvise", "answers"), ("group", "like"), ("group", "facing"), ("regroup", "dancers"),
        ("element", "whom"), ("partner", "leader"), ("partner", "follower"), ("answer", "group"),
    ),
    "mocap": (("answer", "performer"),),
    "selections": (
        *((kind, "group") for kind in ("sequence", "segment", "element", "improvise", "react")),
        ("regroup", "dancers"), ("partner", "leader"), ("partner", "follower"), ("answer", "group"),
    ),
}  # fmt: skip
"""Keys that hold the name of a thing, by the thing's list."""
PAD_KINDS: Final = {"formation": "formation", "scene": "scene", "cue": "cue", "sequence": "phrase"}
"""What `[[pad]] does` calls the things of a list."""
_WORD: Final = re.compile(r"[^\W\d]\w*(?:-\w+)*")
_BY_ADDRESS: Final = {control.address: control for control in REGISTRY}


def references(document: Document, kind: str, old: str, new: str) -> Iterator[Reference]:
    """Yield every use of the name `old` of a thing in the list `kind`, with the value that has the name `new`."""
    was = folded(old)
    by_word = kind in ("group", "selections")

    def renamed(text: Any) -> Any:
        if not isinstance(text, str):
            return text
        if folded(text) == was:
            return new
        return _WORD.sub(lambda word: new if folded(word.group()) == was else word.group(), text) if by_word else text

    yield from _fields(document, kind, was, new, renamed)
    if by_word:
        yield from (
            Reference(Place((), None, ("selections", name)), renamed(words))
            for name, words in _selections(document)
            if renamed(words) != words
        )
    argument = "group" if kind == "selections" else ARGUMENT_NAMES.get(kind, kind)
    for place, address, values in _calls(document):
        if (found := _renamed_values(address, values, argument, renamed)) != values:
            call = [address, *found] if place.names == ("cue",) else found
            yield Reference(place, call)
    yield from _mappings(document, argument, renamed)
    yield from _scene_keys(document, kind, renamed)
    for place, table in _tables(document, "pad") if kind in PAD_KINDS else ():
        word, _, name = str(table.get("does", "")).strip().partition(" ")
        if word.casefold() == PAD_KINDS[kind] and folded(name) == was:
            yield Reference(_below(place, "does"), f"{word} {new}")


def _fields(document: Document, kind: str, was: str, new: str, renamed: Rename) -> Iterator[Reference]:
    for there, field in FIELDS.get(kind, ()):
        for place, table in _tables(document, there):
            if field in table and renamed(table[field]) != table[field]:
                yield Reference(_below(place, field), renamed(table[field]))
    for place, table in _tables(document, "react") if kind == "curve" else ():
        if folded(table.get("to", "")) == CURVE_PREFIX + was:
            yield Reference(_below(place, "to"), CURVE_PREFIX + new)


def _tables(document: Document, *names: str) -> Iterator[tuple[Place, dict[str, Any]]]:
    for number, entry in enumerate(document.entries(names)):
        yield Place(names, number), document.values(entry)


def _below(place: Place, *keys: str | int) -> Place:
    return Place(place.names, place.number, (*place.rest, *keys))


def _selections(document: Document) -> Iterator[tuple[str, Any]]:
    for file in document.files:
        table = file.data.get("selections")
        if isinstance(table, dict):
            yield from table.items()


def _calls(document: Document) -> Iterator[tuple[Place, str, list[Any]]]:
    """Yield every call: where its values stand (in a cue, address and values), its address and its values."""
    for kind in ("at", "react"):
        for place, table in _tables(document, kind):
            if "call" in table and "values" in table:
                yield _below(place, "values"), table["call"], table["values"]
    for place, table in _tables(document, "cue"):
        for row, call in enumerate(table.get("calls", [])):
            yield _below(place, "calls", row), call[0], call[1:]
    for place, table in _tables(document, "improvise"):
        for row, motion in enumerate(table.get("motion", [])):
            if "call" in motion and "values" in motion:
                yield _below(place, "motion", row, "values"), motion["call"], motion["values"]


def _renamed_values(address: str, values: list[Any], argument: str, renamed: Rename) -> list[Any]:
    control = _BY_ADDRESS.get(address)
    if control is None:
        return values
    kinds = [one.names or ("group" if one.name == "facing" else "") for one in control.arguments]
    return [
        renamed(value) if index < len(kinds) and kinds[index] == argument else value
        for index, value in enumerate(values)
    ]


def _mappings(document: Document, argument: str, renamed: Rename) -> Iterator[Reference]:
    """Yield the values of MIDI mappings that name a thing."""
    for names in (("midi", "map"), ("midi", "learned")):
        for place, table in _tables(document, *names):
            control = _BY_ADDRESS.get(str(table.get("control")))
            for one in control.arguments if control is not None else ():
                value = table.get("values", {}).get(one.name)
                if one.names == argument and renamed(value) != value:
                    yield Reference(_below(place, "values", one.name), renamed(value))


def _scene_keys(document: Document, kind: str, renamed: Rename) -> Iterator[Reference]:
    """Yield the scenes and looks that set a group's value, and the scenes that recall a view or look."""
    by_word = kind in ("group", "selections")
    for place, values in (*_tables(document, "looks"), *_tables(document, "group")) if by_word else ():
        for key, value in values.get("draw", {}).items():
            name, _, group = key.partition(" ")
            if renamed(group) != group:
                yield Reference(_below(place, "draw", key), value, f"{name} {renamed(group)}")
    for place, values in _tables(document, "scene"):
        table = values.get("set", {})
        for key, value in table.items():
            address, _, group = key.partition(" ")
            if by_word and renamed(group) != group:
                yield Reference(_below(place, "set", key), value, f"{address} {renamed(group)}")
            if address == {"view": VIEW, "looks": LOOK}.get(kind) and renamed(value) != value:
                yield Reference(_below(place, "set", key), renamed(value))
