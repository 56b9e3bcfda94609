"""Schema of snapshots: a kind is the serialized form of one class, with a name and fields with types.

Kind names are independent of modules and classes, so that code may move while old snapshots stay readable. Types are
written as:

    int float bool str none complex any     a value; a float may be an int
    f4 f8 i1 i4 i8 u1 u4 u8 b1 c16 array    an array of these numbers (`array`: of any)
    list[T] set[T] frozenset[T] deque[T]    containers
    dict[K,V] ordered[K,V] counter[K]
    tuple[T,U] row[T]                       a tuple of fixed length, of any length
    method event                            a bound method listed in `METHODS`, an event of `live.control`
    any other word                          an object of the kind of this name
    T|U                                     either

An array has the same shape as in a fresh show; `f4*` may have any shape. `i4(node)` holds indices of nodes, which are
checked against the number of nodes. Array values are finite with a magnitude up to `MAX_MAGNITUDE`; those of `f4~` may
be any.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

NUMBERS: Final = {
    "f4": "<f4", "f8": "<f8", "i1": "|i1", "i4": "<i4", "i8": "<i8", "u1": "|u1", "u4": "<u4", "u8": "<u8",
    "b1": "|b1", "c16": "<c16",
}  # fmt: skip
"""Array types by type word, as numpy dtype strings."""

MAX_MAGNITUDE: Final = 1e9
"""Maximum magnitude of array values; it fits a 32-bit integer."""

PLAIN: Final = frozenset({type(None), bool, int, float, str, bytes})
"""Classes of values that are written unchanged."""


@dataclass(frozen=True, slots=True)
class Type:
    """Type of a field: word, item types, what its indices refer to, and whether an array may have any shape or
    hold any number."""

    word: str
    items: tuple["Type", ...] = ()
    index_of: str = ""
    any_shape: bool = False
    any_number: bool = False

    @property
    def alternatives(self) -> tuple["Type", ...]:
        """The alternatives of a union; else the type itself."""
        return self.items if self.word == "|" else (self,)

    @property
    def any_shape_inside(self) -> bool:
        """Whether any array in it may have any shape."""
        return self.any_shape or any(each.any_shape_inside for each in self.items)

    def __str__(self) -> str:
        if self.word == "|":
            return "|".join(map(str, self.items))
        inside = f"[{','.join(map(str, self.items))}]" if self.items or self.word == "tuple" else ""
        return f"{self.word}{f'({self.index_of})' if self.index_of else ''}{'*' if self.any_shape else ''}{inside}"


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """The serialized form of one class."""

    name: str
    cls: type
    schema: str
    """The fields, as `name:type` separated by white space."""
    factories: Mapping[str, Callable[[], Any]] = field(default_factory=dict)
    """Attributes that are not written (process-specific or derived), with factories for their values after reading."""
    after_read: Callable[[Any], object] | None = None
    """Called with each object after all are read and checked."""
    is_consistent: Callable[[Any], bool] | None = None
    """Consistency check of an object; called after all fields were checked."""

    @property
    def names(self) -> tuple[str, ...]:
        """The field names, in order."""
        return tuple(word.partition(":")[0] for word in self.schema.split())

    def types(self) -> dict[str, Type]:
        """Return the fields and their types."""
        return {name: parse_type(text) for name, _, text in (word.partition(":") for word in self.schema.split())}


def no_value() -> None:
    """Factory for process-specific attributes: None."""


_WORDS: Final = re.compile(r"[\w.-]+|[][|,()*~]")


def parse_type(text: str) -> Type:
    """Parse a type; ValueError if it is invalid."""
    words = _WORDS.findall(text)
    if "".join(words) != text:
        raise ValueError(f"{text!r} is not a type")
    found = _parse_union(words)
    if words:
        raise ValueError(f"{text!r} is not a type: {words[0]!r} is unexpected")
    return found


def _parse_union(words: list[str]) -> Type:
    found = [_parse_one(words)]
    while words and words[0] == "|":
        words.pop(0)
        found.append(_parse_one(words))
    return found[0] if len(found) == 1 else Type("|", tuple(found))


def _parse_one(words: list[str]) -> Type:
    word, finds, inside = words.pop(0), "", []
    if words and words[0] == "(":
        finds = words[1]
        del words[:3]
    signs = ""
    while words and words[0] in "*~":
        signs += words.pop(0)
    if words and words[0] == "[":
        words.pop(0)
        while words[0] != "]":
            inside.append(_parse_union(words))
            if words[0] == ",":
                words.pop(0)
        words.pop(0)
    return Type(word, tuple(inside), finds, "*" in signs, "~" in signs)
