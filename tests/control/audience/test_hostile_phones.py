"""Hostile WebSocket traffic: each class is rejected or handled, leaves no state and does not affect good phones.

The classes are those of the design's survey (section 4.4); the mutations are seeded.
"""

import asyncio
import base64
import contextlib
import gc
import itertools
import json
import random
import struct
from collections import Counter

import aiohttp
import pytest
from aiohttp.http_exceptions import HttpProcessingError

from live.control.audience import phone_protocol as wire
from live.control.audience.http_server import language_of
from live.control.audience.phone_registry import Phone
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.websocket_reader import WebSocketReader
from live.control.web.http_protection import is_local_host
from tests.control.audience.made_gateway import FakePhone, current_key, open_gateway, until

MASK = b"\x11\x22\x33\x44"
ADDRESSES = (f"127.0.{k // 250 + 1}.{k % 250 + 1}" for k in itertools.count())
"""Each has its own, as in a hall."""


def frame(payload, opcode=2, *, fin=True, masked=True, length=None, reserved=0):
    """A WebSocket frame (RFC 6455), valid or invalid."""
    size = len(payload) if length is None else length
    head = bytes([(0x80 if fin else 0) | reserved | opcode])
    flag = 0x80 if masked else 0
    if size < 126:
        head += bytes([flag | size])
    elif size < 65536:
        head += bytes([flag | 126]) + struct.pack(">H", size)
    else:
        head += bytes([flag | 127]) + struct.pack(">Q", size)
    if not masked:
        return head + payload
    return head + MASK + bytes(byte ^ MASK[index & 3] for index, byte in enumerate(payload))


def hostile_frames(good):
    """Bytes sent after a valid handshake and hello, by class. `good`: a touch."""
    return {
        "a byte more than there may be": frame(b"x" * 257),
        "a length of 2^62": frame(b"", length=1 << 62),
        "text that is no UTF-8": frame(b"\xff\xfe\xfd", opcode=1),
        "not masked": frame(good, masked=False),
        "reserved opcode": frame(good, opcode=3),
        "reserved bits": frame(good, reserved=0x40),
        "a long control frame": frame(b"p" * 126, opcode=9),
        "a control frame in parts": frame(b"p", opcode=9, fin=False),
        "300 fragments": frame(b"x", fin=False) + b"".join(frame(b"x", opcode=0, fin=False) for _ in range(300)),
        "a fragment of nothing": frame(b"x", opcode=0),
        "words instead of bytes": b"".join(frame(b"<img onerror=x>", opcode=1) for _ in range(5)),
        "unknown verbs": b"".join(frame(bytes([verb]) * 6) for verb in (0, 6, 99, 255)),
        "verbs of other lengths": b"".join(frame(bytes([1]) * size) for size in (1, 5, 7, 200)),
        "empty messages": b"".join(frame(b"") for _ in range(5)),
        "a mode that is none": b"".join(frame(struct.pack("<BBHH", 1, 3 + n, 0, 0)) for n in range(5)),
        "a close that is none": frame(b"\x00", opcode=8),
        "half a frame, and gone": frame(good)[:5],
    }


HELLOS = (
    "", "{", "[]", "null", "1", '"x"', "{}", '{"k":1}', '{"k":"x","r":-1}', '{"k":"x","r":1e9}', '{"k":"x","r":true}',
    '{"k":"x","z":1}', '{"k":["x"]}', "[" * 200, '{"t":{}}', '{"k":"' + "x" * 240 + '"}', '{"k":"\\ud800"}', "\x00" * 8,
    '{"k":null}', '{"t":"1.' + "A" * 100 + '"}', "NaN", '{"k":"x","k":"y","r":64}',
    '{"v":7}', '{"v":"1.2.3.4.5"}', '{"v":"é"}',
)  # fmt: skip


def test_hello_messages_are_parsed_or_refused_without_exceptions():
    for text in HELLOS:
        hello = wire.parse_hello(text)
        assert hello is None or (len(hello.key) < 256 and 0 <= hello.region < 64 and hello.key.isascii())
    assert wire.parse_hello('{"k":"abc","r":3}') == wire.Hello("abc", "", "", 3)
    chance, good = random.Random(3), '{"t":"12.3.4.abcdefghijkl","v":"1.2.3.4.x","k":"ABCDEFGHIJKL","r":1}'
    for _ in range(2000):
        text = list(good)
        for _ in range(chance.randrange(1, 6)):
            text[chance.randrange(len(text))] = chr(
                chance.choice((0, 34, 39, 44, 58, 91, 123, 125, 0x202E, 0xD800, 65))
            )
        hello = wire.parse_hello("".join(text))
        assert hello is None or type(hello.region) is int


def test_well_formed_messages_have_the_declared_length():
    chance = random.Random(4)
    for _ in range(3000):
        data = chance.randbytes(chance.randrange(0, 12))
        if wire.is_well_formed(data):
            assert len(data) == wire.LENGTHS[data[0]]


def test_local_hosts_and_languages_are_recognized():
    good = (
        "localhost",
        "localhost:8020",
        "127.0.0.1:8020",
        "192.168.1.7",
        "[::1]:80",
        "stage.local:8020",
        "play.example",
    )
    assert all(is_local_host(host, "play.example") for host in good)
    bad = (
        "",
        "evil.example",
        "127.0.0.1.evil.example",
        "local",
        ".local",
        "a.b.local",
        "[::1",
        "1.2.3",
        "x" * 300,
        "é.local",
    )
    assert not any(is_local_host(host, "play.example") for host in bad)
    assert language_of("pt-BR, en;q=0.5") == language_of("sv, pt;q=0.1") == "pt"
    for rubbish in ("", ";;;", "pt;q=x", "q=1", "," * 1000, "en;q=0.9, pt;q=0.8", "pt;q=0"):
        assert language_of(rubbish) == "en"


