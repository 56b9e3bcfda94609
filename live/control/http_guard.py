"""Who may ask an HTTP server of a show: programs, and pages of the very server; no page of another site."""

import ipaddress
import re

from aiohttp import web


def is_ours(host: str, link_host: str = "") -> bool:
    """Whether a Host header names this machine: by number, as localhost or .local, or as its own link does.

    Else a page of another site could have its own name lead here (DNS rebinding).
    """
    if len(host) > 255:
        return False
    name = re.sub(r":\d{1,5}$", "", host).casefold()
    if host.casefold() == link_host.casefold() != "" or name == "localhost":
        return True
    if re.fullmatch(r"[a-z0-9-]+\.local", name):
        return True
    try:
        ipaddress.ip_address(name.removeprefix("[").removesuffix("]"))
    except ValueError:
        return False
    return True


def welcome(request: web.Request) -> bool:
    """Whether it was asked by a program, or a page of this very server: not by a page of another site."""
    host = request.headers.get("Host", "")
    if host and not is_ours(host):
        return False
    origin = request.headers.get("Origin")
    return origin is None or origin.partition("://")[2] == host
