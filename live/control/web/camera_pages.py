"""The camera page: a phone or tablet sees a dancer, and tells the show her joints.

The pose model (`@mediapipe/pose`, Apache-2.0) runs in the browser. Its files come from here, by fixed names, so that no
other server is asked. Over the WebSocket come landmark packets (`live.control.camera.phone_landmarks`), which are
checked, limited and counted; there is no message for a picture. The page's key permits this page alone.
"""

import asyncio
import contextlib
import gzip
import hashlib
import hmac
import json
import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from aiohttp import WSMsgType, web

from live.control.audience.rate_limit import TokenBucket
from live.control.camera.model_files import PHONE_FILES
from live.control.camera.phone_landmarks import MAX_TIME, PACKET_BYTES, decode_landmarks
from live.control.web.http_protection import HEARTBEAT, SECURITY_HEADERS, BoundedServer, FailedKeys, page_headers
from live.control.web.web_key import PROTOCOL, has_key

CAMERA_PATH: Final = "/camera"
STREAM_PATH: Final = "/camera/stream"
MODEL_PATH: Final = "/camera/model/"
_FOLDER: Final = Path(__file__).parent
_TYPES: Final = {".js": "text/javascript", ".wasm": "application/wasm"}
MODEL_FILES: Final = {name: _TYPES.get(Path(name).suffix, "application/octet-stream") for name in PHONE_FILES}
"""The model's files and their content types."""
DOWNLOAD_TIMEOUT: Final = 90.0
"""Time for one of these files on a slow network [s]."""
MAX_PHONES: Final = 8
MAX_MESSAGE_BYTES: Final = 512
PACKETS_PER_SECOND: Final = 45.0
"""Packets per second of a phone; the page sends 30. More are left out."""
TEXTS_PER_SECOND: Final = 10.0
MAX_LEFT_OUT: Final = 300
"""A phone from which so many messages more were refused than were good is disconnected."""
MAX_DELAY: Final = 5.0
"""Longest time from the capture to the arrival of a packet [s]; an older one comes from a wrong clock. Whether
a dancer's pose is still of use is the handler's to say."""
MAX_AHEAD: Final = 0.1
"""Most by which a capture may be after its arrival, as clocks are estimated [s]."""
RATE_WINDOW: Final = 2.0


def camera_key(key: bytes) -> str:
    """Return the key of the camera page, made of that of the operator's page; it permits nothing else."""
    return hmac.new(key, b"camera of a phone", hashlib.sha256).hexdigest()[:32]


def camera_page() -> str:
    """Return the page, one file."""
    script = (_FOLDER / "camera_page.js").read_text("utf-8")
    before, _, after = (_FOLDER / "camera_page.html").read_text("utf-8").partition("/*script*/\n")
    return before + script + after


@dataclass(frozen=True, slots=True)
class _ModelFile:
    plain: bytes
    compressed: bytes | None
    tag: str


