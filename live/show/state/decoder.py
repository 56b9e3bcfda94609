"""Decoder for states: creates objects of listed kinds, field by field, with constants and scratch of a fresh show.

Nothing named by the bytes is called or imported: kinds come from `kinds.py`, constants from the fresh show's table.
Objects are created empty and then filled, so that reference cycles are possible. `type_check.py` checks the result
before it is used.
"""

from collections import Counter, OrderedDict, deque
from collections.abc import Callable
from enum import Enum
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.show.state.byte_format import (
    ARRAY,
    ARRAY_LAYOUT,
    ARRAY_VIEW,
    COUNTER,
    DEQUE,
    DICT,
    HEAD,
    LIST,
    MAX_ARRAY_BYTES,
    METHOD,
    ORDERED,
    SCRATCH,
    SET,
    VALUE,
    Row,
    StateDecodeError,
    decode_tree,
)  # fmt: skip
from live.show.state.constants import Constants
from live.show.state.kind import NUMBERS, PLAIN, Kind
from live.show.state.kinds import BY_NAME, METHODS

Array = npt.NDArray[Any]

NUMPY: Final = frozenset(NUMBERS.values())
"""Permitted array types."""
SCALARS: Final = {word[1:]: np.dtype(word) for word in NUMPY}
MAX_AXES: Final = 8
MAX_ROWS: Final = 1 << 18
MAX_DEPTH: Final = 64
"""Maximum nesting of values."""


def read_state(data: bytes, constants: Constants) -> Any:
    """Decode an encoded state and return its root; StateDecodeError for anything else.

    `constants` are those of a fresh show. The caller must check the result with `type_check.py`.
    """
    try:
        root = _Decoder(*_split(data), constants).read()
    except StateDecodeError:
        raise
    except Exception as error:  # crafted bytes may raise anything, but have no other effect
        raise StateDecodeError(f"{type(error).__name__}: {error}"[:400]) from None
    return root


def _split(data: bytes) -> tuple[Any, memoryview]:
    if len(data) < HEAD.size:
        raise StateDecodeError("it is cut off")
    (size,) = HEAD.unpack_from(data)
    view = memoryview(data)[HEAD.size :]
    if size > len(view):
        raise StateDecodeError("its tree is cut off")
    return decode_tree(view[:size]), view[size:]


