"""Phones that are cameras: their port, certificate and page, the packets that come in, and hostile phones."""

import asyncio
import contextlib
import json
import math
import ssl
import stat
import struct
from collections.abc import Awaitable, Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from live.app.launch_options import LaunchOptions
from live.app.services.phone_camera import RENEW_BEFORE, VALID, PhoneCameraPort, own_identity
from live.app.services.web_service import performers_of
from live.base.errors import PersonError
from live.control.camera.phone_landmarks import decode_landmarks
from live.control.web.camera_pages import MAX_PHONES, MODEL_FILES, camera_key
from live.show.patch.patch_reader import parse_patch
from tests.app.services.phone_show import KEY, PhoneShow, phone_show
from tests.control.camera.phone_packets import made_landmarks, phone_packet
from tests.control.waiting import wait_for
from tests.show.made_show import PATCH

TRUST = ssl.create_default_context()
TRUST.check_hostname, TRUST.verify_mode = False, ssl.CERT_NONE


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[PhoneShow]:
    with phone_show(tmp_path, monkeypatch) as running:
        yield running


def run(what: Callable[[aiohttp.ClientSession], Awaitable[None]]) -> None:
    async def all_of_it() -> None:
        loop: Any = asyncio.get_running_loop()
        before = len(loop._selector.get_map())
        async with aiohttp.ClientSession(connector=aiohttp.TCPConnector(ssl=TRUST)) as session:
            await what(session)
        while len(loop._selector.get_map()) > before:  # connections say goodbye after the session has ended
            await asyncio.sleep(0.01)

    asyncio.run(asyncio.wait_for(all_of_it(), 120.0))


def open_stream(session: aiohttp.ClientSession, show: PhoneShow, key: str = "", **headers: str) -> Any:
    """The WebSocket, opened as the page opens it."""
    protocols = ("live.operator", f"live.key.{key or show.key}")
    return session.ws_connect(f"{show.at}/camera/stream", protocols=protocols, headers=headers)


async def answers(ws: Any) -> dict[str, Any]:
    """The next message of the server."""
    message = await ws.receive(timeout=60.0)
    assert message.type is aiohttp.WSMsgType.TEXT, message
    return dict(json.loads(message.data))


async def refusal(ws: Any) -> str:
    """The next refusal; other messages are left out."""
    while "refused" not in (told := await answers(ws)):
        pass
    return str(told["refused"])


