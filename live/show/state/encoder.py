"""Encoder that turns a captured state into bytes, outside of the frame loop.

Immutable values (numbers, texts, frozen kinds, tuples of such) are only referenced when a state is captured; they are
encoded here.
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
"""Type words of immutable values."""
_NUMBERS: Final = (np.float64, np.float32, np.int64, np.int32, np.bool_)

Values = tuple[Any, ...]


class Unwritable(Exception):
    """A show holds something that a snapshot cannot hold; the message names it."""


class Shape:
    """Capture plan for objects of one kind: its plain fields, its immutable fields, and all others (links)."""

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
    """The encoded part of an object that stays valid as long as its links are the same."""

    number: int
    value: Any
    shape: Shape
    links: list[Any]
    dynamic: tuple[int, ...]
    """Indices of the links to containers; these are encoded again in each cut."""
    rows: Rows
    """Rows of its arrays."""
    contents: list[int]
    """Numbers of the arrays whose contents are part of each cut."""


Cut = tuple[Part, Values, list[Any], list[bytes]]
"""A captured object: its part, its plain and immutable values, its encoded containers, its array contents."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A captured state; immutable."""

    objects: list[Cut]
    rows: Rows
    """Rows of containers and of arrays in them; they may hold immutable values unencoded."""
    content: dict[int, bytes]
    """Contents of these arrays, by row number."""
    root: Any
    names: Mapping[int, str]
    """Names of constants, by object id."""
    last: int
    """The highest row number."""

    def packed(self) -> bytes:
        """Return the state in the format of `byte_format.py`; Unwritable for objects of unknown kinds. Thread: any
        one."""
        return _Packing(self).packed()


class _Packing:
    """Encoding of one state."""

    def __init__(self, written: Written) -> None:
        self._written, self._names = written, written.names
        self._last = written.last
        self._kinds: dict[type, int] = {}
        self._rows: Rows = {}
        self._memo: dict[int, list[Any]] = {}
        """Encoded immutable values by id; the state keeps them alive."""

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
        """Return the row of an object without its links."""
        number, many = self._kinds.setdefault(shape.kind.cls, len(self._kinds)), shape.many_plain
        row: Row = [number, values[:many], *[None] * (len(shape.fixed_at) + len(shape.links_at))]
        for place, each in zip(shape.fixed_at, values[many:], strict=True):
            row[2 + place] = self._said(each)
        return row

    def _said(self, value: Any) -> Any:
        cls = type(value)
        if cls in PLAIN:
            return value
        if cls is list:  # an encoded value; only its items may need encoding
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
            raise Unwritable(f"{cls.__module__}.{cls.__qualname__} is mutable, where only immutable values may be")
        if issubclass(cls, Enum):
            return [VALUE, kind.name, value.value]
        shape = shape_of(kind)
        self._last += 1
        number = self._last
        self._rows[number] = self._row(shape, shape.values(value))
        return [number]


@cache
def split_names(kind: Kind) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the fields of a kind in the order of writing: plain values, and all others."""
    types = kind.types()
    plain = tuple(name for name, found in types.items() if _is_plain(found))
    return plain, tuple(name for name in types if name not in plain)


@cache
def shape_of(kind: Kind) -> Shape:
    """Return the capture plan of a kind."""
    return Shape(kind)


@cache
def is_fixed(kind: Kind) -> bool:
    """Whether objects of this kind, and all they hold, are immutable."""
    if issubclass(kind.cls, Enum):
        return True
    parameters = getattr(kind.cls, "__dataclass_params__", None)
    return parameters is not None and parameters.frozen and all(_is_fixed(kind_of) for kind_of in kind.types().values())


def values_of(names: tuple[str, ...]) -> Callable[[Any], Values]:
    """Return a function that reads the values of these fields from an object."""
    if len(names) > 1:
        return attrgetter(*names)
    return (lambda value: (getattr(value, names[0]),)) if names else (lambda value: ())


def _is_plain(found: Type) -> bool:
    """Whether a type is a plain value, or a tuple of such."""
    return (found.word in _PLAIN or found.word in ("|", "tuple", "row")) and all(map(_is_plain, found.of))


def _is_fixed(found: Type) -> bool:
    known = BY_NAME.get(found.word)
    return (is_fixed(known) if known is not None else found.word in _FIXED) and all(map(_is_fixed, found.of))


def _checked(kind: Kind) -> Callable[[Any], None]:
    """Return a function that raises Unwritable for an object with an unlisted field."""
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
"""Classes of immutable values; these are referenced until the state is packed."""
