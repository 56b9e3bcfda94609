"""Compression of long texts to short ASCII ones (zlib and base64), for lines that are written within a frame.

A hundred kilobytes of JSON then cost the frame a copy of a few kilobytes.
"""

import base64
import binascii
import zlib
from typing import Final

COMPRESS_ABOVE: Final = 4096
"""Texts with more characters are packed."""
MAX_BYTES: Final = 16_000_000
"""Maximum size of an unpacked text [bytes]."""
MAX_JSON_VALUES: Final = 500_000
"""Maximum number of JSON values in an unpacked text: limits the memory that a damaged or hostile text can take."""
_MARK: Final = "zlib:"


def compress_text(text: str) -> str:
    """Return the text, compressed if it is long; `decompress_text` reverses this."""
    if len(text) <= COMPRESS_ABOVE and not text.startswith(_MARK):
        return text
    return _MARK + base64.b64encode(zlib.compress(text.encode(), 6)).decode("ascii")


def decompress_text(text: str) -> str:
    """Return the original of a packed text; ValueError if it is damaged or would be too long."""
    if not text.startswith(_MARK):
        return text
    worker = zlib.decompressobj()
    try:
        found = worker.decompress(base64.b64decode(text[len(_MARK) :], validate=True), MAX_BYTES)
        if not worker.eof:
            raise ValueError("a packed text is cut off or too long")
        if json_value_bound(found) > MAX_JSON_VALUES:
            raise ValueError("a packed text holds too much")
        return found.decode()
    except (zlib.error, binascii.Error, UnicodeDecodeError) as error:
        raise ValueError(f"a packed text is damaged: {error}") from None


def json_value_bound(text: str | bytes) -> int:
    """Return an upper bound for the number of JSON values in a text: an estimate of the memory it takes to parse it."""
    if isinstance(text, bytes):
        return 1 + sum(text.count(mark) for mark in (b",", b"[", b"{", b":"))
    return 1 + sum(text.count(mark) for mark in ",[{:")
