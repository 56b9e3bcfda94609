"""Listening sockets that a new engine can bind while the processes of a dead engine still hold the port."""

import socket

from live.base.errors import PersonError
from live.base.system.channel import create_server


def listening_socket(where: tuple[str, int], backlog: int, *, resumes: bool) -> socket.socket:
    """Listen at an address and port; raise OSError or OverflowError if that fails or the port is in use.

    `resumes`: a show is resumed after its engine has ended. Processes of that engine end a moment later and may still
    hold the port; both then share it (SO_REUSEPORT of socket(7), for processes of one user).
    """
    family = socket.AF_INET6 if ":" in where[0] else socket.AF_INET
    if not resumes and where[1]:
        socket.create_server(where, family=family, backlog=1).close()  # never share a foreign program's port
    return create_server(where, family=family, backlog=backlog)


def page_socket(where: tuple[str, int], backlog: int, option: str = "--web") -> socket.socket:
    """Return a listening socket for a page; PersonError, which names the `option`, if nobody can listen there."""
    try:
        return listening_socket(where, backlog, resumes=False)
    except (OSError, OverflowError) as error:
        words = f"{option} {where[0]}:{where[1]}: nobody can listen there: {error}"
        raise PersonError(words, f"another port: {option} 8011") from None
