"""Writing a state: within a frame all values are taken, so that nothing that happens later changes them.

What is taken is a table of rows, one for each object, container and array, by number; see `form.py`.
"""

from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cache, partial
from operator import attrgetter, is_
from types import MethodType
from typing import Any, Final

import numpy as np

from live.show.state.constants import Constants
from live.show.state.form import (
    COUNTER,
    DEQUE,
    DICT,
    HEAD,
    LAID,
    LIST,
    METHOD,
    ORDERED,
    PART,
    SCRATCH,
    SET,
    VALUE,
    WHOLE,
    Row,
    Rows,
    packed_tree,
)  # fmt: skip
from live.show.state.kind import PLAIN, Kind, Type
from live.show.state.kinds import BY_CLASS, BY_NAME, METHODS

Encode = Callable[[Any], list[Any]]

LARGE: Final = 1 << 15
"""Bytes from which on it is worth looking for zeros at the end of an array: looking is quicker than copying."""
LEAST: Final = 64
"""Words that are always copied."""
_PLAIN: Final = frozenset({"int", "float", "bool", "str", "none", "bytes"})
_FIXED: Final = frozenset({"int", "float", "bool", "str", "none", "complex", "tuple", "row", "frozenset", "|"})
"""What nobody changes."""


class Unwritable(Exception):
    """A show holds what no snapshot can hold; the message names it."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A state as it was taken: nobody changes anything in it any more."""

    kinds: list[Kind]
    """Those that rows are of, by number."""
    rows: Rows
    content: dict[int, bytes]
    """What is in arrays, by the numbers of their rows."""
    root: Any

    def packed(self) -> bytes:
        """As `form.py` says. Thread: any one."""
        used = {row[0] for row in self.rows.values() if row[0] >= 0}
        kinds = {number: [self.kinds[number].name, *split_names(self.kinds[number])] for number in used}
        numbers = [number for number, row in self.rows.items() if row[0] in (WHOLE, LAID)]
        content = [self.content[number] for number in numbers]
        tree = packed_tree([kinds, self.rows, list(map(len, content)), self.root])
        return b"".join((HEAD.pack(len(tree)), tree, *content))


class _Array:
    """What is remembered of an array: its number, the rows and contents that it needs, and who remembers it."""

    __slots__ = ("contents", "number", "pins", "ref", "rows", "turn", "value")

    def __init__(self, value: Any, number: int) -> None:
        self.value, self.number = value, number
        self.ref: list[Any] = [number]
        self.rows: Rows = {}
        self.contents: list[tuple[int, Callable[[], bytes]]] = []
        self.pins = self.turn = 0


_Value = tuple[Any, list[int], Rows]
"""A value that nobody changes, its number, and all rows that it needs."""


class _Shape:
    """How objects of one kind are taken: what takes their plain values, and all others."""

    __slots__ = ("check", "fixed", "links", "number", "plain")

    def __init__(self, number: int, kind: Kind) -> None:
        plain, others = split_names(kind)
        types = kind.types()
        self.fixed = [_is_fixed(types[name]) for name in others]
        """Whether nobody changes what a field holds, a tuple too."""
        self.number, self.plain, self.links, self.check = number, values_of(plain), values_of(others), _checked(kind)


class _Object:
    """What is remembered of an object: what it holds beside plain values, and what is written of that."""

    __slots__ = ("arrays", "children", "contents", "dynamic", "held", "ref", "rows", "said", "shape", "turn", "value")

    def __init__(self, value: Any, number: int, shape: _Shape) -> None:
        self.value, self.shape, self.ref = value, shape, [number]
        self.held: tuple[Any, ...] | None = None
        self.said: list[Any] = []
        """What is written of each, as long as it is the same; of containers, at the places `dynamic`, nothing."""
        self.dynamic: list[int] = []
        self.children: list[_Object] = []
        self.arrays: list[_Array] = []
        self.rows: Rows = {}
        self.contents: list[tuple[int, Callable[[], bytes]]] = []
        self.turn = 0


