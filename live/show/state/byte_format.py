"""The form of a state as bytes: a tree of MessagePack, and the content of all arrays one after another.

The tree is an array of kinds, rows, sizes and the root:

    kinds   {number: [name, [field, ...], [field, ...]]} of each kind that rows are of: plain fields, and all others
    rows    {number: row}: [kind, [plain, ...], value, ...] an object, its fields in their order; else a code below,
            and what it says
    sizes   of the content of each array, in the order of their rows [bytes]; what is missing at its end is 0
    root    a value

Plain is None, a bool, a number, a text or bytes; an array is a tuple of such.

A value is None, a bool, a number, a text or bytes; or an array:

    [n]                              what row n says
    [name]                           a constant, or part of one, that patch, steps and seed decide
    [None, value, ...]               a tuple
    [VALUE, word, ...]               a number of numpy, complex, frozenset, or member of the enumeration `word`
    [METHOD, value, name]            a method of an object

Whole numbers of more than 64 bits are of MessagePack's extension type 1: two's complement, big end first.
"""

import struct
from typing import Any, Final

import msgpack

Row = list[Any]
Rows = dict[int, Row]

LIST: Final = -1
DICT: Final = -2
"""Key, value, key, value ..."""
ORDERED: Final = -3
COUNTER: Final = -4
SET: Final = -5
DEQUE: Final = -6
"""Its longest length or None, and what is in it."""
WHOLE: Final = -7
"""An array: type of its numbers as numpy writes it, shape; its content is the next of the contents."""
LAID: Final = -8
"""The same, laid out otherwise: type, shape as it is laid out, which axis each is, whether it can be changed."""
PART: Final = -9
"""An array that is a part of another one: the other, first byte, type, shape, strides."""
SCRATCH: Final = -10
"""An array that is worked out before it is read: its name."""

VALUE: Final = True
METHOD: Final = False

HEAD: Final = struct.Struct(">I")
"""Before the tree: how many bytes it has."""
MOST_TREE: Final = 1 << 22
"""Bytes of a tree ..."""
MOST_NUMBERS: Final = 1 << 25
"""... and of all arrays together, at most: a damaged or hostile state asks for no more memory."""
MOST_BYTES: Final = HEAD.size + MOST_TREE + MOST_NUMBERS
_LONG: Final = 1
_LONGEST: Final = 512


class Unreadable(Exception):
    """Bytes that are no state of a show; the message says why."""


def packed_tree(tree: Any) -> bytes:
    """A tree as bytes."""
    out: bytes = msgpack.packb(tree, default=_long, unicode_errors="surrogatepass")
    return out


def read_tree(data: bytes | memoryview) -> Any:
    """A tree of bytes; Unreadable for anything else."""
    if len(data) > MOST_TREE:
        raise Unreadable(f"its tree has {len(data)} bytes, more than {MOST_TREE}")
    try:
        return msgpack.unpackb(data, strict_map_key=False, unicode_errors="surrogatepass", ext_hook=_short, raw=False)
    except Unreadable:
        raise
    except Exception as error:  # damaged bytes raise many things
        raise Unreadable(f"its tree is damaged: {type(error).__name__}: {error}") from None


def _long(value: object) -> msgpack.ExtType:
    if not isinstance(value, int) or value.bit_length() > 8 * _LONGEST - 1:
        raise TypeError(f"{type(value).__name__} is no value of a state")
    return msgpack.ExtType(_LONG, value.to_bytes(value.bit_length() // 8 + 1, "big", signed=True))


def _short(code: int, data: bytes) -> int:
    if code != _LONG or len(data) > _LONGEST:
        raise Unreadable(f"extension {code} of {len(data)} bytes")
    return int.from_bytes(data, "big", signed=True)
