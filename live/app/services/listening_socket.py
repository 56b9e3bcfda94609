"""A port where connections are taken, held through the death of an engine: the next one needs not wait for it."""

import socket


def listening_socket(where: tuple[str, int], backlog: int, *, goes_on: bool) -> socket.socket:
    """Listen at an address and port; OSError or OverflowError if that cannot be, or if somebody else does.

    `goes_on`: with a show whose engine has ended. Processes of that engine may hold the port still, for they end a
    moment later, and later yet on a busy machine: both hold it then (SO_REUSEPORT of socket(7), one user's processes).
    """
    family = socket.AF_INET6 if ":" in where[0] else socket.AF_INET
    if not goes_on and where[1]:
        socket.create_server(where, family=family, backlog=1).close()  # nobody's port is shared by mistake
    return socket.create_server(where, family=family, backlog=backlog, reuse_port=hasattr(socket, "SO_REUSEPORT"))
