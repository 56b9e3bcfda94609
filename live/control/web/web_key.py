"""The key in a request: in a header that no other site's page can send."""

import secrets
from typing import Final

from aiohttp import web

PROTOCOL: Final = "live.operator"
KEY_PROTOCOL: Final = "live.key."
"""Followed by the key."""


def has_key(request: web.BaseRequest, key: bytes) -> bool:
    """Return whether a request has the key: `Authorization: Bearer KEY`, or, for a browser's WebSocket, the
    subprotocols `live.operator, live.key.KEY`. An empty key never matches."""
    scheme, _, brought = request.headers.get("Authorization", "").partition(" ")
    if scheme.casefold() != "bearer":
        offered = [each.strip() for each in request.headers.get("Sec-WebSocket-Protocol", "").split(",")]
        keys = [each.removeprefix(KEY_PROTOCOL) for each in offered if each.startswith(KEY_PROTOCOL)]
        brought = keys[0] if keys and PROTOCOL in offered else ""
    return bool(key) and secrets.compare_digest(brought.encode(errors="replace"), key)