class StateWriter:
    """Takes the state of one show again and again. Thread: the show's.

    It runs within a frame. What an object holds is mostly the very same as last time: then its arrays are only copied,
    what is plain by its type is taken as it is, and only containers are looked through.
    """

    def __init__(self, constants: Constants) -> None:
        self._constants = constants
        self._names, self._scratch = constants.name_of, constants.scratch_of
        self._kinds = list(BY_CLASS.values())
        self._number_of = {kind.cls: number for number, kind in enumerate(self._kinds)}
        self._shapes = {cls: _Shape(number, self._kinds[number]) for cls, number in self._number_of.items()}
        self._encoders = _Encoders(self.encoder)
        self._objects: dict[int, _Object] = {}
        self._arrays: dict[int, _Array] = {}
        self._values: dict[int, _Value] = {}
        self._values_before: dict[int, _Value] = {}
        self._last = self._turn = self._many = 0
        self._memo: dict[int, list[Any]] = {}
        self._queue: list[_Object] = []
        self._rows: Rows = {}
        self._content: dict[int, bytes] = {}

    def write(self, root: Any) -> Written:
        """Take `root` and all that it holds; Unwritable for what is in no list of kinds."""
        self._turn += 1
        self._values_before, self._values = self._values, {}
        self._memo, self._queue, self._rows, self._content = {}, [], {}, {}
        found = self._ref(root)
        self._take()
        self._forget()
        return Written(self._kinds, self._rows, self._content, found)

    def _take(self) -> None:
        """Take all objects that are asked for, and what that asks for."""
        turn, queue, rows, content = self._turn, self._queue, self._rows, self._content
        for known in queue:
            value, shape = known.value, known.shape
            shape.check(value)
            held = shape.links(value)
            if known.held is None or not all(map(is_, held, known.held)):
                self._look(known, held)
            row = [shape.number, shape.plain(value), *known.said]
            for place in known.dynamic:
                row[2 + place] = self._ref(held[place])
            rows[known.ref[0]] = row
            if known.rows:
                rows.update(known.rows)
                for number, read in known.contents:
                    content[number] = read()
            for child in known.children:
                if child.turn != turn:
                    child.turn = turn
                    queue.append(child)

    def _look(self, known: _Object, held: tuple[Any, ...]) -> None:
        """What an object holds has changed: say anew what is written of it."""
        before = known.arrays
        known.said, known.dynamic, known.children, known.arrays = [], [], [], []
        known.rows = {}
        contents: dict[int, Callable[[], bytes]] = {}
        for place, value in enumerate(held):
            cls = type(value)
            if cls is np.ndarray:
                array = self._known(value)
                array.pins += 1
                known.arrays.append(array)
                known.rows.update(array.rows)
                contents.update(array.contents)
                known.said.append(array.ref)
            elif cls in PLAIN:
                known.said.append(value)
            elif cls is tuple and known.shape.fixed[place]:
                known.said.append(self._fixed(value, known.rows))
            elif cls in _CONTAINERS:
                known.dynamic.append(place)
                known.said.append(None)
            else:
                known.said.append(self._said(value, known))
        known.held, known.contents = held, list(contents.items())
        for array in before:
            array.pins -= 1

    def _said(self, value: Any, known: _Object) -> list[Any]:
        cls = type(value)
        kind = BY_CLASS.get(cls)
        name = self._names.get(id(value)) if cls in self._constants.classes or kind is None else None
        if name is not None:
            return [name]
        if kind is not None and issubclass(cls, Enum):
            return [VALUE, kind.name, value.value]
        if kind is not None and is_fixed(kind) and cls not in self._constants.classes:
            _, ref, rows = self._value(value, kind)
            known.rows.update(rows)
            return ref
        child = self._object(value)
        known.children.append(child)
        return child.ref

    def _object(self, value: Any) -> _Object:
        known = self._objects.get(id(value))
        if known is None or known.value is not value:
            shape = self._shapes.get(type(value))
            if shape is None:
                raise Unwritable(
                    f"{type(value).__module__}.{type(value).__qualname__} is of no kind that a state holds"
                )
            self._last += 1
            known = self._objects[id(value)] = _Object(value, self._last, shape)
        return known

    def _forget(self) -> None:
        """Forget objects and arrays that nobody holds any more, once there are many."""
        if len(self._objects) + len(self._arrays) <= 2 * self._many + 256:
            return
        for key, known in list(self._objects.items()):
            if known.turn != self._turn:
                del self._objects[key]
                for array in known.arrays:
                    array.pins -= 1
        for key, array in list(self._arrays.items()):
            if not array.pins and array.turn != self._turn:
                del self._arrays[key]
        self._many = len(self._objects) + len(self._arrays)

    def _ref(self, value: Any) -> Any:
        if type(value) in PLAIN:
            return value
        found = self._memo.get(id(value))
        return self._encoders[type(value)](value) if found is None else found

    def _refs(self, values: Collection[Any]) -> Iterable[Any]:
        if PLAIN.issuperset(map(type, values)):
            return values
        return [each if type(each) in PLAIN else self._ref(each) for each in values]

    # -- how what containers hold is taken -----------------------------------------------------------------------

    def encoder(self, cls: type) -> Encode:
        """What takes objects of this class."""
        if cls in _CONTAINERS:
            found: Encode = getattr(self, _CONTAINERS[cls])
            return found
        if cls is np.ndarray:
            return self._array
        kind = BY_CLASS.get(cls)
        if kind is not None and issubclass(cls, Enum):
            return lambda value: [VALUE, kind.name, value.value]
        named = cls in self._constants.classes or kind is None
        fixed = kind is not None and is_fixed(kind) and not named
        encode = self._fixed_encoder(kind) if kind is not None and fixed else self._queued
        return self._named(encode) if named else encode

    def _named(self, encode: Encode) -> Encode:
        names = self._names

        def named(value: Any) -> list[Any]:
            name = names.get(id(value))
            return encode(value) if name is None else [name]

        return named

    def _queued(self, value: Any) -> list[Any]:
        known = self._object(value)
        if known.turn != self._turn:
            known.turn = self._turn
            self._queue.append(known)
        return known.ref

    def _fixed_encoder(self, kind: Kind) -> Encode:
        """Values that nobody changes are taken once, and written again as long as somebody holds them."""

        def encode(value: Any) -> list[Any]:
            _, ref, rows = self._value(value, kind)
            self._memo[id(value)] = ref
            self._rows.update(rows)
            return ref

        return encode

    def _value(self, value: Any, kind: Kind) -> _Value:
        key = id(value)
        known = self._values.get(key)
        if known is None:
            known = self._values_before.get(key)
            if known is None:
                self._last += 1
                shape = self._shapes[kind.cls]
                row: Row = [shape.number, shape.plain(value)]
                known = value, [self._last], {self._last: row}
                row += [self._fixed(each, known[2]) for each in shape.links(value)]
            self._values[key] = known
        return known

    def _fixed(self, value: Any, rows: Rows) -> Any:
        """What a value that nobody changes holds; the rows of more such values go to `rows`."""
        cls = type(value)
        if cls in PLAIN:
            return value
        if cls is tuple:
            return [None, *[self._fixed(each, rows) for each in value]]
        kind = BY_CLASS.get(cls)
        if kind is None or issubclass(cls, Enum) or id(value) in self._names:
            return self._encoders[cls](value)
        _, ref, more = self._value(value, kind)
        rows.update(more)
        return ref

    def _method(self, value: MethodType) -> list[Any]:
        owner, name = value.__self__, value.__func__.__name__
        kind = BY_CLASS.get(type(owner))
        if kind is None or (kind.name, name) not in METHODS:
            raise Unwritable(f"the method {type(owner).__name__}.{name} is none that a state holds")
        return [METHOD, self._ref(owner), name]

    def _number(self, value: Any) -> list[Any]:
        return [VALUE, value.dtype.str[1:], value.item()]

    def _complex(self, value: complex) -> list[Any]:
        return [VALUE, "complex", value.real, value.imag]

    def _frozenset(self, value: frozenset[Any]) -> list[Any]:
        if not PLAIN.issuperset(map(type, value)):
            raise Unwritable("a frozenset of what is no plain value is nothing that a state holds")
        return [VALUE, "frozenset", *value]

    def _tuple(self, value: tuple[Any, ...]) -> list[Any]:
        return [None, *self._refs(value)]

    def _begin(self, value: Any, row: Row) -> list[Any]:
        number = -1 - len(self._memo)
        ref = self._memo[id(value)] = [number]
        self._rows[number] = row
        return ref

    def _list(self, value: list[Any]) -> list[Any]:
        row: Row = [LIST]
        found = self._begin(value, row)
        row += self._refs(value)
        return found

    def _set(self, value: set[Any]) -> list[Any]:
        row: Row = [SET]
        found = self._begin(value, row)
        row += self._refs(value)
        return found

    def _deque(self, value: deque[Any]) -> list[Any]:
        row: Row = [DEQUE, value.maxlen]
        found = self._begin(value, row)
        row += self._refs(value)
        return found

    def _dict(self, value: dict[Any, Any], code: int = DICT) -> list[Any]:
        row: Row = [code]
        found, ref = self._begin(value, row), self._ref
        for key, each in value.items():
            row.append(key if type(key) in PLAIN else ref(key))
            row.append(each if type(each) in PLAIN else ref(each))
        return found

    def _ordered(self, value: OrderedDict[Any, Any]) -> list[Any]:
        return self._dict(value, ORDERED)

    def _counter(self, value: Counter[Any]) -> list[Any]:
        return self._dict(value, COUNTER)

    # -- arrays -------------------------------------------------------------------------------------------------

    def _array(self, value: Any) -> list[Any]:
        known = self._known(value)
        self._rows.update(known.rows)
        for number, read in known.contents:
            self._content[number] = read()
        return known.ref

    def _known(self, value: Any) -> _Array:
        known = self._arrays.get(id(value))
        if known is None or known.value is not value:
            self._last += 1
            known = self._arrays[id(value)] = _Array(value, self._last)
            self._describe(known, value)
        known.turn = self._turn
        return known

    def _describe(self, known: _Array, value: Any) -> None:
        """How it is written: its name, or its row and what reads its content; those of what it is a part of, too."""
        name = self._names.get(id(value))
        if name is not None:
            known.ref = [name]
            return
        if value.dtype.hasobject:
            raise Unwritable("an array of objects is nothing that a state holds")
        name = self._scratch.get(id(value))
        if name is not None:
            known.rows[known.number] = [SCRATCH, name]
            return
        base, numbers = value.base, value.dtype.str
        if isinstance(base, np.ndarray) and base.flags.c_contiguous:
            whole = self._known(base)
            whole.pins += 1
            offset = value.__array_interface__["data"][0] - base.__array_interface__["data"][0]
            known.rows |= whole.rows
            known.contents += whole.contents
            known.rows[known.number] = [PART, whole.ref, offset, numbers, list(value.shape), list(value.strides)]
            return
        axes = sorted(range(value.ndim), key=lambda axis: -abs(value.strides[axis]))
        laid = value.transpose(axes)
        if value.flags.c_contiguous and value.flags.writeable:
            row, laid = [WHOLE, numbers, list(value.shape)], value
        else:
            row = [LAID, numbers, list(laid.shape), axes, bool(value.flags.writeable)]
        known.rows[known.number] = row
        known.contents.append((known.number, laid.tobytes if laid.nbytes < LARGE else partial(used_bytes, laid)))


