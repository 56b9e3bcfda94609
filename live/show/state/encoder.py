"""Packing: a state that was taken within a frame becomes bytes, by whoever has time for it.

What nobody can change (numbers, texts, frozen kinds, tuples of such) is only held when a state is taken; it is written
here.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from operator import attrgetter
from typing import Any, Final

import numpy as np

from live.show.state.byte_format import HEAD, LAID, VALUE, WHOLE, Row, Rows, packed_tree
from live.show.state.kind import PLAIN, Kind, Type
from live.show.state.kinds import BY_CLASS, BY_NAME

_PLAIN: Final = frozenset({"int", "float", "bool", "str", "none", "bytes"})
_FIXED: Final = frozenset({*_PLAIN, "complex", "tuple", "row", "frozenset", "|"})
"""What nobody changes."""
_NUMBERS: Final = (np.float64, np.float32, np.int64, np.int32, np.bool_)

Values = tuple[Any, ...]


class Unwritable(Exception):
    """A show holds what no snapshot can hold; the message names it."""


class Shape:
    """How objects of one kind are taken: which of their fields are plain, which nobody changes, and all others."""

    __slots__ = ("check", "fixed_at", "kind", "links", "links_at", "many_plain", "values")

    def __init__(self, kind: Kind) -> None:
        plain, others = split_names(kind)
        types = kind.types()
        fixed = tuple(name for name in others if _is_fixed(types[name]))
        links = tuple(name for name in others if name not in fixed)
        self.kind, self.check, self.many_plain = kind, _checked(kind), len(plain)
        self.values, self.links = values_of(plain + fixed), values_of(links)
        self.fixed_at = tuple(map(others.index, fixed))
        self.links_at = tuple(map(others.index, links))


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What is written of an object as long as its links are the same."""

    number: int
    value: Any
    shape: Shape
    links: list[Any]
    dynamic: tuple[int, ...]
    """The places of links to containers: what is written of these comes with each cut."""
    rows: Rows
    """Of its arrays."""
    contents: list[int]
    """The numbers of the arrays whose contents come with each cut."""


Cut = tuple[Part, Values, list[Any], list[bytes]]
"""An object as it was taken: its part, its plain and fixed values, what is written of its containers, its arrays."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A state as it was taken: nobody changes anything in it any more."""

    objects: list[Cut]
    rows: Rows
    """Of containers and of arrays in these. They may hold, as it is, what nobody changes."""
    content: dict[int, bytes]
    """What is in these arrays, by the numbers of their rows."""
    root: Any
    names: Mapping[int, str]
    """Of constants, by their ids."""
    last: int
    """The highest number of a row."""

    def packed(self) -> bytes:
        """As `form.py` says; Unwritable for what is in no list of kinds. Thread: any one."""
        return _Packing(self).packed()


