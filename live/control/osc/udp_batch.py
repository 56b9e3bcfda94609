"""Batch reader for UDP datagrams: many per system call where possible (Linux: recvmmsg(2)).

In a flood, one call per datagram would cost the interpreter more than the datagrams themselves and delay the frame.
"""

import ctypes
import socket
import struct
from typing import Any, Final

from live.base.system.features import LINUX

BATCH_SIZE: Final = 256
_DONT_WAIT: Final = 0x40
_ADDRESS_BYTES: Final = 28
_MAX_SENDERS: Final = 1024


class _Vector(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class _Message(ctypes.Structure):
    """struct msghdr."""

    _fields_ = (
        ("name", ctypes.c_void_p), ("name_length", ctypes.c_uint32), ("vectors", ctypes.POINTER(_Vector)),
        ("vector_count", ctypes.c_size_t), ("control", ctypes.c_void_p), ("control_length", ctypes.c_size_t),
        ("flags", ctypes.c_int),
    )  # fmt: skip


class _Header(ctypes.Structure):
    """struct mmsghdr."""

    _fields_ = (("message", _Message), ("received", ctypes.c_uint32))


class DatagramReader:
    """Batch reader of one non-blocking socket. Use from one thread."""

    def __init__(self, sock: socket.socket, largest: int) -> None:
        """`largest`: maximum size of a datagram; a longer one is cut to one byte more."""
        self._socket, self._size = sock, largest + 1
        self._senders: dict[bytes, Any] = {}
        self._call: Any = None
        if LINUX and sock.family in (socket.AF_INET, socket.AF_INET6):
            self._prepare()

    def _prepare(self) -> None:
        try:
            call = ctypes.CDLL(None, use_errno=True).recvmmsg
        except (OSError, AttributeError):
            return
        self._bytes = ctypes.create_string_buffer(BATCH_SIZE * self._size)
        self._names = ctypes.create_string_buffer(BATCH_SIZE * _ADDRESS_BYTES)
        self._vectors = (_Vector * BATCH_SIZE)()
        self._headers = (_Header * BATCH_SIZE)()
        for index in range(BATCH_SIZE):
            vector, message = self._vectors[index], self._headers[index].message
            vector.base = ctypes.addressof(self._bytes) + index * self._size
            vector.length = self._size
            message.name = ctypes.addressof(self._names) + index * _ADDRESS_BYTES
            message.vectors, message.vector_count = ctypes.pointer(vector), 1
        self._call, self._view, self._used = call, memoryview(self._bytes), BATCH_SIZE

    def read(self) -> list[tuple[bytes, Any]]:
        """Return waiting datagrams with their senders, at most `BATCH_SIZE`; OSError as from recvfrom."""
        if self._call is None:
            try:
                return [self._socket.recvfrom(self._size)]
            except BlockingIOError:
                return []
        for index in range(self._used):
            self._headers[index].message.name_length = _ADDRESS_BYTES
        count = self._call(self._socket.fileno(), self._headers, BATCH_SIZE, _DONT_WAIT, None)
        self._used = max(count, 0)
        if count <= 0:
            number = ctypes.get_errno()
            if count < 0 and number not in (11, 4):  # EAGAIN, EINTR
                raise OSError(number, "recvmmsg")
            return []
        view, size, names = self._view, self._size, self._names.raw
        found = []
        for index in range(count):
            start = index * size
            name = names[index * _ADDRESS_BYTES : (index + 1) * _ADDRESS_BYTES]
            sender = self._senders.get(name) or self._sender(name)
            found.append((bytes(view[start : start + self._headers[index].received]), sender))
        return found

    def _sender(self, name: bytes) -> Any:
        """Return the address in a struct sockaddr as Python's tuple; cached, so usually the same object."""
        if len(self._senders) >= _MAX_SENDERS:
            self._senders.clear()
        port = struct.unpack_from(">H", name, 2)[0]
        sender: tuple[Any, ...]
        if self._socket.family == socket.AF_INET:
            sender = (socket.inet_ntoa(name[4:8]), port)
        else:
            flow, scope = struct.unpack_from(">I", name, 4)[0], struct.unpack_from("=I", name, 24)[0]
            sender = (socket.inet_ntop(socket.AF_INET6, name[8:24]), port, flow, scope)
        self._senders[name] = sender
        return sender
