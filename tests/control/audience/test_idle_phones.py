"""Tests of silent and slow phones and connections: bounded time and memory, and devices that keep their identity."""

import asyncio
import contextlib
import gc
import warnings

import aiohttp
import pytest

from live.control.audience.http_server import HELLO_TIMEOUT
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import ROW_KEPT_SECONDS, SILENCE_TIMEOUT
from tests.control.audience.made_gateway import FakePhone, current_key, open_gateway, until


def run(test, **plan):
    async def all_of_it():
        async with open_gateway(**plan) as (gateway, show, address), aiohttp.ClientSession() as session:
            await test(gateway, show, address, session)

    asyncio.run(asyncio.wait_for(all_of_it(), 60.0))


@pytest.mark.long
def test_silent_phone_is_disconnected_and_resumes_its_number():
    async def test(gateway, show, address, session):
        hall = gateway.session
        silent = [await FakePhone(session, address).join(current_key(show), region=1) for _ in range(8)]
        await silent[0].touch(1, 0.5, 0.5)
        await until(lambda: hall.voices.touching.any())
        hall._origin -= SILENCE_TIMEOUT - 5.0  # it has not waited long enough
        hall.sweep()
        assert len(hall.phones) == 8
        hall._origin -= 3600.0
        await until(lambda: len(hall.phones) == 0)
        assert hall.refused[RefusalReason.IDLE] == 8
        hall._origin -= ROW_KEPT_SECONDS + 1.0
        await until(lambda: hall.voices.count == 0)  # its voice is gone, and its row free
        assert not hall._disconnected
        hall._origin -= 3600.0
        again = await FakePhone(session, address).join(token=silent[0].token, region=1)
        assert again.number == silent[0].number
        assert hall.voices.region[hall.phones.by_number[again.number].row] == 1

    run(test, most=8)


@pytest.mark.long
def test_silent_phones_leave_no_growing_state():
    async def test(gateway, show, address, session):
        hall = gateway.session
        for turn in range(12):
            phones = [await FakePhone(session, address).join(gateway.session.tickets.key(hall.now())) for _ in range(4)]
            assert all(phone.number for phone in phones), turn
            hall._origin -= 3600.0
            hall.sweep()
            await until(lambda: len(hall.phones) == 0)
        hall._origin -= 3600.0
        hall.sweep()
        assert hall.voices.count == 0
        assert hall.phones.is_full(hall.now(), fresh=True) is False
        assert (hall.phones._kept, hall.phones._of_group, hall.phones._of_origin) == ({}, {}, {})
        assert (hall.tickets._spent, hall.tickets._used) == ({}, {})
        await until(lambda: not gateway._server._upgraded)
        assert not gateway._server._unidentified

    run(test, most=8)


async def open_slow_connection(address, words):
    """A connection that repeatedly sends `words` one byte at a time: (reader, writer, task)."""
    host, port = address.removeprefix("http://").split(":")
    reader, writer = await asyncio.open_connection(host, int(port))

    async def drip():
        with contextlib.suppress(ConnectionError):
            while True:
                for byte in words:
                    writer.write(bytes([byte]))
                    await writer.drain()
                    await asyncio.sleep(0.05)

    task = asyncio.create_task(drip())
    return reader, writer, task


def test_slow_headers_are_closed_after_hello_timeout():
    async def test(gateway, show, address, session):
        hall, met = gateway.session, gateway._server
        slow = [
            await open_slow_connection(address, b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"A: b\r\n" * 50)
            for _ in range(5)
        ]
        await until(lambda: len(met._first_seen) == 5)
        hall._origin -= HELLO_TIMEOUT + 1.0  # so long have they been dripping
        for reader, writer, task in slow:
            with contextlib.suppress(ConnectionError):
                assert await asyncio.wait_for(reader.read(), 20.0) == b""
            task.cancel()
            writer.close()
        assert hall.refused[RefusalReason.SILENT] >= 5
        async with session.get(address) as answer:
            await answer.read()
            assert answer.headers["Connection"] == "close"  # no connection is kept for what may come
        good = await FakePhone(session, address).join(current_key(show))
        assert good.number

    run(test)


@pytest.mark.long
def test_unidentified_sockets_of_one_address_do_not_block_others():
    async def test(gateway, show, address, session):
        own = aiohttp.ClientSession(connector=aiohttp.TCPConnector(local_addr=("127.0.9.9", 0), limit=0))
        headers = {"Origin": address}
        silent = [await own.ws_connect(address + "/ws", headers=headers) for _ in range(20)]
        for _ in range(20):
            with pytest.raises(aiohttp.WSServerHandshakeError, match="503") as told:
                await own.ws_connect(address + "/ws", headers=headers)
            assert told.value.headers["Retry-After"] == "5"
        assert len(silent) == 20
        assert (await FakePhone(session, address).join(current_key(show))).number
        await own.close()
        del told
        with warnings.catch_warnings():  # aiohttp's client leaves refused handshakes to the garbage collector
            warnings.simplefilter("ignore", ResourceWarning)
            gc.collect()

    run(test, network="own wifi")