@pytest.mark.long
def test_packets_of_a_chosen_performer_reach_the_show_with_their_times(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        async with open_stream(session, show) as ws:
            told = await answers(ws)
            assert told == {"phone": "phone 1", "performers": ["anna", "ben"], "performer": ""}
            await ws.send_str(json.dumps({"ping": 12.5}))
            pong = await answers(ws)
            assert pong["pong"] == 12.5
            assert abs(pong["time"] - show.clock.now()) < 5.0
            await ws.send_str(json.dumps({"performer": "ben"}))
            assert (await answers(ws))["performer"] == "ben"
            time = show.clock.now()
            sent = phone_packet(time, made_landmarks(time))
            await ws.send_bytes(sent)
            await ws.send_bytes(phone_packet(time, count=2))
            assert await asyncio.to_thread(wait_for, lambda: len(show.heard) == 2, 20.0)
        (phone, performer, packet, arrival), (_, _, empty, _) = show.heard
        assert (phone, performer, packet) == ("phone 1", "ben", sent)
        assert time <= arrival <= show.clock.now()
        assert decode_landmarks(empty).landmarks is None
        assert await asyncio.to_thread(wait_for, lambda: not show.facts.get("open", [1]), 20.0)

    run(what)


@pytest.mark.long
def test_edited_performers_reach_open_pages(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        async with open_stream(session, show) as ws:
            await answers(ws)
            await ws.send_str(json.dumps({"performer": "anna"}))
            await answers(ws)
            show.use_performers('[[mocap]]\nname = "clara"\n')
            assert await answers(ws) == {"phone": "phone 1", "performers": ["clara"], "performer": ""}
            await ws.send_bytes(phone_packet(show.clock.now()))
            assert await refusal(ws) == "no performer chosen"

    run(what)
    assert performers_of(parse_patch(PATCH, "test.toml")) == ["live"]


def test_stream_requires_a_key_and_the_cameras_key_opens_nothing_else(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        for key in ("wrong", camera_key(b""), show.key[:-1]):
            with pytest.raises(aiohttp.WSServerHandshakeError) as error:
                await open_stream(session, show, key)
            assert error.value.status == 401
        for headers in ({"Origin": "https://evil.example"}, {"Host": "evil.example"}):
            with pytest.raises(aiohttp.WSServerHandshakeError) as error:
                await open_stream(session, show, **headers)
            assert error.value.status == 403
        async with open_stream(session, show, KEY):  # the operator may all
            pass
        page = f"http://127.0.0.1:{show.web.port}"
        bearer = {"Authorization": f"Bearer {show.key}"}
        async with session.get(f"{page}/surface.json", headers=bearer) as answer:
            assert answer.status == 401
        with pytest.raises(aiohttp.WSServerHandshakeError) as error:
            await session.ws_connect(f"{page}/ws", protocols=("live.operator", f"live.key.{show.key}"))
        assert error.value.status == 401
        async with session.get(f"{page}/camera") as answer:  # this machine's own camera needs no certificate
            assert answer.status == 200

    run(what)


def test_phones_port_serves_the_page_and_the_models_files_alone(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        async with session.get(f"{show.at}/") as answer:
            assert answer.url.path == "/camera"
        async with session.get(f"{show.at}/camera") as answer:
            text, policy = await answer.text(), answer.headers["Content-Security-Policy"]
            assert answer.headers["Permissions-Policy"] == "camera=(self), microphone=()"
        assert "default-src 'none'" in policy
        assert "script-src 'self' 'wasm-unsafe-eval' 'sha256-" in policy
        assert "'unsafe-" not in policy
        assert "frame-ancestors 'none'" in policy
        assert "http://" not in text
        assert "https://" not in text
        assert "No picture is sent" in text
        for name in ("pose.js", "pose_solution_simd_wasm_bin.wasm"):
            async with session.get(f"{show.at}/camera/model/{name}") as answer:
                assert (answer.status, answer.content_type) == (200, MODEL_FILES[name])
                assert answer.headers["X-Content-Type-Options"] == "nosniff"
                tag = answer.headers["ETag"]
            async with session.get(f"{show.at}/camera/model/{name}", headers={"If-None-Match": tag}) as answer:
                assert answer.status == 304
        for path in (
            "/camera/model/", "/camera/model/package.json", "/camera/model/pose_web.binarypb",
            "/camera/model/..%2fpackage.json", "/camera/model/%2e%2e/%2e%2e/etc/passwd", "/camera/nothing",
            "/surface.json", "/ws", "/studio", "/studio/stream",
        ):  # fmt: skip
            async with session.get(f"{show.at}{path}") as answer:
                assert answer.status == 404, path
        async with session.post(f"{show.at}/camera") as answer:
            assert answer.status == 405
        async with session.post(f"{show.at}/camera/stream", data=b"a picture") as answer:
            assert answer.status == 413

    run(what)


def test_hostile_messages_are_refused_counted_and_never_reach_the_show(show: PhoneShow) -> None:
    nan = struct.pack("<d", math.nan)

    async def what(session: aiohttp.ClientSession) -> None:
        async with open_stream(session, show) as ws:
            await ws.send_bytes(phone_packet(show.clock.now()))
            assert await refusal(ws) == "no performer chosen"
            await ws.send_str(json.dumps({"performer": "anna"}))
            now = show.clock.now()
            good = phone_packet(now, made_landmarks(now))
            for packet, why in (
                (b"", "wrong packet"), (good[:-1], "wrong packet"), (good[:4] + nan + good[12:], "wrong packet"),
                (bytes(range(256)), "wrong packet"), (phone_packet(now + 60.0), "wrong clock"),
                (phone_packet(max(now - 60.0, 0.0) + 1e6), "wrong clock"),
            ):  # fmt: skip
                await ws.send_bytes(packet)
                assert await refusal(ws) == why
        for text, why in (
            ("", "wrong message"), ("{", "wrong message"), ("[" * 400, "wrong message"), ("null", "wrong message"),
            ('{"performer": 5}', "wrong message"), ('{"performer": "zoe"}', "no such performer"),
            ('{"performer": "<b>"}', "no such performer"), ('{"ping": NaN}', "wrong message"),
            ('{"ping": 1e999}', "wrong message"), ('{"ping": ' + "9" * 450 + "}", "wrong message"),
        ):  # fmt: skip
            async with open_stream(session, show) as ws:
                await ws.send_str(text)
                assert await refusal(ws) == why, text
        async with open_stream(session, show) as ws:
            await answers(ws)
            await ws.send_bytes(bytes(1000))  # a small picture
            assert (await ws.receive(timeout=60.0)).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)
        refused = lambda: show.facts.get("refused", {}).get("no such performer") == 2  # noqa: E731
        assert await asyncio.to_thread(wait_for, refused, 20.0)
        assert show.facts["refused"]["wrong packet"] == 4
        assert show.facts["refused"]["wrong clock"] == 2

    run(what)
    assert show.heard == []


@pytest.mark.long
def test_flood_is_limited_and_the_flooder_disconnected(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        async with open_stream(session, show) as ws, open_stream(session, show) as other:
            for each in (ws, other):
                await answers(each)
                await each.send_str(json.dumps({"performer": "anna"}))
                await answers(each)
            begin = show.clock.now()
            sent = 0
            with contextlib.suppress(ConnectionError):
                while not ws.closed:
                    await ws.send_bytes(phone_packet(show.clock.now(), count=sent))
                    sent += 1
                    assert sent < 1_000_000
                    if sent % 50 == 0:
                        await asyncio.sleep(0)
            took = show.clock.now() - begin
            alone = lambda: [each["phone"] for each in show.facts.get("open", [])] == ["phone 2"]  # noqa: E731
            assert await asyncio.to_thread(wait_for, alone, 20.0)
            assert show.facts["refused"]["too many packets at once"] > 300
            assert len([1 for phone, *_ in show.heard if phone == "phone 1"]) <= 45.0 * (took + 1.0) + 1
            await other.send_bytes(phone_packet(show.clock.now()))
            assert await asyncio.to_thread(wait_for, lambda: any(p == "phone 2" for p, *_ in show.heard), 20.0)

    run(what)


@pytest.mark.long
def test_number_of_phones_is_limited_and_places_become_free(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        opened = [await open_stream(session, show) for _ in range(MAX_PHONES)]
        assert {(await answers(ws))["phone"] for ws in opened} == {f"phone {n + 1}" for n in range(MAX_PHONES)}
        with pytest.raises(aiohttp.WSServerHandshakeError) as error:
            await open_stream(session, show)
        assert error.value.status == 503
        await opened[3].close()
        async with open_stream(session, show) as ws:
            assert (await answers(ws))["phone"] == "phone 4"
        for ws in opened:
            await ws.close()

    run(what)


@pytest.mark.long
def test_operators_page_is_told_the_link_and_its_code(show: PhoneShow) -> None:
    async def what(session: aiohttp.ClientSession) -> None:
        page = f"http://127.0.0.1:{show.web.port}/ws"
        async with session.ws_connect(page, protocols=("live.operator", f"live.key.{KEY}")) as ws:
            told: dict[str, Any] = {}
            while "camera" not in told:
                told |= await answers(ws)
        assert told["camera"]["link"] == show.link
        assert told["camera"]["code"].startswith("data:image/svg+xml")
        assert KEY not in show.link

    run(what)


def test_own_certificate_is_kept_private_and_made_anew_for_another_address(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    first = own_identity("192.168.1.20")
    (file,) = tmp_path.iterdir()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert {"192.168.1.20", "localhost", "127.0.0.1"} <= set(first.names)
    now = datetime.now(UTC)
    assert VALID - timedelta(days=2) < first.valid_until - now <= VALID
    assert first.warnings(now, "192.168.1.20") == []
    assert own_identity("192.168.1.20").certificate == first.certificate
    second = own_identity("10.0.0.5")
    assert second.certificate != first.certificate
    file.write_text("not a certificate")
    third = own_identity("10.0.0.5")
    assert third.certificate != second.certificate
    monkeypatch.setattr("live.app.services.phone_camera.VALID", RENEW_BEFORE - timedelta(days=1))
    file.unlink()
    short = own_identity("10.0.0.5")
    assert own_identity("10.0.0.5").certificate != short.certificate, "it expires soon"


def test_missing_model_and_missing_page_are_one_clear_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("live.app.services.phone_camera.phone_folder", lambda: None)
    options = LaunchOptions(phone_camera=("127.0.0.1", 0))
    with pytest.raises(PersonError, match="pose model") as error:
        PhoneCameraPort(options, None, KEY)
    assert "live camera models" in str(error.value.remedy)


@pytest.mark.long
def test_without_the_option_there_is_no_camera_page() -> None:
    from tests.control.web.test_web_server import PageServer, status
    from tests.control.web.test_web_server import run as run_page

    async def what(client: aiohttp.ClientSession, page: PageServer) -> None:
        for path in ("/camera", "/camera/stream", "/camera/model/pose.js"):
            assert (await status(client, page, path))[0] == 404

    run_page(PageServer(), what)
