"""A process of many phones: `python -m bench._phones PORT KEY COUNT STORM SECONDS RATE [SOCKETS FIRST X]`; prints a
line of JSON.

They join evenly within STORM seconds, come again when they are told to as the page does, then each says RATE times a
second where its finger is (about X, the stage's width being 1), and pings every other second instead. SOCKETS of them
have one address, from the FIRST of 127.0.0.0/8 on; 0: all of them have this machine's. Raw sockets and ready frames, so
that the load leaves room for who is loaded.
"""

import asyncio
import base64
import json
import os
import random
import struct
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import psutil

PATIENCE = 20
"""So often a phone comes again ..."""
GIVES_UP = 40.0
"""... unless it would have to wait longer than so [s] in all."""
STAYS = 15.0
"""Who is in says so at this interval [s] until all are."""
MASK = b"\x11\x22\x33\x44"


def frame(payload: bytes, opcode: int = 2) -> bytes:
    """A client's frame of a short message."""
    return bytes([0x80 | opcode, 0x80 | len(payload)]) + MASK + bytes(b ^ MASK[i & 3] for i, b in enumerate(payload))


class NotNow(Exception):
    """The door says no, or when to come again."""

    def __init__(self, said: dict[str, Any]) -> None:
        super().__init__(said["no"])
        self.wait, self.voucher = float(said["in"]), str(said.get("v", ""))


