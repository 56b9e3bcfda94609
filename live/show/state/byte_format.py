"""Byte format of a state: a MessagePack tree, followed by the content of all arrays.

The tree is an array of kinds, rows, sizes and the root:

    kinds   {number: [name, [field, ...], [field, ...]]} for each kind in use: plain fields, and all others
    rows    {number: row}: [kind, [plain, ...], value, ...] for an object, fields in order; else one of the codes
            below, with its values
    sizes   size of the content of each array, in the order of the rows [bytes]; missing bytes at its end are 0
    root    a value

Plain is None, a bool, a number, a text or bytes; an array is a tuple of such.

A value is None, a bool, a number, a text or bytes; or an array:

    [n]                              the object of row n
    [name]                           a constant, or part of one, determined by patch, steps and seed
    [None, value, ...]               a tuple
    [VALUE, word, ...]               a number of numpy, complex, frozenset, or member of the enumeration `word`
    [METHOD, value, name]            a method of an object

Integers of more than 64 bits use MessagePack's extension type 1: two's complement, big-endian.
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
"""Maximum length or None, then the items."""
ARRAY: Final = -7
"""A contiguous array: dtype string, shape; its content is the next of the contents."""
ARRAY_LAYOUT: Final = -8
"""An array with another memory layout: dtype string, shape in memory order, axes, whether it is writeable."""
ARRAY_VIEW: Final = -9
"""A view of another array: the other array, first byte, dtype string, shape, strides."""
SCRATCH: Final = -10
"""A scratch array, computed before it is read: its name."""

VALUE: Final = True
METHOD: Final = False

HEAD: Final = struct.Struct(">I")
"""Size of the tree [bytes], before the tree."""
MAX_TREE_BYTES: Final = 1 << 22
"""Maximum size of a tree [bytes]."""
MAX_ARRAY_BYTES: Final = 1 << 25
"""Maximum size of all arrays together [bytes], so that a damaged or hostile state cannot exhaust memory."""
MAX_STATE_BYTES: Final = HEAD.size + MAX_TREE_BYTES + MAX_ARRAY_BYTES
_BIG_INT: Final = 1
_MAX_INT_BYTES: Final = 512


class StateDecodeError(Exception):
    """Bytes that are not a valid state of a show; the message gives the reason."""


def encode_tree(tree: Any) -> bytes:
    """Return a tree as bytes."""
    out: bytes = msgpack.packb(tree, default=_encode_big_int, unicode_errors="surrogatepass")
    return out


def decode_tree(data: bytes | memoryview) -> Any:
    """Decode a tree; Unreadable for invalid bytes."""
    if len(data) > MAX_TREE_BYTES:
        raise StateDecodeError(f"its tree has {len(data)} bytes, more than {MAX_TREE_BYTES}")
    try:
        return msgpack.unpackb(
            data, strict_map_key=False, unicode_errors="surrogatepass", ext_hook=_decode_big_int, raw=False
        )
    except StateDecodeError:
        raise
    except Exception as error:  # damaged bytes raise many types of errors
        raise StateDecodeError(f"its tree is damaged: {type(error).__name__}: {error}") from None


def _encode_big_int(value: object) -> msgpack.ExtType:
    if not isinstance(value, int) or value.bit_length() > 8 * _MAX_INT_BYTES - 1:
        raise TypeError(f"{type(value).__name__} is not a valid value of a state")
    return msgpack.ExtType(_BIG_INT, value.to_bytes(value.bit_length() // 8 + 1, "big", signed=True))


def _decode_big_int(code: int, data: bytes) -> int:
    if code != _BIG_INT or len(data) > _MAX_INT_BYTES:
        raise StateDecodeError(f"extension {code} of {len(data)} bytes")
    return int.from_bytes(data, "big", signed=True)