async def send_raw(address, show, chunks, *, hello=True, wait=2.0):
    """Sends bytes after a valid handshake; returns once the other side has closed, or after `wait` seconds."""
    host, port = address.removeprefix("http://").split(":")
    reader, writer = await asyncio.open_connection(host, int(port), local_addr=(next(ADDRESSES), 0))
    name = base64.b64encode(b"k" * 16).decode()
    writer.write(
        f"GET /ws HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nOrigin: {address}\r\n"
        f"Sec-WebSocket-Key: {name}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), 20.0)
    if hello:
        writer.write(frame(json.dumps({"k": current_key(show)}).encode(), opcode=1))
        await asyncio.wait_for(reader.readuntil(b'{"w"'), 20.0)
    for chunk in chunks:
        writer.write(chunk)
    with contextlib.suppress(TimeoutError, ConnectionError):
        await asyncio.wait_for(reader.read(), wait)
    writer.close()


@pytest.mark.long
def test_malformed_traffic_is_refused_and_leaves_no_objects(caplog):
    failures = []

    async def test():
        asyncio.get_running_loop().set_exception_handler(lambda _loop, context: failures.append(context))
        async with (
            open_gateway(most=2000, network="own wifi") as (gateway, show, address),
            aiohttp.ClientSession() as session,
        ):
            good = await FakePhone(session, address).join(current_key(show))
            touch = struct.pack("<BBHH", 1, 1, 9, 9)
            corpus = hostile_frames(touch)
            await asyncio.gather(*(send_raw(address, show, [data], wait=0.5) for data in corpus.values()))
            hellos = [frame(text.encode("utf-8", "surrogatepass"), 1) for text in HELLOS]
            await asyncio.gather(*(send_raw(address, show, [data], hello=False) for data in hellos))
            chance = random.Random(11)
            seeds = [frame(touch) + frame(struct.pack("<Bd", 2, 1.0)), *corpus.values()]
            mutated = [_mutated(chance, chance.choice(seeds)[:600]) for _ in range(120)]
            for begin in range(0, len(mutated), 40):
                await asyncio.gather(*(send_raw(address, show, [d], wait=0.15) for d in mutated[begin : begin + 40]))
            await _send_bad_requests(address)
            refused = gateway.session.refused
            await until(lambda: len(gateway.session.phones) == 1)
            assert refused[RefusalReason.MALFORMED] > 30
            assert refused[RefusalReason.LONG] > 0
            await good.touch(1, 0.5, 0.5)  # the good phone plays on
            await until(lambda: any(packet[5] for packet in show.look().heard))
            for row, _ in gateway.session._disconnected.values():
                gateway.session.voices.remove(row)
            gateway.session._disconnected.clear()
            assert gateway.session.voices.count == 1
            await until(lambda: len(gateway._server._upgraded) == 1)
            await until(lambda: gc.collect() >= 0 and count_objects(Phone, WebSocketReader) == (1, 1), 20.0)

    asyncio.run(asyncio.wait_for(test(), 120.0))
    assert failures == []
    raised = [row.exc_info[0] for row in caplog.records if row.exc_info]
    assert all(issubclass(kind, HttpProcessingError) for kind in raised), raised  # requests that are none, refused


def count_objects(*kinds):
    """The number of live objects of each kind."""
    there = Counter(type(each) for each in gc.get_objects())
    return tuple(there[kind] for kind in kinds)


def _mutated(chance, data):
    data = bytearray(data)
    for _ in range(chance.randrange(1, 8)):
        at = chance.randrange(len(data))
        match chance.randrange(4):
            case 0:
                data[at] = chance.randrange(256)
            case 1:
                data[at] ^= 1 << chance.randrange(8)
            case 2 if len(data) > 4:
                del data[at : at + chance.randrange(1, 4)]
            case _:
                data[at:at] = chance.randbytes(chance.randrange(1, 9))
    return bytes(data)


def test_silent_connections_are_closed_under_load():
    async def test():
        async with open_gateway(network="own wifi") as (gateway, _show, address):
            host, port = address.removeprefix("http://").split(":")
            idle = [await asyncio.open_connection(host, int(port)) for _ in range(40)]
            await until(lambda: gateway.session.refused[RefusalReason.ADDRESS] >= 20)
            gateway._server._first_seen = dict.fromkeys(gateway._server._first_seen, -1e9)  # they have waited long
            await until(lambda: gateway.session.refused[RefusalReason.SILENT] >= 10)
            for _, writer in idle:
                writer.close()

    asyncio.run(asyncio.wait_for(test(), 60.0))


async def _send_bad_requests(address):
    """Requests that are malformed, too long or never complete."""
    host, port = address.removeprefix("http://").split(":")
    for request in (
        b"GET / HTTP/1.1\r\nHost: x\r\nA: " + b"x" * 9000 + b"\r\n\r\n",
        b"\x16\x03\x01\x02\x00",
        b"GET /",
        b"\r\n" * 50,
    ):
        reader, writer = await asyncio.open_connection(host, int(port))
        writer.write(request)
        with contextlib.suppress(TimeoutError, ConnectionError):
            await asyncio.wait_for(reader.read(4096), 0.1)
        writer.close()