class Phone(asyncio.Protocol):
    """One phone; it learns from its own pings how long a message takes."""

    trips: list[float]
    frames = 0
    """Frames of the stage that have come ..."""
    frame_bytes = 0
    """... and their bytes."""

    def __init__(self, port: int, hello: bytes, trips: list[float], began: float) -> None:
        self._port, self._hello, self._trips = port, hello, trips
        self._data = b""
        self._open = False
        self._began = began
        self.joined: asyncio.Future[float] = asyncio.get_running_loop().create_future()
        self.lost = False

    def connection_made(self, transport: Any) -> None:
        """Ask for the WebSocket."""
        self.transport = transport
        key = base64.b64encode(os.urandom(16)).decode()
        where = f"127.0.0.1:{self._port}"
        transport.write(
            f"GET /ws HTTP/1.1\r\nHost: {where}\r\nOrigin: http://{where}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )

    def data_received(self, data: bytes) -> None:
        """Take up whole frames."""
        now = time.perf_counter()
        self._data += data
        if not self._open:
            head, found, rest = self._data.partition(b"\r\n\r\n")
            if not found:
                return
            self._open, self._data = b" 101 " in head[:20], rest
            self.transport.write(frame(self._hello, 1))
        while len(self._data) >= 2:
            size, begin = self._data[1] & 127, 2
            if size == 126:
                size, begin = int.from_bytes(self._data[2:4], "big"), 4
            if len(self._data) < begin + size:
                return
            payload, self._data = self._data[begin : begin + size], self._data[begin + size :]
            if payload[:1] == b"\x02" and size == 17:
                self._trips.append(now - struct.unpack_from("<d", payload, 1)[0])
            elif payload[:1] == b"\x06":
                self.frames += 1
                self.frame_bytes += begin + size
            elif payload[:4] == b'{"w"' and not self.joined.done():
                self.joined.set_result(now - self._began)
            elif payload[:5] == b'{"no"' and not self.joined.done():
                self.joined.set_exception(NotNow(json.loads(payload)))

    def connection_lost(self, error: Exception | None) -> None:
        """It was cut off."""
        self.lost = True
        if not self.joined.done():
            self.joined.set_exception(error or ConnectionError("refused"))


def address_of(index: int, sockets: int, first: int) -> str:
    """The address of a phone."""
    if not sockets:
        return "127.0.0.1"
    number = first + index // sockets
    return f"127.{number // 62500 % 250 + 1}.{number // 250 % 250 + 1}.{number % 250 + 1}"


async def stay(phones: list[Phone]) -> None:
    """Let phones ping as the page does, or the first would be cut off before the last are in."""
    while True:
        await asyncio.sleep(STAYS)
        for phone in phones:
            if not phone.lost:
                phone.transport.write(frame(struct.pack("<Bd", 2, time.perf_counter())))


async def run(
    port: int, key: str, count: int, storm: float, seconds: float, rate: float, sockets: int, first: int, x_at: float
) -> dict[str, Any]:
    """The storm, then the load."""
    loop, trips, phones = asyncio.get_running_loop(), list[float](), list[Phone]()

    async def join(index: int) -> float | None:
        await asyncio.sleep(storm * index / count)
        began, voucher = time.perf_counter(), ""
        hello = {"k": key}
        for _ in range(PATIENCE):
            words = json.dumps(hello | ({"v": voucher} if voucher else {})).encode()
            try:
                _, phone = await loop.create_connection(
                    partial(Phone, port, words, trips, began), "127.0.0.1", port,
                    local_addr=(address_of(index, sockets, first), 0),
                )  # fmt: skip
                way = await asyncio.wait_for(phone.joined, 10.0)
            except NotNow as told:
                phone.transport.close()
                voucher = told.voucher or voucher
                if not told.wait or time.perf_counter() + told.wait - began > GIVES_UP:
                    return None
                await asyncio.sleep(told.wait)
            except (OSError, TimeoutError):
                return None
            else:
                phones.append(phone)
                return way
        return None

    staying = asyncio.ensure_future(stay(phones))
    came = [way for way in await asyncio.gather(*map(join, range(count))) if way is not None]
    staying.cancel()
    trips.clear()
    print("joined", flush=True)
    chance, sent = random.Random(5), 0
    centre = [(chance.gauss(x_at, 0.05), chance.gauss(0.5, 0.05)) for _ in phones]
    began, spent = time.perf_counter(), psutil.Process().cpu_times()
    had = np.array([(phone.frames, phone.frame_bytes) for phone in phones]).reshape(-1, 2)
    due = [(k / max(len(phones), 1)) / rate for k in range(len(phones))]
    write: list[Callable[[bytes], None]] = [phone.transport.write for phone in phones]
    turn = 0
    while (gone := time.perf_counter() - began) < seconds:
        for k, at in enumerate(due):
            if at > gone or phones[k].lost:
                continue
            due[k] += 1.0 / rate
            sent += 1
            if (round(at * rate) + k) % round(2.0 * rate) == 0:
                write[k](frame(struct.pack("<Bd", 2, time.perf_counter())))
            else:
                x, z = centre[k]
                x += 0.05 * np.sin(gone + k)
                touch = struct.pack("<BBHH", 1, 1, int(min(max(x, 0), 1) * 65535), int(min(max(z, 0), 1) * 65535))
                write[k](frame(touch))
        turn += 1
        await asyncio.sleep(0.002)
    took, now = time.perf_counter() - began, psutil.Process().cpu_times()
    frames = np.array([(phone.frames, phone.frame_bytes) for phone in phones]).reshape(-1, 2) - had
    await asyncio.sleep(0.5)
    tell = {
        "joined": len(came), "join_p99_ms": 1e3 * float(np.percentile(came, 99)) if came else 0.0, "sent": sent,
        "longest_s": max(came, default=0.0),
        "rate": sent / took, "cpu": (now.user + now.system - spent.user - spent.system) / took,
        "trip_p50_ms": 1e3 * float(np.percentile(trips, 50)) if trips else 0.0,
        "trip_p99_ms": 1e3 * float(np.percentile(trips, 99)) if trips else 0.0,
        "frames": float(np.median(frames[:, 0])) / took if len(frames) else 0.0,
        "frame_bytes": float(frames[:, 1].sum() / max(frames[:, 0].sum(), 1)),
        "lost": sum(phone.lost for phone in phones),
    }  # fmt: skip
    for phone in phones:
        phone.transport.close()
    return tell


def main() -> None:
    """What the command line asks for."""
    import resource

    port, key, count = int(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(count + 256, hard), hard))
    storm, seconds, rate = map(float, sys.argv[4:7])
    sockets, first, x_at = (int(sys.argv[7]), int(sys.argv[8]), float(sys.argv[9])) if sys.argv[7:] else (0, 0, 0.7)
    try:
        import uvloop

        make = uvloop.new_event_loop
    except ImportError:
        make = asyncio.new_event_loop  # type: ignore[assignment]
    with asyncio.Runner(loop_factory=make) as runner:
        print(json.dumps(runner.run(run(port, key, count, storm, seconds, rate, sockets, first, x_at))), flush=True)


if __name__ == "__main__":
    main()
