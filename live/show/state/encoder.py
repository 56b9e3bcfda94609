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

from live.show.state.byte_format import ARRAY, ARRAY_LAYOUT, HEAD, VALUE, Row, Rows, encode_tree
from live.show.state.kind import PLAIN, Kind, Type
from live.show.state.kinds import BY_CLASS, BY_NAME

_PLAIN: Final = frozenset({"int", "float", "bool", "str", "none", "bytes"})
_IMMUTABLE: Final = frozenset({*_PLAIN, "complex", "tuple", "row", "frozenset", "|"})
"""Type words of immutable values."""
_NUMBERS: Final = (np.float64, np.float32, np.int64, np.int32, np.bool_)

Values = tuple[Any, ...]


class StateEncodeError(Exception):
    """A show holds something that a snapshot cannot hold; the message names it."""


class CapturePlan:
    """Capture plan for objects of one kind: its plain fields, its immutable fields, and all others (links)."""

    __slots__ = ("check", "immutable_at", "kind", "links", "links_at", "many_plain", "values")

    def __init__(self, kind: Kind) -> None:
        plain, others = split_fields(kind)
        types = kind.types()
        fixed = tuple(name for name in others if _is_immutable(types[name]))
        links = tuple(name for name in others if name not in fixed)
        self.kind, self.check, self.many_plain = kind, _field_check(kind), len(plain)
        self.values, self.links = values_getter(plain + fixed), values_getter(links)
        self.immutable_at = tuple(map(others.index, fixed))
        self.links_at = tuple(map(others.index, links))


@dataclass(frozen=True, slots=True, eq=False)
class EncodedLinks:
    """The encoded part of an object that stays valid as long as its links are the same."""

    number: int
    value: Any
    shape: CapturePlan
    links: list[Any]
    dynamic: tuple[int, ...]
    """Indices of the links to containers; these are encoded again in each cut."""
    rows: Rows
    """Rows of its arrays."""
    contents: list[int]
    """Numbers of the arrays whose contents are part of each cut."""


CapturedObject = tuple[EncodedLinks, Values, list[Any], list[bytes]]
"""A captured object: its part, its plain and immutable values, its encoded containers, its array contents."""


@dataclass(frozen=True, slots=True, eq=False)
class CapturedState:
    """A captured state; immutable."""

    objects: list[CapturedObject]
    rows: Rows
    """Rows of containers and of arrays in them; they may hold immutable values unencoded."""
    content: dict[int, bytes]
    """Contents of these arrays, by row number."""
    root: Any
    names: Mapping[int, str]
    """Names of constants, by object id."""
    last: int
    """The highest row number."""

    def encode(self) -> bytes:
        """Return the state in the format of `byte_format.py`; Unwritable for objects of unknown kinds. Thread: any
        one."""
        return _Encoder(self).encode()


class _Encoder:
    """Encoding of one state."""

    def __init__(self, written: CapturedState) -> None:
        self._written, self._names = written, written.names
        self._last = written.last
        self._kinds: dict[type, int] = {}
        self._rows: Rows = {}
        self._memo: dict[int, list[Any]] = {}
        """Encoded immutable values by id; the state keeps them alive."""

    def encode(self) -> bytes:
        said, written = self._encode, self._written
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
            number: [kind.name, *split_fields(kind)] for cls, number in self._kinds.items() for kind in [BY_CLASS[cls]]
        }
        contents = [content[number] for number, row in self._rows.items() if row[0] in (ARRAY, ARRAY_LAYOUT)]
        tree = encode_tree([kinds, self._rows, list(map(len, contents)), root])
        return b"".join((HEAD.pack(len(tree)), tree, *contents))

    def _row(self, shape: CapturePlan, values: Values) -> Row:
        """Return the row of an object without its links."""
        number, many = self._kinds.setdefault(shape.kind.cls, len(self._kinds)), shape.many_plain
        row: Row = [number, values[:many], *[None] * (len(shape.immutable_at) + len(shape.links_at))]
        for place, each in zip(shape.immutable_at, values[many:], strict=True):
            row[2 + place] = self._encode(each)
        return row

    def _encode(self, value: Any) -> Any:
        cls = type(value)
        if cls in PLAIN:
            return value
        if cls is list:  # an encoded value; only its items may need encoding
            return [each if type(each) in PLAIN else self._encode(each) for each in value]
        if cls is tuple:
            return [None, *[each if type(each) in PLAIN else self._encode(each) for each in value]]
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
        if kind is None or not is_immutable(kind):
            raise StateEncodeError(
                f"{cls.__module__}.{cls.__qualname__} is mutable, where only immutable values may be"
            )
        if issubclass(cls, Enum):
            return [VALUE, kind.name, value.value]
        shape = capture_plan(kind)
        self._last += 1
        number = self._last
        self._rows[number] = self._row(shape, shape.values(value))
        return [number]


@cache
def split_fields(kind: Kind) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the fields of a kind in the order of writing: plain values, and all others."""
    types = kind.types()
    plain = tuple(name for name, found in types.items() if _is_plain(found))
    return plain, tuple(name for name in types if name not in plain)


@cache
def capture_plan(kind: Kind) -> CapturePlan:
    """Return the capture plan of a kind."""
    return CapturePlan(kind)


@cache
def is_immutable(kind: Kind) -> bool:
    """Whether objects of this kind, and all they hold, are immutable."""
    if issubclass(kind.cls, Enum):
        return True
    parameters = getattr(kind.cls, "__dataclass_params__", None)
    return (
        parameters is not None
        and parameters.frozen
        and all(_is_immutable(kind_of, kind) for kind_of in kind.types().values())
    )


def values_getter(names: tuple[str, ...]) -> Callable[[Any], Values]:
    """Return a function that reads the values of these fields from an object."""
    if len(names) > 1:
        return attrgetter(*names)
    return (lambda value: (getattr(value, names[0]),)) if names else (lambda value: ())


def _is_plain(found: Type) -> bool:
    """Whether a type is a plain value, or a tuple of such."""
    return (found.word in _PLAIN or found.word in ("|", "tuple", "row")) and all(map(_is_plain, found.items))


def _is_immutable(found: Type, within: Kind | None = None) -> bool:
    """Whether a type is immutable, if the kind `within` whose field it is, which may hold others of its own, is."""
    known = BY_NAME.get(found.word)
    if known is None:
        fixed = found.word in _IMMUTABLE
    else:
        fixed = known is within or is_immutable(known)
    return fixed and all(_is_immutable(item, within) for item in found.items)


def _field_check(kind: Kind) -> Callable[[Any], None]:
    """Return a function that raises Unwritable for an object with an unlisted field."""
    if not kind.cls.__dictoffset__:
        return lambda value: None
    known = frozenset((*kind.names, *kind.factories))

    def check(value: Any) -> None:
        if not known.issuperset(value.__dict__):
            missing = ", ".join(sorted(set(value.__dict__) - known))
            raise StateEncodeError(
                f"the field {missing} of {kind.cls.__qualname__} is not listed in its kind {kind.name!r}"
            )

    return check


IMMUTABLE_CLASSES: Final = frozenset(
    {*PLAIN, complex, *_NUMBERS, *(kind.cls for kind in BY_NAME.values() if is_immutable(kind))}
)
"""Classes of immutable values; these are referenced until the state is packed."""