class ModelFiles:
    """The model's files, read when a phone first asks for them, and kept. Thread: the loop's."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._files = folder, dict[str, _ModelFile]()

    async def answer(self, request: web.BaseRequest, name: str) -> web.Response:
        """Answer a request for one of `MODEL_FILES`."""
        if name not in self._files:
            try:
                self._files[name] = await asyncio.to_thread(self._read, name)
            except OSError:
                return web.Response(status=404, headers=SECURITY_HEADERS)
        file = self._files[name]
        headers = {
            **SECURITY_HEADERS, "Cache-Control": "private, max-age=86400", "ETag": file.tag, "Vary": "Accept-Encoding",
        }  # fmt: skip
        if request.headers.get("If-None-Match") == file.tag:
            return web.Response(status=304, headers=headers)
        body = file.plain
        if file.compressed is not None and "gzip" in request.headers.get("Accept-Encoding", "").casefold():
            body, headers = file.compressed, {**headers, "Content-Encoding": "gzip"}
        return web.Response(body=body, content_type=MODEL_FILES[name], headers=headers)

    def _read(self, name: str) -> _ModelFile:
        """Read and compress a file. Thread: any."""
        data = (self._folder / name).read_bytes()
        packed = None if name.endswith(".tflite") else gzip.compress(data, 6, mtime=0)
        return _ModelFile(data, packed, f'"{hashlib.sha256(data).hexdigest()[:24]}"')


@dataclass(eq=False)
class _Phone:
    """An open page."""

    name: str
    ws: web.WebSocketResponse
    performer: str = ""
    packets: TokenBucket = field(default_factory=lambda: TokenBucket(PACKETS_PER_SECOND, PACKETS_PER_SECOND))
    texts: TokenBucket = field(default_factory=lambda: TokenBucket(TEXTS_PER_SECOND, 2.0 * TEXTS_PER_SECOND))
    left_out: int = 0
    """Messages refused, less those that were good."""
    good: int = 0
    arrivals: list[float] = field(default_factory=list)
    """Of the packets of the last `RATE_WINDOW` seconds."""
    delay: float = math.nan
    seen: bool = False

    def facts(self, now: float) -> dict[str, Any]:
        """Return facts for the status at `now` [s]."""
        self.arrivals = [each for each in self.arrivals if now - each < RATE_WINDOW]
        delay = None if math.isnan(self.delay) else round(1e3 * self.delay)
        rate = round(len(self.arrivals) / RATE_WINDOW, 1)
        return {"phone": self.name, "performer": self.performer, "rate": rate, "delay_ms": delay, "seen": self.seen}


class CameraPages:
    """The camera page and the phones on which it is open. Thread: the loop's."""

    def __init__(self, plan: Mapping[str, Any], key: bytes, failed: FailedKeys, send: Callable[[object], bool]) -> None:
        """`plan`: of the web server, whose `camera` has the folder of the model and the performers, and is None where
        there is no such page; `key`: of the operator's page; `send`: to the show."""
        told = plan.get("camera")
        self._files = None if told is None else ModelFiles(Path(str(told["folder"])))
        self._performers: tuple[str, ...] = () if told is None else tuple(map(str, told["performers"]))
        self._origin = float(plan.get("origin", 0.0))
        self._keys = (camera_key(key).encode(), key) if key else ()
        self._failed, self._send = failed, send
        self._text = camera_page()
        self._phones: dict[str, _Phone] = {}
        self._refused: Counter[str] = Counter()

    def __contains__(self, path: object) -> bool:
        """Whether there is something at a path."""
        if self._files is None or not isinstance(path, str):
            return False
        return path in (CAMERA_PATH, STREAM_PATH) or path.removeprefix(MODEL_PATH) in MODEL_FILES

    def now(self) -> float:
        """Return the show's time [s]."""
        return time.perf_counter() - self._origin

    async def set_performers(self, names: Sequence[str]) -> None:
        """Use the performers of another patch."""
        self._performers = tuple(map(str, names))
        for phone in list(self._phones.values()):
            if phone.performer not in self._performers:
                phone.performer = ""
            with contextlib.suppress(ConnectionError, RuntimeError):
                await self._tell_performers(phone)

    async def answer(self, request: web.BaseRequest, server: BoundedServer) -> web.StreamResponse:
        """Answer a request, whose origin and method were checked, for a path that is here."""
        assert self._files is not None
        if request.path == CAMERA_PATH:
            return web.Response(text=self._text, content_type="text/html", headers=self._headers(request))
        if request.path != STREAM_PATH:
            server.allow(request, DOWNLOAD_TIMEOUT)
            return await self._files.answer(request, request.path.removeprefix(MODEL_PATH))
        if not any(has_key(request, key) for key in self._keys):
            return await self._failed.answer(request)
        if request.headers.get("Upgrade", "").casefold() != "websocket":
            return self._refuse("no web socket", 400)
        if len(self._phones) >= MAX_PHONES:
            return self._refuse("too many phones", 503)
        return await self._open(request, server)

    def _headers(self, request: web.BaseRequest) -> dict[str, str]:
        headers = page_headers(self._text, request.headers["Host"].casefold())
        policy = headers["Content-Security-Policy"].replace("script-src ", "script-src 'self' 'wasm-unsafe-eval' ", 1)
        return {**headers, "Content-Security-Policy": policy, "Permissions-Policy": "camera=(self), microphone=()"}

    def _refuse(self, why: str, status: int) -> web.Response:
        self._refused[why] += 1
        return web.Response(status=status, headers=SECURITY_HEADERS)

    async def _open(self, request: web.BaseRequest, server: BoundedServer) -> web.StreamResponse:
        ws = web.WebSocketResponse(
            max_msg_size=MAX_MESSAGE_BYTES, heartbeat=HEARTBEAT, compress=False, timeout=1.0, protocols=(PROTOCOL,)
        )
        await ws.prepare(request)
        server.release(request)
        free = (number for number in range(1, MAX_PHONES + 1) if f"phone {number}" not in self._phones)
        phone = _Phone(f"phone {next(free)}", ws)
        self._phones[phone.name] = phone
        try:
            await self._tell_performers(phone)
            async for message in ws:
                why = ""
                if message.type is WSMsgType.BINARY:
                    why = self._take_packet(phone, message.data)
                elif message.type is WSMsgType.TEXT:
                    why = await self._take_text(phone, message.data)
                if why:
                    self._refused[why] += 1
                    phone.left_out += 1
                    if phone.left_out > MAX_LEFT_OUT:
                        await ws.close(code=1008, message=b"too many refused packets")
                        break
                    if phone.texts.try_take(self.now()):
                        await ws.send_str(json.dumps({"refused": why}))
        except (ConnectionError, RuntimeError):  # disconnected meanwhile
            pass
        finally:
            del self._phones[phone.name]
        return ws

    async def _tell_performers(self, phone: _Phone) -> None:
        told = {"phone": phone.name, "performers": self._performers, "performer": phone.performer}
        await phone.ws.send_str(json.dumps(told))

    def _take_packet(self, phone: _Phone, data: bytes) -> str:
        """Send a packet to the show; return the reason of a refusal, or an empty string."""
        now = self.now()
        if not phone.packets.try_take(now):
            return "too many packets at once"
        if len(data) > PACKET_BYTES:
            return "wrong packet"
        try:
            picture = decode_landmarks(data)
        except ValueError:
            return "wrong packet"
        if not -MAX_AHEAD <= now - picture.time <= MAX_DELAY:
            return "wrong clock"
        if not phone.performer:
            return "no performer chosen"
        phone.left_out = max(phone.left_out - 1, 0)
        phone.good += 1
        phone.delay, phone.seen = now - picture.time, picture.landmarks is not None
        phone.arrivals.append(now)
        if len(phone.arrivals) > 2 * RATE_WINDOW * PACKETS_PER_SECOND:
            phone.arrivals = [each for each in phone.arrivals if now - each < RATE_WINDOW]
        if not self._send(["landmarks", phone.name, phone.performer, data, now]):
            self._refused["the show is busy"] += 1
        return ""

    async def _take_text(self, phone: _Phone, text: str) -> str:
        """Answer a ping, or note the performer; return the reason of a refusal, or an empty string."""
        now = self.now()
        if not phone.texts.try_take(now):
            return "too many messages at once"
        try:
            told = json.loads(text)
        except (ValueError, RecursionError):
            return "wrong message"
        match told:
            case {"ping": int() | float() as sent} if abs(sent) < MAX_TIME:
                await phone.ws.send_str(json.dumps({"pong": sent, "time": now}))
            case {"performer": str(name)} if name in self._performers:
                phone.performer = name
                await self._tell_performers(phone)
            case {"performer": str()}:
                return "no such performer"
            case _:
                return "wrong message"
        return ""

    async def close(self) -> None:
        """Close all pages."""
        closing = (phone.ws.close() for phone in list(self._phones.values()))
        await asyncio.gather(*closing, return_exceptions=True)

    def facts(self) -> dict[str, Any]:
        """Return facts for the status."""
        now = self.now()
        return {"open": [phone.facts(now) for phone in self._phones.values()], "refused": dict(self._refused)}
