"""HTTP handlers of the gateway: the phones' page, and each phone's WebSocket from connection to disconnection.

The page is one file, prepared once in each language. Its headers forbid all other content.
"""

import asyncio
import base64
import contextlib
import gzip
import hashlib
import hmac
import json
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.control.audience import phone_protocol as wire
from live.control.audience.admission import OWN_WIFI, JoinAnswer
from live.control.audience.arp_table import ArpTable
from live.control.audience.broadcaster import Broadcaster
from live.control.audience.client_address import Proxies, group_of, parse_address
from live.control.audience.phone_registry import Device, Phone, group_number, hue_of, token_of, verify_token
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import SessionState
from live.control.audience.websocket_reader import WebSocketReader
from live.control.web.http_protection import is_local_host

_FOLDER: Final = Path(__file__).parent
SCRIPTS: Final = ("page.js", "page_stage.js")
WORDS: Final[dict[str, Any]] = json.loads((_FOLDER / "page_words.json").read_text("utf-8"))
"""The page's texts by language; the first is used where none fits."""
LANGUAGES: Final = tuple(WORDS)


def page_text() -> str:
    """Return the page, one file: its markup and style, its texts in all languages, and its script."""
    words = json.dumps(WORDS, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    script = "".join((_FOLDER / name).read_text("utf-8") for name in SCRIPTS)
    text = (_FOLDER / "page.html").read_text("utf-8")
    for place, part in (("/*words*/", words), ("/*script*/\n", script)):
        before, _, after = text.partition(place)
        text = before + part + after
    return text


class Pages:
    """The phones' page in all languages. Thread: one."""

    def __init__(self, link: str) -> None:
        """`link`: the address that phones open."""
        self.host = link.partition("://")[2].partition("/")[0].rpartition("@")[2]
        text = page_text()
        self._pages = {}
        for language in LANGUAGES:
            page = text.replace('<html lang="en"', f'<html lang="{language}"', 1).encode()
            self._pages[language] = (page, gzip.compress(page, 9, mtime=0))
        hashes = [_csp_hash(found) for found in re.findall(r"<script>(.*?)</script>", text, re.S)]
        styles = [_csp_hash(found) for found in re.findall(r"<style>(.*?)</style>", text, re.S)]
        policy = (
            f"default-src 'none'; script-src {' '.join(hashes)}; style-src {' '.join(styles)}; "
            "connect-src 'self' ws: wss:; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        self._headers = {
            "Content-Security-Policy": policy, "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
            "Vary": "Accept-Language, Accept-Encoding", "Cache-Control": "max-age=60",
        }  # fmt: skip

    def answer(self, request: web.Request) -> web.Response:
        """Return the page in the browser's preferred language."""
        plain, packed = self._pages[language_of(request.headers.get("Accept-Language", ""))]
        headers = self._headers
        if "gzip" in request.headers.get("Accept-Encoding", ""):
            headers, plain = headers | {"Content-Encoding": "gzip"}, packed
        return web.Response(body=plain, content_type="text/html", charset="utf-8", headers=headers)


def language_of(accepted: str) -> str:
    """Return the page language for an Accept-Language header (RFC 9110, 12.5.4); English if none matches."""
    best, found = 0.0, LANGUAGES[0]
    for index, part in enumerate(accepted[:400].split(",")[:20]):
        tag, _, rest = part.strip().partition(";")
        name = tag.strip().partition("-")[0].casefold()
        match = re.fullmatch(r"\s*q=([01](?:\.\d{0,3})?)\s*", rest) if rest else None
        weight = (float(match[1]) if match else 1.0 if not rest else 0.0) - 1e-4 * index
        if name in LANGUAGES and weight > best:
            best, found = weight, name
    return found


def _csp_hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


HELLO_TIMEOUT: Final = 5.0
"""Time for a new connection to request a page or identify itself [s], including headers."""
SPARE_CONNECTIONS: Final = 16
"""Connections of one address in addition to those of its phones."""
MOST_OF_ADDRESS: Final = 1024
"""Maximum unidentified connections of one address on any network; configured proxies are not limited."""
MAX_UNIDENTIFIED: Final = 512
"""Maximum unidentified connections in total."""


class HttpServer:
    """Request handlers of the gateway. Thread: the gateway's loop."""

    def __init__(self, session: SessionState, broadcaster: Broadcaster, secret: bytes, plan: dict[str, Any]) -> None:
        """`plan`: the link that phones open, and the kind of network."""
        self._session, self._broadcaster, self._secret = session, broadcaster, secret
        self._pages = Pages(str(plan["link"]))
        self._proxies = Proxies(plan.get("proxies", ()))
        own = plan.get("network", OWN_WIFI) == OWN_WIFI and bool(plan.get("by_card", True))
        self._neighbours = ArpTable(secret) if own else None
        of_group = int(plan["per_address"]) if session.admission.has_groups else MOST_OF_ADDRESS
        self._max_per_address = min(of_group, MOST_OF_ADDRESS) + SPARE_CONNECTIONS
        self._first_seen: dict[Any, float] = {}
        self._upgraded: set[Any] = set()
        self._unidentified: Counter[int] = Counter()

    async def answer(self, request: web.Request) -> web.StreamResponse:
        """Answer with a page, or accept a phone's WebSocket."""
        if not is_local_host(request.headers.get("Host", ""), self._pages.host):
            return self._refuse(RefusalReason.HOST, 403)
        if request.path == "/ws" and request.headers.get("Upgrade", "").lower() == "websocket":
            return await self._accept(request)
        if request.path != "/" or request.method not in ("GET", "HEAD"):
            return self._refuse(RefusalReason.PATH, 404)
        page = self._pages.answer(request)
        page.force_close()  # the WebSocket follows on a connection of its own
        return page

    def _refuse(self, why: RefusalReason, status: int) -> web.Response:
        self._session.refused[why] += 1
        response = web.Response(status=status, headers={"Retry-After": "5"} if status == 503 else None)
        response.force_close()
        return response

    async def _group(self, request: web.Request) -> int:
        """Return the sender's group as a keyed hash: of the network card if it is known, else of the address."""
        headers = request.headers
        address = self._proxies.sender(
            request.remote or "", headers.getall("X-Forwarded-For", ()), headers.getall("Forwarded", ())
        )
        card = ""
        if self._neighbours is not None and address is not None:
            card = await self._neighbours.card_of(address)
        return group_number(self._secret, card or group_of(address))

    def _browser(self, request: web.Request) -> int:
        """Return a keyed hash of the browser's identification."""
        words = "\n".join(request.headers.get(name, "")[:400] for name in ("User-Agent", "Accept-Language"))
        digest = hmac.new(self._secret, f"browser {words}".encode("utf-8", "replace"), hashlib.sha256).digest()
        return int.from_bytes(digest[:6], "big")

    async def _accept(self, request: web.Request) -> web.StreamResponse:
        if request.headers.get("Origin", "").partition("://")[2] != request.headers.get("Host", ""):
            return self._refuse(RefusalReason.ORIGIN, 403)
        if len(self._upgraded) >= self._session.phones.most + MAX_UNIDENTIFIED:
            return self._refuse(RefusalReason.FULL, 503)
        group = await self._group(request)
        if self._unidentified[group] >= self._max_per_address:
            return self._refuse(RefusalReason.ADDRESS, 503)
        ws = web.WebSocketResponse(max_msg_size=wire.MAX_HELLO_CHARS, compress=False, timeout=2.0)
        await ws.prepare(request)
        transport = request.transport
        self._upgraded.add(transport)
        phone: Phone | None = None
        try:
            phone = await self._identify(ws, request, group)
            if phone is not None:
                await phone.disconnected
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            self._upgraded.discard(transport)
            if phone is not None:
                self._session.disconnect(phone)
            with contextlib.suppress(ConnectionError, RuntimeError):
                await ws.close()
        return ws

    async def _identify(self, ws: web.WebSocketResponse, request: web.Request, group: int) -> Phone | None:
        """Identify and welcome a phone; None if it may not join, in which case it gets the reason."""
        hall = self._session
        self._unidentified[group] += 1
        try:
            first = await asyncio.wait_for(ws.receive(), HELLO_TIMEOUT)
        except TimeoutError:
            hall.refused[RefusalReason.SILENT] += 1
            return None
        finally:
            self._unidentified[group] -= 1
            if not self._unidentified[group]:
                del self._unidentified[group]
        hello = wire.parse_hello(first.data) if first.type is WSMsgType.TEXT else None
        if hello is None:
            if first.type in (WSMsgType.TEXT, WSMsgType.BINARY):
                hall.refused[RefusalReason.MALFORMED] += 1
            elif first.type is WSMsgType.ERROR:
                hall.refused[RefusalReason.LONG] += 1
            return None
        known = verify_token(self._secret, hello.token) if hello.token else None
        answer = self._admit(hello, known, group)
        number = hall.phones.numbers.take() if known is None and answer.why is None else 0
        if answer.why is None and number is not None:
            device = known if known is not None else Device(number, answer.ticket, group)
            phone = hall.enter(
                device, hello.region, group, self._browser(request), ws, request.transport, fresh=known is None
            )
            if phone is not None:
                reading = WebSocketReader(hall, phone, request.protocol)
                phone.disconnected = reading.disconnected
                phone.transport.set_protocol(reading)
                await self._welcome(phone, device)
                return phone
        if answer.why is None:
            answer = JoinAnswer(RefusalReason.FULL, HELLO_TIMEOUT)
        assert answer.why is not None
        hall.refused[answer.why] += 1
        told = {"no": answer.why.name.lower(), "in": round(answer.wait, 2)}
        await ws.send_str(json.dumps(told | ({"v": answer.voucher} if answer.voucher else {})))
        return None

    def _admit(self, hello: wire.Hello, known: Device | None, group: int) -> JoinAnswer:
        """Decide whether a phone may join, and when if not now."""
        hall = self._session
        if known is not None:
            return (
                JoinAnswer() if known.number in hall.phones.by_number else hall.admission.admit_known(group, hall.now())
            )
        answer = hall.admission.admit_new(hello.key, hello.voucher, group, hall.now())
        if answer.why is RefusalReason.ADDRESS:
            hall.update_shares(group)  # the group may be crowded now
        return answer

    async def _welcome(self, phone: Phone, device: Device) -> None:
        hall, number = self._session, phone.number
        every = self._broadcaster.touch_interval()
        region = int(hall.voices.region[phone.row])
        token = token_of(self._secret, device)
        await phone.ws.send_str(json.dumps({"w": [token, number, hue_of(number), every, region]}))
        for words in self._broadcaster.current_messages():
            await phone.ws.send_str(words)

    def sweep(self, connections: Sequence[Any]) -> None:
        """Close connections that request nothing, are too slow, or exceed their address's limit."""
        now, met, of_address = self._session.now(), {}, Counter[str]()
        for each in connections:
            transport = each.transport
            if transport is None or transport in self._upgraded:
                continue
            met[transport] = self._first_seen.get(transport, now)
            address = str((transport.get_extra_info("peername") or ("",))[0])
            of_address[address] += 1
            many = of_address[address] > self._max_per_address and not self._proxies.is_proxy(parse_address(address))
            if many or now - met[transport] > HELLO_TIMEOUT:
                self._session.refused[RefusalReason.ADDRESS if many else RefusalReason.SILENT] += 1
                transport.abort()
        self._first_seen = met