class _Packing:
    """One state on its way to bytes."""

    def __init__(self, written: Written) -> None:
        self._written, self._names = written, written.names
        self._last = written.last
        self._kinds: dict[type, int] = {}
        self._rows: Rows = {}
        self._memo: dict[int, list[Any]] = {}
        """What is written of values that nobody changes, by their ids: the state holds them meanwhile."""

    def packed(self) -> bytes:
        said, written = self._said, self._written
        rows, content = written.rows.copy(), written.content.copy()
        for part, values, containers, arrays in written.objects:
            part.shape.check(part.value)
            rows |= part.rows
            content |= zip(part.contents, arrays, strict=True)
            row = self._rows[part.number] = self._row(part.shape, values)
            for place, each in zip(part.shape.links_at, part.links, strict=True):
                row[2 + place] = said(each)
            for place, each in zip(part.dynamic, containers, strict=True):
                row[2 + part.shape.links_at[place]] = said(each)
        for number, found in rows.items():
            self._rows[number] = [said(each) for each in found]
        root = said(written.root)
        kinds = {
            number: [kind.name, *split_names(kind)] for cls, number in self._kinds.items() for kind in [BY_CLASS[cls]]
        }
        contents = [content[number] for number, row in self._rows.items() if row[0] in (WHOLE, LAID)]
        tree = packed_tree([kinds, self._rows, list(map(len, contents)), root])
        return b"".join((HEAD.pack(len(tree)), tree, *contents))

    def _row(self, shape: Shape, values: Values) -> Row:
        """The row of an object, but for its links."""
        number, many = self._kinds.setdefault(shape.kind.cls, len(self._kinds)), shape.many_plain
        row: Row = [number, values[:many], *[None] * (len(shape.fixed_at) + len(shape.links_at))]
        for place, each in zip(shape.fixed_at, values[many:], strict=True):
            row[2 + place] = self._said(each)
        return row

    def _said(self, value: Any) -> Any:
        cls = type(value)
        if cls in PLAIN:
            return value
        if cls is list:  # is written as it is, but for what is in it
            return [each if type(each) in PLAIN else self._said(each) for each in value]
        if cls is tuple:
            return [None, *[each if type(each) in PLAIN else self._said(each) for each in value]]
        key = id(value)
        found = self._memo.get(key)
        if found is None:
            found = self._memo[key] = self._new(value, cls)
        return found

    def _new(self, value: Any, cls: type) -> list[Any]:
        name = self._names.get(id(value))
        if name is not None:
            return [name]
        if cls is frozenset and PLAIN.issuperset(map(type, value)):
            return [VALUE, "frozenset", *value]
        if cls is complex:
            return [VALUE, "complex", value.real, value.imag]
        if cls in _NUMBERS:
            return [VALUE, value.dtype.str[1:], value.item()]
        kind = BY_CLASS.get(cls)
        if kind is None or not is_fixed(kind):
            raise Unwritable(f"{cls.__module__}.{cls.__qualname__} stands where nothing that changes can stand")
        if issubclass(cls, Enum):
            return [VALUE, kind.name, value.value]
        shape = shape_of(kind)
        self._last += 1
        number = self._last
        self._rows[number] = self._row(shape, shape.values(value))
        return [number]


@cache
def split_names(kind: Kind) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The fields of a kind in the order in which they are written: plain values, and all others."""
    types = kind.types()
    plain = tuple(name for name, found in types.items() if _is_plain(found))
    return plain, tuple(name for name in types if name not in plain)


@cache
def shape_of(kind: Kind) -> Shape:
    """How objects of a kind are taken."""
    return Shape(kind)


@cache
def is_fixed(kind: Kind) -> bool:
    """Whether nobody can change an object of this kind, nor what it holds."""
    if issubclass(kind.cls, Enum):
        return True
    parameters = getattr(kind.cls, "__dataclass_params__", None)
    return parameters is not None and parameters.frozen and all(_is_fixed(kind_of) for kind_of in kind.types().values())


def values_of(names: tuple[str, ...]) -> Callable[[Any], Values]:
    """What takes the values of these fields out of an object at once."""
    if len(names) > 1:
        return attrgetter(*names)
    return (lambda value: (getattr(value, names[0]),)) if names else (lambda value: ())


def _is_plain(found: Type) -> bool:
    """Whether it is a plain value, or a tuple of such."""
    return (found.word in _PLAIN or found.word in ("|", "tuple", "row")) and all(map(_is_plain, found.of))


def _is_fixed(found: Type) -> bool:
    known = BY_NAME.get(found.word)
    return (is_fixed(known) if known is not None else found.word in _FIXED) and all(map(_is_fixed, found.of))


def _checked(kind: Kind) -> Callable[[Any], None]:
    """Raises Unwritable for an object that holds a field that is not listed."""
    if not kind.cls.__dictoffset__:
        return lambda value: None
    known = frozenset((*kind.names, *kind.anew))

    def check(value: Any) -> None:
        if not known.issuperset(value.__dict__):
            missing = ", ".join(sorted(set(value.__dict__) - known))
            raise Unwritable(f"the field {missing} of {kind.cls.__qualname__} is not listed in its kind {kind.name!r}")

    return check


FIXED_CLASSES: Final = frozenset(
    {*PLAIN, complex, *_NUMBERS, *(kind.cls for kind in BY_NAME.values() if is_fixed(kind))}
)
"""Classes of what nobody changes: such a value is held until the state is packed."""
