"""Tokens: who may join by the code on the projector, and who has joined before. Nothing of a person is in them.

The link holds a key that another one follows every minute; old ones let in for a while. Who joins gets a token: her
number, signed. Whoever knows the show's secret, as a gateway that was started again does, knows both again.
"""

import base64
import hashlib
import hmac
from typing import Final

ROTATES: Final = 60.0
"""After so many seconds the link's key is another one ..."""
VALID: Final = 5
"""... and the last so many still let in: a photograph of the code is of no use tomorrow."""
KEY_BYTES: Final = 9
"""72 bits, and no padding in base64."""
MOST_NUMBER: Final = 1 << 31


def _signed(secret: bytes, words: str) -> str:
    digest = hmac.new(secret, words.encode(), hashlib.sha256).digest()[:KEY_BYTES]
    return base64.urlsafe_b64encode(digest).decode()


def link_key(secret: bytes, time: float) -> str:
    """The key in the link at `time` [s of the show]."""
    return _signed(secret, f"link {int(time // ROTATES)}")


def lets_in(secret: bytes, key: str, time: float) -> bool:
    """Whether a link's key lets in at `time` [s of the show]: that of now, or one of the last minutes."""
    turn = int(time // ROTATES)
    good = False
    for old in range(VALID + 1):  # all of them, whichever fits: time tells nothing
        good |= hmac.compare_digest(_signed(secret, f"link {turn - old}").encode(), key.encode("utf-8", "replace"))
    return good


def token_of(secret: bytes, number: int) -> str:
    """The token of a phone."""
    return f"{number}.{_signed(secret, f'phone {number}')}"


def number_of(secret: bytes, token: str) -> int:
    """The phone's number; 0 for a token that nobody has given."""
    number, _, signature = token.partition(".")
    if not (number.isascii() and number.isdecimal() and len(number) <= 10 and 0 < int(number) < MOST_NUMBER):
        return 0
    good = hmac.compare_digest(_signed(secret, f"phone {int(number)}").encode(), signature.encode("utf-8", "replace"))
    return int(number) if good else 0


def hue_of(number: int) -> int:
    """A phone's colour: hue in thousandths; those who join one after the other differ much (golden ratio)."""
    return int(number * 618.034) % 1000
