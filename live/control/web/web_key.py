"""The key in a request: in a header that no other site's page can send."""

import hashlib
import hmac
import secrets
from typing import Final

from aiohttp import web

PROTOCOL: Final = "live.operator"
KEY_PROTOCOL: Final = "live.key."
"""Followed by the key."""
RELAY_HEADER: Final = "X-Live-Relay"
"""Header by which the machine's own relay (`live.nodes.page_relay`) says that it has checked the host."""


def relay_token(key: bytes) -> str:
    """Return the header's value, which nobody knows without the page's key."""
    return hmac.new(key, b"relay of the operator's page", hashlib.sha256).hexdigest()


def is_relayed(request: web.BaseRequest, key: bytes) -> bool:
    """Whether a request comes through that relay; never with an empty key."""
    told = request.headers.get(RELAY_HEADER, "")
    return bool(key) and hmac.compare_digest(told.encode(errors="replace"), relay_token(key).encode())


def has_key(request: web.BaseRequest, key: bytes) -> bool:
    """Return whether a request has the key: `Authorization: Bearer KEY`, or, for a browser's WebSocket, the
    subprotocols `live.operator, live.key.KEY`. An empty key never matches."""
    scheme, _, brought = request.headers.get("Authorization", "").partition(" ")
    if scheme.casefold() != "bearer":
        offered = [each.strip() for each in request.headers.get("Sec-WebSocket-Protocol", "").split(",")]
        keys = [each.removeprefix(KEY_PROTOCOL) for each in offered if each.startswith(KEY_PROTOCOL)]
        brought = keys[0] if keys and PROTOCOL in offered else ""
    return bool(key) and secrets.compare_digest(brought.encode(errors="replace"), key)
