"""Packed: a long text as a short one of plain letters, for lines that are written within a frame.

Zlib and base64: what is a hundred kilobytes of JSON costs the frame a copy of some kilobytes.
"""

import base64
import binascii
import zlib
from typing import Final

LONG: Final = 4096
"""Texts of more characters are packed."""
MOST: Final = 16_000_000
"""Bytes that a packed text may become ..."""
MOST_VALUES: Final = 500_000
"""... and values that it may hold as JSON: a damaged or hostile one asks for no more memory."""
_MARK: Final = "zlib:"


def packed(text: str) -> str:
    """The text, or what `unpacked` makes it of."""
    if len(text) <= LONG and not text.startswith(_MARK):
        return text
    return _MARK + base64.b64encode(zlib.compress(text.encode(), 6)).decode("ascii")


def unpacked(text: str) -> str:
    """The text that was packed; ValueError for what is damaged or would be too long."""
    if not text.startswith(_MARK):
        return text
    worker = zlib.decompressobj()
    try:
        found = worker.decompress(base64.b64decode(text[len(_MARK) :], validate=True), MOST)
        if not worker.eof:
            raise ValueError("a packed text is cut off or too long")
        if values_in(found) > MOST_VALUES:
            raise ValueError("a packed text holds too much")
        return found.decode()
    except (zlib.error, binascii.Error, UnicodeDecodeError) as error:
        raise ValueError(f"a packed text is damaged: {error}") from None


def values_in(text: str | bytes) -> int:
    """At least as many as a text holds as JSON: so much memory it takes to read it."""
    if isinstance(text, bytes):
        return 1 + sum(text.count(mark) for mark in (b",", b"[", b"{", b":"))
    return 1 + sum(text.count(mark) for mark in ",[{:")
