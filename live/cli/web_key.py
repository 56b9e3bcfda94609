"""The key of the operator's page: whoever comes from another machine must bring it."""

import ipaddress
import secrets


def new_key(host: str) -> str:
    """What the link of the page has to say; nothing where only this machine can ask."""
    return "" if is_here(host) else secrets.token_urlsafe(12)


def is_here(host: str) -> bool:
    """Whether only this machine reaches it."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
