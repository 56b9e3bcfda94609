"""The door: pages for browsers, and the way of a phone from its connection until it has gone."""

import asyncio
import contextlib
import json
from collections import Counter
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.control.audience import wire
from live.control.audience.hall import Hall
from live.control.audience.pages import Pages
from live.control.audience.phones import Phone
from live.control.audience.reading import Reading
from live.control.audience.refused import Why
from live.control.audience.teller import Teller
from live.control.audience.tokens import hue_of, lets_in, number_of, token_of
from live.control.http_guard import is_ours

HELLO_WITHIN: Final = 5.0
"""Who has connected asks for a page, or says who it is, so soon [s]."""
SPARE: Final = 16
"""Connections of one address beside those of its phones."""
WAITING: Final = 256
"""Connections of those who have not said yet who they are."""


class Door:
    """Thread: the gateway's loop."""

    def __init__(self, hall: Hall, teller: Teller, secret: bytes, link: str) -> None:
        """`link`: the address that phones are given."""
        self._hall, self._teller, self._secret = hall, teller, secret
        self._pages = Pages(link)
        self._met: dict[Any, float] = {}
        self._upgraded: set[Any] = set()

    async def answer(self, request: web.Request) -> web.StreamResponse:
        """A page, or a phone that wants to play."""
        if not is_ours(request.headers.get("Host", ""), self._pages.host):
            return self._refuse(Why.HOST, 403)
        if request.path == "/ws" and request.headers.get("Upgrade", "").lower() == "websocket":
            return await self._connected(request)
        if request.path != "/" or request.method not in ("GET", "HEAD"):
            return self._refuse(Why.PATH, 404)
        return self._pages.answer(request)

    def _refuse(self, why: Why, status: int) -> web.Response:
        self._hall.refused[why] += 1
        return web.Response(status=status, headers={"Retry-After": "5"} if status == 503 else None)

    async def _connected(self, request: web.Request) -> web.StreamResponse:
        if request.headers.get("Origin", "").partition("://")[2] != request.headers.get("Host", ""):
            return self._refuse(Why.ORIGIN, 403)
        if len(self._upgraded) >= self._hall.phones.most + WAITING:
            return self._refuse(Why.FULL, 503)
        ws = web.WebSocketResponse(max_msg_size=wire.LONGEST, compress=False, timeout=2.0)
        await ws.prepare(request)
        transport = request.transport
        self._upgraded.add(transport)
        phone: Phone | None = None
        try:
            phone = await self._greeted(ws, request)
            if phone is not None:
                await phone.gone
        except (ConnectionError, RuntimeError):  # it has gone meanwhile
            pass
        finally:
            self._upgraded.discard(transport)
            if phone is not None:
                self._hall.part(phone)
            with contextlib.suppress(ConnectionError, RuntimeError):
                await ws.close()
        return ws

    async def _greeted(self, ws: web.WebSocketResponse, request: web.Request) -> Phone | None:
        """Who it is, and welcome; None if it may not play, which it is told."""
        hall = self._hall
        try:
            first = await asyncio.wait_for(ws.receive(), HELLO_WITHIN)
        except TimeoutError:
            hall.refused[Why.SILENT] += 1
            return None
        hello = wire.hello_of(first.data) if first.type is WSMsgType.TEXT else None
        if hello is None:
            if first.type in (WSMsgType.TEXT, WSMsgType.BINARY):
                hall.refused[Why.MALFORMED] += 1
            elif first.type is WSMsgType.ERROR:
                hall.refused[Why.LONG] += 1
            return None
        address, now = request.remote or "", hall.now()
        number = number_of(self._secret, hello.token) if hello.token else 0
        why = self._may_enter(hello, number, address, now)
        if why is None:
            if not number:
                number, hall.phones.next = hall.phones.next, hall.phones.next + 1
            phone = hall.enter(number, hello.region, address, ws, request.transport)
            if phone is not None:
                reading = Reading(hall, phone, request.protocol)
                phone.gone = reading.gone
                phone.transport.set_protocol(reading)
                await self._welcome(phone)
                return phone
            why = Why.FULL
        hall.refused[why] += 1
        await ws.send_str(json.dumps({"no": why.name.lower()}))
        return None

    def _may_enter(self, hello: wire.Hello, number: int, address: str, now: float) -> Why | None:
        """Why not; None if it may."""
        if not number and not (hello.key and lets_in(self._secret, hello.key, now)):
            return Why.LINK if hello.key else Why.TOKEN
        if number in self._hall.phones.by_number:
            return None
        return self._hall.phones.may_join(address, now, fresh=not number)

    async def _welcome(self, phone: Phone) -> None:
        hall, number = self._hall, phone.number
        every = self._teller.every()
        region = int(hall.voices.region[phone.row])
        token = token_of(self._secret, number)
        await phone.ws.send_str(json.dumps({"w": [token, number, hue_of(number), every, region]}))
        for words in self._teller.present():
            await phone.ws.send_str(words)

    def sweep(self, connections: list[Any]) -> None:
        """Close those of the `connections` that ask for nothing, or too slowly, or are too many of one address."""
        now, met, of_address = self._hall.now(), {}, Counter[str]()
        for each in connections:
            transport = each.transport
            if transport is None or transport in self._upgraded:
                continue
            met[transport] = self._met.get(transport, now)
            address = str((transport.get_extra_info("peername") or ("",))[0])
            of_address[address] += 1
            many = of_address[address] > self._hall.phones.per_address + SPARE
            if many or now - met[transport] > HELLO_WITHIN:
                self._hall.refused[Why.ADDRESS if many else Why.SILENT] += 1
                transport.abort()
        self._met = met