class _Decoder:
    """Creates the objects of one tree."""

    def __init__(self, tree: Any, content: memoryview, constants: Constants) -> None:
        if not (isinstance(tree, list) and len(tree) == 4 and isinstance(tree[0], dict) and isinstance(tree[1], dict)):
            raise StateDecodeError("its tree is not an array of kinds, rows, sizes and a root")
        kinds, self._rows, sizes, self._root = tree
        if not _whole_numbers(sizes) or min(sizes, default=0) < 0 or sum(sizes) != len(content):
            raise StateDecodeError("the content of its arrays does not have the stated size")
        self._sizes = iter(sizes)
        self._room = MAX_ARRAY_BYTES
        if len(self._rows) > MAX_ROWS:
            raise StateDecodeError(f"it has {len(self._rows)} rows, more than {MAX_ROWS}")
        found = {number: _decode_kind(number, said) for number, said in kinds.items()}
        self._kinds = {number: kind for number, (kind, _, _) in found.items()}
        self._names = {number: (plain, others) for number, (_, plain, others) in found.items()}
        self._content, self._place = content, 0
        self._constants = constants
        self._made: dict[int, Any] = {}
        self._scratch: dict[str, Array] = {}

    def read(self) -> Any:
        """Decode all rows and return the root."""
        for number, row in self._rows.items():
            if type(number) is not int or not (isinstance(row, list) and row and type(row[0]) is int):
                raise StateDecodeError(f"row {number!r:.40} is invalid")
            if row[0] != ARRAY_VIEW:
                self._made[number] = self._empty(row)
        if next(self._sizes, None) is not None:
            raise StateDecodeError("there is content without an array")
        for number, row in self._rows.items():
            if row[0] == ARRAY_VIEW:
                self._made[number] = self._part(row)
        later = [number for number, row in self._rows.items() if row[0] < 0]
        for number, row in self._rows.items():
            if row[0] >= 0:
                self._fill_object(self._made[number], row)
        for number in later:  # keys may be objects, which are complete by now
            self._fill(self._made[number], self._rows[number])
        return self._value(self._root)

    # -- creation of empty objects ------------------------------------------------------------------------------

    def _empty(self, row: Row) -> Any:
        code = row[0]
        if code >= 0:
            kind = self._kinds.get(code)
            if kind is None:
                raise StateDecodeError(f"there is no kind {code}")
            plain, others = self._names[code]
            if len(row) != 2 + len(others) or not isinstance(row[1], list) or len(row[1]) != len(plain):
                raise StateDecodeError(f"{kind.name!r} has not as many values as fields")
            return object.__new__(kind.cls)
        if code in (ARRAY, ARRAY_LAYOUT):
            return self._array(row)
        if code == SCRATCH:
            return self._scratch_array(row)
        if code == DEQUE:
            if len(row) < 2 or not (row[1] is None or (type(row[1]) is int and 0 <= row[1] < 1 << 20)):
                raise StateDecodeError("a deque has no valid length")
            return deque(maxlen=row[1])
        made = _CONTAINERS.get(code)
        if made is None:
            raise StateDecodeError(f"there is no row code {code}")
        return made()

    def _array(self, row: Row) -> Array:
        numbers, shape = row[1], row[2]
        if numbers not in NUMPY or not _whole_numbers(shape) or len(shape) > MAX_AXES or min(shape, default=0) < 0:
            raise StateDecodeError(f"an array of type {numbers!r:.20} and shape {shape!r:.80} is invalid")
        count = 1
        for length in shape:
            count *= length
        kind = np.dtype(numbers)
        begin, used, size = self._place, next(self._sizes, -1), count * kind.itemsize
        self._room -= size
        if not 0 <= used <= size or self._room < 0:
            raise StateDecodeError("the content of an array is cut off, or too large")
        self._place += used
        found: Array = np.zeros(shape, kind)
        found.reshape(-1).view(np.uint8)[:used] = np.frombuffer(self._content[begin : begin + used], np.uint8)
        if kind == np.bool_ and found.view(np.uint8).max(initial=0) > 1:
            raise StateDecodeError("an array of booleans holds other values")
        if row[0] == ARRAY:
            return found
        axes, writeable = row[3], row[4]
        if not _whole_numbers(axes) or sorted(axes) != list(range(len(shape))) or type(writeable) is not bool:
            raise StateDecodeError("an array has invalid axes")
        if axes != sorted(axes):
            found = found.transpose(np.argsort(axes))
        found.flags.writeable = writeable
        return found

    def _scratch_array(self, row: Row) -> Array:
        name = row[1]
        like = self._constants.scratch.get(name) if isinstance(name, str) else None
        if like is None or name in self._scratch:
            raise StateDecodeError(f"there is no scratch array {name!r:.80}, or it occurs twice")
        found: Array = np.zeros_like(like)
        self._scratch[name] = found
        return found

    def _part(self, row: Row) -> Array:
        _, whole, offset, numbers, shape, strides = row
        base = self._value(whole)
        if not isinstance(base, np.ndarray) or numbers not in NUMPY or not base.flags.c_contiguous:
            raise StateDecodeError("the base of an array view is not a contiguous array")
        if not (_whole_numbers([offset]) and _whole_numbers(shape) and _whole_numbers(strides)):
            raise StateDecodeError("an array view has no valid offset, shape or strides")
        if len(shape) != len(strides) or len(shape) > MAX_AXES or min(shape, default=0) < 0 or offset < 0:
            raise StateDecodeError("an array view has no valid offset, shape or strides")
        kind = np.dtype(numbers)
        if 0 in shape:
            return np.zeros(shape, kind)
        low = high = offset
        for length, stride in zip(shape, strides, strict=True):
            low, high = low + min((length - 1) * stride, 0), high + max((length - 1) * stride, 0)
        whole_bytes = base.dtype == kind or not any(each.kind == "b" for each in (base.dtype, kind))
        if low < 0 or high + kind.itemsize > base.nbytes or offset % kind.itemsize or not whole_bytes:
            raise StateDecodeError("an array view lies outside of its base")
        if any(stride % kind.itemsize for stride in strides):
            raise StateDecodeError("an array view is not aligned to its items")
        found: Array = np.ndarray(shape, kind, base, offset, strides)
        return found

    # -- filling ------------------------------------------------------------------------------------------------

    def _fill_object(self, made: Any, row: Row) -> None:
        kind = self._kinds[row[0]]
        plain, others = self._names[row[0]]
        for name, value in zip(plain, row[1], strict=True):
            object.__setattr__(made, name, _decode_plain(value))
        for name, value in zip(others, row[2:], strict=True):
            object.__setattr__(made, name, self._value(value))
        for name, anew in kind.factories.items():
            object.__setattr__(made, name, anew())

    def _fill(self, made: Any, row: Row) -> None:
        code = row[0]
        if code in (LIST, DEQUE, SET):
            values = [self._value(value) for value in row[2 if code == DEQUE else 1 :]]
            if code == SET:
                made.update(values)
            else:
                made.extend(values)
        elif code in (DICT, ORDERED, COUNTER):
            if len(row) % 2 == 0:
                raise StateDecodeError("a dict has a key without a value")
            for key, value in zip(row[1::2], row[2::2], strict=True):
                made[self._value(key)] = self._value(value)

    def _value(self, encoded: Any, depth: int = 0) -> Any:
        if type(encoded) in PLAIN:
            return encoded
        if type(encoded) is not list or not encoded or depth > MAX_DEPTH:
            raise StateDecodeError("a value is invalid, or nested too deep")
        first = encoded[0]
        if first is None:
            return tuple([self._value(each, depth + 1) for each in encoded[1:]])
        if first is VALUE:
            return self._special(encoded, depth)
        if first is METHOD:
            return self._method(encoded, depth)
        if len(encoded) == 1:
            if type(first) is int and first in self._made:
                return self._made[first]
            if type(first) is str and first in self._constants.named:
                return self._constants.named[first]
        raise StateDecodeError(f"{encoded!r:.80} names no known object")

    def _special(self, encoded: list[Any], depth: int) -> Any:
        word = encoded[1]
        if word == "complex" and all(type(part) is float for part in encoded[2:]):
            return complex(encoded[2], encoded[3])
        if word == "frozenset":
            return frozenset([self._value(each, depth + 1) for each in encoded[2:]])
        if word in SCALARS and len(encoded) == 3 and type(encoded[2]) in (int, float, bool):
            return SCALARS[word].type(encoded[2])
        kind = BY_NAME.get(word) if isinstance(word, str) else None
        if kind is not None and issubclass(kind.cls, Enum) and len(encoded) == 3 and type(encoded[2]) in PLAIN:
            return kind.cls(encoded[2])
        raise StateDecodeError(f"{encoded!r:.80} is not a valid value")

    def _method(self, encoded: list[Any], depth: int) -> Any:
        _, whose, name = encoded
        owner = self._value(whose, depth + 1)
        found = next((kind for kind in self._kinds.values() if type(owner) is kind.cls), None)
        if found is None or not isinstance(name, str) or (found.name, name) not in METHODS:
            raise StateDecodeError(f"{type(owner).__name__} has no method {name!r:.40} that a state may hold")
        return METHODS[found.name, name].__get__(owner)


