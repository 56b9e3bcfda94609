"""A gateway in the test's process, the show's end of its socket, and phones built on aiohttp."""

import asyncio
import contextlib
import json
import socket
import struct
import time

import aiohttp

from live.base.system.channel import MAX_PACKET_BYTES
from live.control.audience.gateway import Gateway
from live.control.audience.phone_registry import ticket_key
from live.control.audience.session_state import BeatClock, Rules
from live.control.audience.uplink import ShowUplink
from live.control.message_codec import decode_packet, encode_packet

SECRET = b"s" * 32
CODE_S = 30.0


class LocalChannel:
    """The interface of HelperChannel without a process."""

    def __init__(self, theirs, plan):
        self.socket, self.plan, self.closed = theirs, plan, False

    def packets(self):
        while not self.closed:
            try:
                data = self.socket.recv(MAX_PACKET_BYTES)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                self.closed = True
                return
            yield decode_packet(data)

    def send_facts(self, facts):
        self.socket.send(encode_packet(facts))


class FakeShow:
    """The show's end of the socket: sends packets and collects what the gateway sends."""

    def __init__(self, ours, origin):
        self._ours, self._origin = ours, origin
        self.facts, self.heard, self.code = {}, [], ()

    def now(self):
        return time.perf_counter() - self._origin

    def tell(self, *packets):
        for packet in packets:
            self._ours.send(encode_packet(packet))

    def look(self):
        """Reads all received packets; returns itself."""
        with contextlib.suppress(BlockingIOError):
            while True:
                packet = decode_packet(self._ours.recv(MAX_PACKET_BYTES))
                if isinstance(packet, dict):
                    self.facts = packet
                elif packet[0] == "code":
                    self.code = packet[1:]
                else:
                    self.heard.append(packet)
        return self


@contextlib.asynccontextmanager
async def open_gateway(**plan):
    """Yields (gateway, show, address); ends as it does when the show ends."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listening = socket.create_server(("127.0.0.1", 0), backlog=64)
    for each in (ours, theirs, listening):
        each.setblocking(False)
    address = f"http://127.0.0.1:{listening.getsockname()[1]}"
    origin = time.perf_counter() - 1000.0
    usual = {"secret": SECRET, "first": 1, "link": address, "most": 64, "per_address": 4, "visible": 8}
    usual |= {"network": "behind nat"}
    told = LocalChannel(theirs, {**usual, "origin": origin, **plan})
    gateway, show = Gateway(ShowUplink(told, told.plan), told.plan), FakeShow(ours, origin)
    show.tell(Rules(regions=("left", "right"), weights=(1.0, 1.0)), BeatClock(time=100.0, beat=0.0))
    running = asyncio.create_task(gateway.run(listening))
    try:
        await until(lambda: show.look().code)
        yield gateway, show, address
    finally:
        ours.close()
        await asyncio.wait_for(running, 20.0)
        theirs.close()
        listening.close()


async def until(what, seconds=20.0):
    """Waits until a condition is true, with a deadline."""
    deadline = time.monotonic() + seconds
    while not (found := what()):
        assert time.monotonic() < deadline, "waited in vain"
        await asyncio.sleep(0.005)
    return found


class FakePhone:
    """A phone that behaves as the page does."""

    def __init__(self, session, address):
        self._session, self._address = session, address
        self.token, self.number, self.said, self.no = "", 0, {}, ""
        self.voucher, self.wait = "", 0.0

    async def join(self, key=None, token=None, region=0, origin=None, voucher=None, headers=None):
        """Sends hello; returns itself once it is answered."""
        headers = {"Origin": origin or self._address} | (headers or {})
        self.number, self.no = 0, ""
        self.ws = await self._session.ws_connect(self._address + "/ws", headers=headers)
        hello = {"r": region} | ({"k": key} if key else {}) | ({"t": token} if token else {})
        hello |= {"v": voucher} if voucher else {}
        await self.ws.send_str(json.dumps(hello))
        while not self.number and not self.no:
            if (await self.hear()).type is not aiohttp.WSMsgType.TEXT:
                raise ConnectionError("closed without an answer")
        return self

    async def hear(self):
        """Receives one message; ConnectionError after the last one, so that no test waits for more without an end."""
        if self.ws.closed:
            raise ConnectionError("closed")
        message = await self.ws.receive(timeout=20.0)
        if message.type is aiohttp.WSMsgType.TEXT:
            said = json.loads(message.data)
            self.said |= said
            if "w" in said:
                self.token, self.number = said["w"][:2]
            self.no, self.wait = said.get("no", self.no), said.get("in", self.wait)
            self.voucher = said.get("v", self.voucher)
        return message

    async def touch(self, mode, x, z):
        await self.ws.send_bytes(struct.pack("<BBHH", 1, mode, round(x * 65535), round(z * 65535)))


def current_key(show):
    """The key of the current join link."""
    return ticket_key(SECRET, int(show.now() // CODE_S))
