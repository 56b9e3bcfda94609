"""The stage for pages: frames of a show, through the real web process to a real WebSocket."""

import asyncio
import json
import struct
import threading
from collections import Counter
from typing import Any, ClassVar

import aiohttp
import numpy as np
import pytest

from live.app.services.http_services import WebService
from live.app.services.stage_stream import StageStream
from live.clock.ticks import TICK
from live.clock.time_source import SystemClock
from live.show.loader import load_show
from live.show.patch.patch_search_path import PATCHES
from live.show.show import Show

KEY = "a-key-of-the-tests-4711"
LOADED = load_show(PATCHES / "score" / "show.toml")


def running(seconds: float = 3.0) -> Show:
    show = LOADED.start()
    for tick in range(1, int(seconds / TICK)):
        show.tick(tick * TICK)
    return show


def make_stream(show: Show) -> StageStream:
    view = show.view()
    show.fill(view, show.time)
    return StageStream(show, lambda: view, lambda: 7)


def text_of(packets: list[list[Any]], name: str) -> Any:
    parts = [packet for packet in packets if packet[:2] == ["text", name]]
    assert [packet[2] for packet in parts] == list(range(len(parts)))
    return json.loads(b"".join(packet[4] for packet in parts)) if parts else None


def test_nobody_looks_and_nothing_is_written() -> None:
    stream = make_stream(running(0.5))
    for wants in (None, {}, {"pages": 0}, "nonsense", {"pages": None}):
        assert list(stream.packets(1.0, wants)) == []


def test_frames_hold_places_headings_and_joints() -> None:
    show = running()
    stream = make_stream(show)
    packets = list(stream.packets(1.0, {"pages": 1, "joints": [2, 1, 99, "x"]}))
    assert text_of(packets, "dancers")["ids"] == list(range(1, 17))
    positions, joints = (packet[2] for packet in packets if packet[0] == "frame")
    kind, _, count, tick = struct.unpack_from("<BBHI", positions)
    assert (kind, count, tick) == (1, 16, round(show.time / TICK))
    rows = np.frombuffer(positions, "<i2", offset=8).reshape(16, 4)
    assert np.abs(rows[:, :2] / 1000 - show.dancers.drawn_hips).max() < 0.001
    assert rows[:, 3].tolist() == show.motion.present.astype(int).tolist()
    facing = rows[:12, 2] / 10_000 * 2 * np.pi
    assert np.abs(facing).max() < 1.0  # to the public, more or less
    kind, flags, count, _ = struct.unpack_from("<BBHI", joints)
    assert (kind, flags, count, len(joints)) == (2, 1, 2, 8 + 2 * 22 * 6)
    view = show.view()
    show.fill(view, show.time)
    found = np.frombuffer(joints, "<i2", offset=8).reshape(2, 22, 3) / 1000
    assert np.abs(found - view.joint_position[[1, 0]]).max() < 0.001


def test_they_come_thirty_times_a_second_at_most_and_the_clock_ten_times() -> None:
    stream, counts = make_stream(running(0.5)), Counter[str]()
    for frame in range(600):  # ten seconds of frames
        for packet in stream.packets(frame / 60, {"pages": 1, "joints": None}):
            counts[packet[1] if packet[0] == "text" else str(packet[1])] += 1
    assert 298 <= counts["1"] <= 302
    assert counts["2"] == 0
    assert 98 <= counts["clock"] <= 102
    assert counts["dancers"] == 1


def test_the_structure_comes_once_and_after_an_edit() -> None:
    show = running(0.5)
    stream = make_stream(show)
    assert threading.active_count() < 50
    seen: list[Any] = []
    for turn in range(2000):
        packets = list(stream.packets(turn / 30, {"pages": 1}))
        if (text := text_of(packets, "structure")) is not None:
            seen.append(text)
            if len(seen) == 2:
                break
            stream.update_patch(show.patch.model_copy(update={"name": "edited"}))
        for thread in threading.enumerate():
            if thread.name == "structure":
                thread.join(10.0)
    assert [each["score"].get("name") for each in seen] == [show.patch.name, "edited"]
    assert [group["name"] for group in seen[0]["groups"]] == ["ember", "tide"]
    assert {"name": "groove", "measures": 1} in seen[0]["library"]
    assert seen[0]["revision"] == 7


async def look(port: int, say: dict[str, Any], key: str = KEY) -> Counter[str]:
    """Return what a page got until it has ten frames of positions, and a clock."""
    found: Counter[str] = Counter()
    url = f"http://127.0.0.1:{port}/studio/stream"
    headers = {"Authorization": f"Bearer {key}"}
    async with aiohttp.ClientSession() as session:  # noqa: SIM117
        async with session.ws_connect(url, headers=headers, max_msg_size=1 << 24) as page:
            await page.send_str(json.dumps(say))
            while found["1"] < 10 or not found["clock"] or not found["structure"]:
                message = await page.receive(timeout=30.0)
                if message.type is aiohttp.WSMsgType.BINARY:
                    found[str(message.data[0])] += 1
                elif message.type is aiohttp.WSMsgType.TEXT:
                    told = json.loads(message.data)
                    found[told.get("kind", "refused")] += 1
                    if "refused" in told:
                        break
                else:
                    raise AssertionError(message)
    return found


def test_a_real_page_sees_the_stage() -> None:
    show = running(0.5)
    clock = SystemClock()
    service = WebService(("127.0.0.1", 0), KEY, ("127.0.0.1", 9), show, clock, stage=make_stream(show))
    service.start()
    stop = threading.Event()

    def frames() -> None:
        while not stop.wait(1 / 60):
            service.frame()

    thread = threading.Thread(target=frames)
    thread.start()
    try:
        both = asyncio.run(look(service.port, {"positions": 30, "joints": 30}))
        assert both["2"] > 0
        assert both["structure"] == both["dancers"] == 1
        few = asyncio.run(look(service.port, {"positions": 30, "joints": 0, "clock": 5}))
        assert few["2"] == 0
        for wrong in ({"positions": 1e9}, {"nonsense": 1}, {"dancers": ["x"]}):
            assert asyncio.run(look(service.port, wrong))["refused"] == 1
        with pytest.raises(aiohttp.WSServerHandshakeError):
            asyncio.run(look(service.port, {}, key="another-key-of-nobody"))
    finally:
        stop.set()
        thread.join()
        service.stop()


def test_a_page_that_does_not_read_gets_fewer_frames_and_no_queue() -> None:
    from live.control.web.stage_subscribers import MAX_UNSENT_BYTES, StageSubscriber, StageSubscribers

    class Transport:
        unsent = 0

        def get_write_buffer_size(self) -> int:
            return self.unsent

    class Request:
        transport = Transport()

    class Socket:
        sent: ClassVar[list[bytes]] = []

        async def send_bytes(self, data: bytes) -> None:
            self.sent.append(data)

    now = [0.0]
    pages = StageSubscribers(lambda: now[0])
    page = StageSubscriber(Socket(), Request())  # type: ignore[arg-type]

    async def frames(count: int) -> None:
        for _ in range(count):
            now[0] += 1 / 30
            await pages.take(["frame", 1, b"12345678"])

    async def run() -> None:
        await pages.add(page)
        await frames(30)
        assert len(Socket.sent) >= 29
        Request.transport.unsent = MAX_UNSENT_BYTES + 1
        await frames(30)
        Request.transport.unsent = 0
        assert page.missed == 30
        page.choose('{"positions": 10}')
        Socket.sent.clear()
        await frames(90)
        assert 29 <= len(Socket.sent) <= 32

    asyncio.run(run())
