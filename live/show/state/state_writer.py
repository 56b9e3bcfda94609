"""Capture of a show's whole state within a frame, isolated from later changes.

The result is a table of numbered rows, one for each object, container and array; see `byte_format.py`. Immutable values
are only referenced; `encoder.py` encodes them later.
"""

from collections import Counter, OrderedDict, deque
from collections.abc import Callable
from functools import partial
from itertools import chain
from operator import is_
from types import MethodType
from typing import Any, Final

import numpy as np

from live.show.state.byte_format import (
    ARRAY,
    ARRAY_LAYOUT,
    ARRAY_VIEW,
    COUNTER,
    DEQUE,
    DICT,
    LIST,
    METHOD,
    ORDERED,
    SCRATCH,
    SET,
    Row,
    Rows,
)  # fmt: skip
from live.show.state.constants import Constants
from live.show.state.encoder import (
    IMMUTABLE_CLASSES,
    CapturedObject,
    CapturedState,
    CapturePlan,
    EncodedLinks,
    StateEncodeError,
    capture_plan,
)
from live.show.state.kinds import BY_CLASS, METHODS

Encode = Callable[[Any], Any]
Contents = list[tuple[int, Callable[[], bytes]]]

TRIM_BYTES: Final = 1 << 15
"""Array size from which trailing zeros are trimmed [bytes]: the search is faster than copying."""
MIN_COPIED_BYTES: Final = 512
"""Bytes that are always copied."""


class _ArrayEntry:
    """Cache entry of an array: its number, the rows and contents it needs, and its reference count."""

    __slots__ = ("contents", "number", "ref", "references", "rows", "turn", "value")

    def __init__(self, value: Any, number: int) -> None:
        self.value, self.number = value, number
        self.ref: list[Any] = [number]
        self.rows: Rows = {}
        self.contents: Contents = []
        self.references = self.turn = 0


class _ObjectEntry:
    """Cache entry of an object: its links and their encoded form."""

    __slots__ = ("arrays", "children", "dynamic", "held", "part", "readers", "ref", "shape", "turn", "value")

    def __init__(self, value: Any, number: int, shape: CapturePlan) -> None:
        self.value, self.shape, self.ref = value, shape, [number]
        self.held: tuple[Any, ...] | None = None
        self.dynamic: tuple[int, ...] = ()
        """Indices of links to containers, which are encoded each time."""
        self.children: list[_ObjectEntry] = []
        self.arrays: list[_ArrayEntry] = []
        self.readers: list[Callable[[], bytes]] = []
        self.part: EncodedLinks
        """The encoded links, valid as long as the links are the same."""
        self.turn = 0


