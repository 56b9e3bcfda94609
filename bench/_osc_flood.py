"""A process that floods a UDP port: `python -m bench._osc_flood KIND PORT RATE SECONDS`; prints how many it has sent.

KIND: values (OSC of 60 controls, one message a datagram) or garbage. Linux sends many with one call (sendmmsg(2)), so
that the flood leaves room for who is flooded.
"""

import ctypes
import socket
import sys
import time
from typing import Final

import numpy as np

from live.control.osc.osc_codec import encode
from live.control.registry.registry import REGISTRY

BATCH: Final = 32


class _Vector(ctypes.Structure):
    _fields_ = (("base", ctypes.c_char_p), ("length", ctypes.c_size_t))


class _Header(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_void_p), ("name_length", ctypes.c_uint32), ("vectors", ctypes.POINTER(_Vector)),
        ("vector_count", ctypes.c_size_t), ("control", ctypes.c_void_p), ("control_length", ctypes.c_size_t),
        ("flags", ctypes.c_int), ("padding", ctypes.c_int), ("sent", ctypes.c_uint32),
    )  # fmt: skip


def packets(kind: str) -> list[bytes]:
    """Some hundreds of different datagrams."""
    chance = np.random.default_rng(11)
    if kind == "garbage":
        return [chance.bytes(int(chance.integers(1, 200))) for _ in range(480)]
    controls = [control for control in REGISTRY if control.value == 1 and control.address.startswith("/dance/light")]
    controls += [control for control in REGISTRY if control.address.startswith("/dance/pass/")]
    controls = [control for control in controls if control.value == 1 and control.arguments[0].type == "float"][:60]
    rows = []
    for turn in range(8):
        for control in controls:
            low, high = control.arguments[0].minimum, control.arguments[0].maximum
            rows.append(encode(control.address, (low + (high - low) * (turn + 1) / 10.0,)))
    return rows


def batches(rows: list[bytes]) -> "list[ctypes.Array[_Header]]":
    """The datagrams as sendmmsg takes them."""
    made = []
    for start in range(0, len(rows) - BATCH + 1, BATCH):
        vectors = (_Vector * BATCH)(*[_Vector(row, len(row)) for row in rows[start : start + BATCH]])
        headers = (_Header * BATCH)()
        for index in range(BATCH):
            headers[index].vectors, headers[index].vector_count = ctypes.pointer(vectors[index]), 1
        made.append(headers)
    return made


def main(kind: str, port: int, rate: float, seconds: float) -> int:
    """Send at an even rate; how many went out."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
    sock.connect(("127.0.0.1", port))
    call = ctypes.CDLL(None).sendmmsg
    made, sent = batches(packets(kind)), 0
    begin = time.perf_counter()
    while (gone := time.perf_counter() - begin) < seconds:
        while sent < gone * rate:
            count = call(sock.fileno(), made[(sent // BATCH) % len(made)], BATCH, 0)
            sent += max(count, 0)
        time.sleep(0.0005)
    return sent


if __name__ == "__main__":
    print(main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])), flush=True)
