"""Words from files and networks as they may be printed: what a terminal would obey, or nobody sees, is spelled out."""

import re
from typing import Final

_OBEYED: Final = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Control characters but for tab and line end, marks that turn the direction of writing, and halves of characters."""


def printable(text: str) -> str:
    """The text with each of those as a Python string would show it: the escape character as the four of `\\x1b`."""
    return _OBEYED.sub(lambda found: ascii(found.group())[1:-1], text)