class StateCapture:
    """Repeated capture of the state of one show. Thread: the show's.

    It runs within a frame. Most objects hold the same links as last time: then only their arrays and plain values are
    copied and their containers encoded.
    """

    def __init__(self, constants: Constants) -> None:
        self._constants = constants
        self._names, self._scratch = constants.name_of, constants.scratch_of
        self._encoders = _Encoders(self.encoder)
        self._objects: dict[int, _ObjectEntry] = {}
        self._arrays: dict[int, _ArrayEntry] = {}
        self._last = self._turn = self._kept_count = 0
        self._begin()

    def _begin(self) -> None:
        self._memo: dict[int, list[Any]] = {}
        self._queue: list[_ObjectEntry] = []
        self._captured: list[CapturedObject] = []
        self._rows: Rows = {}
        self._content: dict[int, bytes] = {}

    def capture(self, root: Any) -> CapturedState:
        """Capture `root` and all that it holds; Unwritable for an object of an unknown kind."""
        self._turn += 1
        self._begin()
        found = self._ref(root)
        self._capture_queue()
        self._prune()
        return CapturedState(self._captured, self._rows, self._content, found, self._names, self._last)

    def _capture_queue(self) -> None:
        """Capture all queued objects and, transitively, all they refer to."""
        turn, queue, cuts, encoders, memo = self._turn, self._queue, self._captured, self._encoders, self._memo
        for known in queue:
            value, shape = known.value, known.shape
            held = shape.links(value)
            if known.held is None or not all(map(is_, held, known.held)):
                self._encode_links(known, held)
            rest = []
            for place in known.dynamic:
                each = held[place]
                found = memo.get(id(each))
                rest.append(encoders[type(each)](each) if found is None else found)
            cuts.append((known.part, shape.values(value), rest, [read() for read in known.readers]))
            for child in known.children:
                if child.turn != turn:
                    child.turn = turn
                    queue.append(child)

    def _encode_links(self, known: _ObjectEntry, held: tuple[Any, ...]) -> None:
        """Encode an object's links again, because they have changed."""
        before = known.arrays
        links: list[Any] = []
        dynamic: list[int] = []
        rows: Rows = {}
        known.children, known.arrays = [], []
        contents: dict[int, Callable[[], bytes]] = {}
        for place, value in enumerate(held):
            cls = type(value)
            if cls is np.ndarray:
                array = self._array_entry(value)
                array.references += 1
                known.arrays.append(array)
                rows.update(array.rows)
                contents.update(array.contents)
                links.append(array.ref)
            elif cls in IMMUTABLE_CLASSES:
                links.append(value)
            elif cls in _CONTAINERS:
                dynamic.append(place)
                links.append(None)
            else:
                links.append(self._link(value, known))
        known.held, known.dynamic, known.readers = held, tuple(dynamic), list(contents.values())
        known.part = EncodedLinks(known.ref[0], known.value, known.shape, links, known.dynamic, rows, list(contents))
        for array in before:
            array.references -= 1

    def _link(self, value: Any, known: _ObjectEntry) -> list[Any]:
        cls = type(value)
        if cls in self._constants.classes or cls not in BY_CLASS:
            name = self._names.get(id(value))
            if name is not None:
                return [name]
        child = self._object(value)
        known.children.append(child)
        return child.ref

    def _object(self, value: Any) -> _ObjectEntry:
        known = self._objects.get(id(value))
        if known is None or known.value is not value:
            kind = BY_CLASS.get(type(value))
            if kind is None:
                raise StateEncodeError(
                    f"{type(value).__module__}.{type(value).__qualname__} is of no kind that a state may hold"
                )
            self._last += 1
            known = self._objects[id(value)] = _ObjectEntry(value, self._last, capture_plan(kind))
        return known

    def _prune(self) -> None:
        """Remove unused objects and arrays from the cache once there are many."""
        if len(self._objects) + len(self._arrays) <= 2 * self._kept_count + 256:
            return
        for key, known in list(self._objects.items()):
            if known.turn != self._turn:
                del self._objects[key]
                for array in known.arrays:
                    array.references -= 1
        for key, array in list(self._arrays.items()):
            if not array.references and array.turn != self._turn:
                del self._arrays[key]
        self._kept_count = len(self._objects) + len(self._arrays)

    def _ref(self, value: Any) -> Any:
        if type(value) in IMMUTABLE_CLASSES:
            return value
        found = self._memo.get(id(value))
        return self._encoders[type(value)](value) if found is None else found

    # -- encoding of values in containers ------------------------------------------------------------------------

    def encoder(self, cls: type) -> Encode:
        """Return the function that captures objects of this class."""
        if cls in _CONTAINERS:
            found: Encode = getattr(self, _CONTAINERS[cls])
            return found
        if cls is np.ndarray:
            return self._array
        return self._named if cls in self._constants.classes or cls not in BY_CLASS else self._queued

    def _named(self, value: Any) -> list[Any]:
        name = self._names.get(id(value))
        return self._queued(value) if name is None else [name]

    def _queued(self, value: Any) -> list[Any]:
        known = self._object(value)
        if known.turn != self._turn:
            known.turn = self._turn
            self._queue.append(known)
        return known.ref

    def _method(self, value: MethodType) -> list[Any]:
        owner, name = value.__self__, value.__func__.__name__
        kind = BY_CLASS.get(type(owner))
        if kind is None or (kind.name, name) not in METHODS:
            raise StateEncodeError(f"the method {type(owner).__name__}.{name} is not listed in METHODS")
        return [METHOD, self._ref(owner), name]

    def _tuple(self, value: tuple[Any, ...]) -> Any:
        if IMMUTABLE_CLASSES.issuperset(map(type, value)):
            return value
        return [None, *map(self._ref, value)]

    def _frozenset(self, value: frozenset[Any]) -> frozenset[Any]:
        return value

    def _row(self, value: Any, row: Row) -> list[Any]:
        """Add the row of a container; the caller appends the items."""
        number = -1 - len(self._memo)
        ref = self._memo[id(value)] = [number]
        self._rows[number] = row
        return ref

    def _values(self, value: Any, row: Row) -> list[Any]:
        found = self._row(value, row)
        row += value if IMMUTABLE_CLASSES.issuperset(map(type, value)) else map(self._ref, value)
        return found

    def _list(self, value: list[Any]) -> list[Any]:
        return self._values(value, [LIST])

    def _set(self, value: set[Any]) -> list[Any]:
        return self._values(value, [SET])

    def _deque(self, value: deque[Any]) -> list[Any]:
        return self._values(value, [DEQUE, value.maxlen])

    def _dict(self, value: dict[Any, Any], code: int = DICT) -> list[Any]:
        row: Row = [code]
        found = self._row(value, row)
        row += chain.from_iterable(value.items())
        if not IMMUTABLE_CLASSES.issuperset(map(type, row)):
            row[1:] = map(self._ref, row[1:])
        return found

    def _ordered(self, value: OrderedDict[Any, Any]) -> list[Any]:
        return self._dict(value, ORDERED)

    def _counter(self, value: Counter[Any]) -> list[Any]:
        return self._dict(value, COUNTER)

    # -- arrays -------------------------------------------------------------------------------------------------

    def _array(self, value: Any) -> list[Any]:
        known = self._array_entry(value)
        self._rows.update(known.rows)
        for number, read in known.contents:
            self._content[number] = read()
        return known.ref

    def _array_entry(self, value: Any) -> _ArrayEntry:
        known = self._arrays.get(id(value))
        if known is None or known.value is not value:
            self._last += 1
            known = self._arrays[id(value)] = _ArrayEntry(value, self._last)
            self._describe(known, value)
        known.turn = self._turn
        return known

    def _describe(self, known: _ArrayEntry, value: Any) -> None:
        """Set how an array is written: by name, or by its row and a reader of its content; a view includes its base."""
        name = self._names.get(id(value))
        if name is not None:
            known.ref = [name]
            return
        if value.dtype.hasobject:
            raise StateEncodeError("a state cannot hold an array of objects")
        name = self._scratch.get(id(value))
        if name is not None:
            known.rows[known.number] = [SCRATCH, name]
            return
        base, numbers = value.base, value.dtype.str
        if isinstance(base, np.ndarray) and base.flags.c_contiguous:
            whole = self._array_entry(base)
            whole.references += 1
            offset = value.__array_interface__["data"][0] - base.__array_interface__["data"][0]
            known.rows |= whole.rows
            known.contents += whole.contents
            known.rows[known.number] = [ARRAY_VIEW, whole.ref, offset, numbers, list(value.shape), list(value.strides)]
            return
        axes = sorted(range(value.ndim), key=lambda axis: -abs(value.strides[axis]))
        laid = value.transpose(axes)
        if value.flags.c_contiguous and value.flags.writeable:
            row, laid = [ARRAY, numbers, list(value.shape)], value
        else:
            row = [ARRAY_LAYOUT, numbers, list(laid.shape), axes, bool(value.flags.writeable)]
        known.rows[known.number] = row
        known.contents.append((known.number, laid.tobytes if laid.nbytes < TRIM_BYTES else partial(used_bytes, laid)))


def used_bytes(array: Any) -> bytes:
    """Return the content of a large array without most of its trailing zeros; tables have spare capacity."""
    if not array.flags.c_contiguous:
        return bytes(array.tobytes())
    content = array.reshape(-1).view(np.bool_)  # numpy scans booleans fastest
    end = len(content)
    while end > MIN_COPIED_BYTES and not content[end // 2 : end].any():
        end //= 2
    return bytes(content[:end].tobytes())


_CONTAINERS: Final = {
    list: "_list", tuple: "_tuple", dict: "_dict", set: "_set", frozenset: "_frozenset", deque: "_deque",
    OrderedDict: "_ordered", Counter: "_counter", MethodType: "_method",
}  # fmt: skip


class _Encoders(dict[type, Encode]):
    """The capture function of each class, created at the first use of the class."""

    def __init__(self, made: Callable[[type], Encode]) -> None:
        super().__init__()
        self._made = made

    def __missing__(self, cls: type) -> Encode:
        self[cls] = self._made(cls)
        return self[cls]