_CONTAINERS: Final[dict[int, Callable[[], Any]]] = {
    LIST: list, DICT: dict, ORDERED: OrderedDict, COUNTER: Counter, SET: set,
}  # fmt: skip


def _decode_kind(number: object, encoded: Any) -> tuple[Kind, list[str], list[str]]:
    """Return a kind named by the tree, with its fields in the tree's order; they must equal the fields known here."""
    if type(number) is not int or number < 0 or not isinstance(encoded, list) or len(encoded) != 3:
        raise StateDecodeError("its table of kinds is invalid")
    name, plain, others = encoded
    kind = BY_NAME.get(name) if isinstance(name, str) else None
    if kind is None or issubclass(kind.cls, Enum) or not isinstance(plain, list) or not isinstance(others, list):
        raise StateDecodeError(f"there is no kind {name!r:.80}")
    names = [*plain, *others]
    differ = sorted(set(map(str, names)) ^ set(kind.names))
    if differ or len(names) != len(kind.names):
        raise StateDecodeError(
            f"{kind.name!r} is of another version there, with other fields: {', '.join(differ)}"[:400]
        )
    return kind, plain, others


def _decode_plain(encoded: Any, depth: int = 0) -> Any:
    if type(encoded) in PLAIN:
        return encoded
    if type(encoded) is not list or depth > MAX_DEPTH:
        raise StateDecodeError("a plain value is invalid, or nested too deep")
    return tuple([_decode_plain(each, depth + 1) for each in encoded])


def _whole_numbers(found: Any) -> bool:
    return isinstance(found, list) and all(type(each) is int and abs(each) < 1 << 40 for each in found)