def used_bytes(array: Any) -> bytes:
    """What is in a large array, but for most of the zeros at its end: tables have room to spare."""
    if not array.flags.c_contiguous or array.nbytes % 8:
        return bytes(array.tobytes())
    words = array.reshape(-1).view(np.uint64)
    end = len(words)
    while end > LEAST and not words[end // 2 : end].any():
        end //= 2
    return bytes(words[:end].tobytes())


_CONTAINERS: Final = {
    list: "_list", tuple: "_tuple", dict: "_dict", set: "_set", frozenset: "_frozenset", deque: "_deque",
    OrderedDict: "_ordered", Counter: "_counter", MethodType: "_method", complex: "_complex",
    np.float64: "_number", np.float32: "_number", np.int64: "_number", np.int32: "_number", np.bool_: "_number",
}  # fmt: skip


class _Encoders(dict[type, Encode]):
    """How objects of each class are taken; those of new classes are looked at when the first one comes."""

    def __init__(self, made: Callable[[type], Encode]) -> None:
        super().__init__()
        self._made = made

    def __missing__(self, cls: type) -> Encode:
        self[cls] = self._made(cls)
        return self[cls]


@cache
def split_names(kind: Kind) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The fields of a kind in the order in which they are written: plain values, and all others."""
    types = kind.types()
    plain = tuple(name for name, found in types.items() if _is_plain(found))
    return plain, tuple(name for name in types if name not in plain)


def _is_plain(found: Type) -> bool:
    """Whether it is a plain value, or a tuple of such."""
    return (found.word in _PLAIN or found.word in ("|", "tuple", "row")) and all(map(_is_plain, found.of))


def values_of(names: tuple[str, ...]) -> Callable[[Any], tuple[Any, ...]]:
    """What takes the values of these fields out of an object at once."""
    if len(names) > 1:
        return attrgetter(*names)
    return (lambda value: (getattr(value, names[0]),)) if names else (lambda value: ())


@cache
def is_fixed(kind: Kind) -> bool:
    """Whether nobody can change an object of this kind, nor what it holds."""
    if issubclass(kind.cls, Enum):
        return True
    parameters = getattr(kind.cls, "__dataclass_params__", None)
    return parameters is not None and parameters.frozen and all(_is_fixed(kind_of) for kind_of in kind.types().values())


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
