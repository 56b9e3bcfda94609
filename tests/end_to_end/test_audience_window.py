"""A real window: the audience's QR code, shown by a key, hidden over OSC; and the picture that web pages get of it."""

import asyncio
import io
import json
import shutil
import subprocess
import time
from pathlib import Path

import aiohttp
import numpy as np
import pytest
from PIL import Image

from tests.fixtures.two_monitor_x import FIRST, SECOND, TwoMonitorX

pytestmark = [pytest.mark.x11, pytest.mark.liblo, pytest.mark.long]
OSC, PHONES, WEB = 19023, 19024, 19025
KEY = "a-key-of-the-tests-4711"


@pytest.mark.skipif(not (shutil.which("xdotool") and shutil.which("oscsend")), reason="needs xdotool and liblo-tools")
def test_code_is_shown_by_key_and_hidden_over_osc(play, patch: Path, two_monitor_x: TwoMonitorX):
    two_monitor_x.plug_both()
    running = play(
        str(patch), "--bpm", "120", "--monitor", "2", "--fullscreen", "--alone", "--osc", f"127.0.0.1:{OSC}",
        "--audience", str(PHONES), env={"DISPLAY": two_monitor_x.display},
    )  # fmt: skip
    running.wait_for(lambda line: line["frames"] > 20 and line["audience"]["at"].endswith(str(PHONES)), 60)
    assert white_share(two_monitor_x) < 0.02
    two_monitor_x.run("xdotool", "key", "q")
    wait_until(lambda: 0.1 < white_share(two_monitor_x) < 0.5)  # a panel of light and dark, in the middle
    middle = two_monitor_x.screenshot()[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]][200:400, 300:500, 0]
    assert 0.3 < (middle > 128).mean() < 0.75  # as many light as dark modules, or nearly
    running.wait_for(lambda line: line["outputs"][0]["card"] == "qr", 30)
    subprocess.run(["oscsend", "127.0.0.1", str(OSC), "/dance/audience/qr", "i", "0"], check=True)
    wait_until(lambda: white_share(two_monitor_x) < 0.02)


def white_share(server: TwoMonitorX) -> float:
    """The share of the second monitor that is as light as paper."""
    seen = server.screenshot()[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]]
    return float((seen.min(axis=2) > 200).mean())


def wait_until(what, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.1)  # a look costs more than a frame of the show


def test_pages_see_the_picture_as_it_is_projected(play, patch: Path, two_monitor_x: TwoMonitorX):
    two_monitor_x.plug_both()
    running = play(
        str(patch), "--bpm", "120", "--monitor", "2", "--fullscreen", "--alone", "--web", str(WEB), "--web-key", KEY,
        env={"DISPLAY": two_monitor_x.display},
    )  # fmt: skip
    running.wait_for(lambda line: line["frames"] > 20, 60)

    async def look() -> bytes:
        headers = {"Authorization": f"Bearer {KEY}"}
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"http://127.0.0.1:{WEB}/studio/stream", headers=headers, max_msg_size=1 << 24) as page,
        ):
            await page.send_str(json.dumps({"positions": 0, "clock": 0, "picture": 4}))
            seen = 0
            async for message in page:
                if message.type is aiohttp.WSMsgType.BINARY and message.data[0] == 4:
                    seen += 1
                    if seen == 3:
                        return bytes(message.data)
        raise AssertionError("the page was closed")

    frame = asyncio.run(asyncio.wait_for(look(), 90))
    with Image.open(io.BytesIO(frame[8:])) as image:
        small = np.asarray(image.convert("RGB").resize((32, 18), Image.Resampling.BOX), np.float64)
    screen = two_monitor_x.screenshot()[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]]
    projected = np.asarray(Image.fromarray(screen).resize((32, 18), Image.Resampling.BOX), np.float64)
    assert small.std() > 3.0  # something is drawn
    assert np.corrcoef(small.ravel(), projected.ravel())[0, 1] > 0.8  # they danced on meanwhile
