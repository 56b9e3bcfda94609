"""Kind: what a snapshot holds of objects of one class: the name of the kind, and its fields with their types.

A kind's name is its own: neither a module nor a class, so that code may move while old snapshots stay readable. Types
are written in a few words:

    int float bool str none complex any     a value; a float may be a whole number
    f4 f8 i1 i4 i8 u1 u4 u8 b1 c16 array    an array of these numbers (`array`: of any)
    list[T] set[T] frozenset[T] deque[T]    containers
    dict[K,V] ordered[K,V] counter[K]
    tuple[T,U] row[T]                       a tuple of so many values, of any number of them
    method event                            a bound method that is listed in `methods`, an event of `live.control`
    any other word                          an object of the kind (or of one of the kinds) of this name
    T|U                                     either

An array has the shape that it has in a fresh show; `f4*` may have any. `i4(node)` holds indices of nodes: what a kernel
finds something by is checked against how many there are. Numbers of arrays are finite, and no farther from 0 than
`FARTHEST`; those of `f4~` may be any.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

NUMBERS: Final = {
    "f4": "<f4", "f8": "<f8", "i1": "|i1", "i4": "<i4", "i8": "<i8", "u1": "|u1", "u4": "<u4", "u8": "<u8",
    "b1": "|b1", "c16": "<c16",
}  # fmt: skip
"""Arrays by the word for what is in them, as numpy calls it."""

FARTHEST: Final = 1e9
"""No number of an array is farther from 0: as a whole one of 32 bits it is still itself."""

PLAIN: Final = frozenset({type(None), bool, int, float, str, bytes})
"""Classes of values that are written as they are."""


@dataclass(frozen=True, slots=True)
class Type:
    """What a field may hold: the word, what is in it, what its numbers find, whether an array may have any shape, and
    hold any number."""

    word: str
    of: tuple["Type", ...] = ()
    finds: str = ""
    any_shape: bool = False
    any_number: bool = False

    @property
    def either(self) -> tuple["Type", ...]:
        """The types of which it is one."""
        return self.of if self.word == "|" else (self,)

    @property
    def is_loose(self) -> bool:
        """Whether an array in it may have any shape."""
        return self.any_shape or any(each.is_loose for each in self.of)

    def __str__(self) -> str:
        if self.word == "|":
            return "|".join(map(str, self.of))
        inside = f"[{','.join(map(str, self.of))}]" if self.of or self.word == "tuple" else ""
        return f"{self.word}{f'({self.finds})' if self.finds else ''}{'*' if self.any_shape else ''}{inside}"


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """What is written of objects of one class."""

    name: str
    cls: type
    words: str
    """The fields: `name:type`, with blanks between them."""
    anew: Mapping[str, Callable[[], Any]] = field(default_factory=dict)
    """Attributes that are not written: of the process, or made of the others. A read object has these."""
    after: Callable[[Any], object] | None = None
    """Called with each object once all are read and checked."""
    whole: Callable[[Any], bool] | None = None
    """Whether what an object holds fits together; asked after all fields were checked."""

    @property
    def names(self) -> tuple[str, ...]:
        """The fields, in their order."""
        return tuple(word.partition(":")[0] for word in self.words.split())

    def types(self) -> dict[str, Type]:
        """The fields and what they may hold."""
        return {name: type_of(text) for name, _, text in (word.partition(":") for word in self.words.split())}


def nothing() -> None:
    """The value of an attribute that belongs to the process."""


_WORDS: Final = re.compile(r"[\w.-]+|[][|,()*~]")


def type_of(text: str) -> Type:
    """A type from its words; ValueError if they are none."""
    words = _WORDS.findall(text)
    if "".join(words) != text:
        raise ValueError(f"{text!r} is no type")
    found = _either(words)
    if words:
        raise ValueError(f"{text!r} is no type: {words[0]!r} is too much")
    return found


def _either(words: list[str]) -> Type:
    found = [_one(words)]
    while words and words[0] == "|":
        words.pop(0)
        found.append(_one(words))
    return found[0] if len(found) == 1 else Type("|", tuple(found))


def _one(words: list[str]) -> Type:
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
            inside.append(_either(words))
            if words[0] == ",":
                words.pop(0)
        words.pop(0)
    return Type(word, tuple(inside), finds, "*" in signs, "~" in signs)
