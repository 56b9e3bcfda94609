"""A phone as a camera: a real browser with the real pose model sees a dancer of our own film, and sends her joints."""

import contextlib
import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.control.camera.model_files import phone_folder
from live.control.camera.phone_landmarks import PACKET_BYTES, decode_landmarks
from live.motion.capture.landmarks import LANDMARK_NAMES, Landmarks
from tests.app.services.phone_show import PhoneShow, phone_show
from tests.control.waiting import wait_for
from tests.end_to_end.browser import browser, needs_browser

PATCH = """
name = "one dancer"
seed = 3
[clock]
bpm = 112
[stage]
width = 6
depth = 5
[camera]
eye = [0.0, 1.3, 3.6]
target = [0.0, 0.9, 0.0]
[[group]]
name = "she"
dancers = 1
steps = ["groove"]
centre = [0.0, 0.0]
size = [1.0, 1.0]
"""
HEAD, LEFT, RIGHT = (LANDMARK_NAMES.index(name) for name in ("nose", "leftWrist", "rightWrist"))
LEFT_ANKLE = LANDMARK_NAMES.index("leftAnkle")

pytestmark = [
    pytest.mark.browser,
    needs_browser,
    pytest.mark.skipif(phone_folder() is None, reason="needs the pose model for browsers (live camera models)"),
    pytest.mark.skipif(importlib.util.find_spec("av") is None, reason="needs PyAV (extra video)"),
]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three seconds of a dancer, drawn by our renderer, as the raw film that Chromium takes for a camera."""
    import av

    folder = tmp_path_factory.mktemp("film")
    (folder / "she.toml").write_text(PATCH)
    options = ("--headless", "--record", "she.mp4", "--seconds", "3", "--size", "320x240", "--fps", "30")
    done = subprocess.run(
        [sys.executable, "-m", "live", "play", "she.toml", *options], cwd=folder, capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip
    assert (folder / "she.mp4").is_file(), done.stdout + done.stderr
    raw = folder / "she.y4m"
    with av.open(folder / "she.mp4") as reading, raw.open("wb") as file:
        file.write(b"YUV4MPEG2 W320 H240 F30:1 Ip A1:1 C420jpeg\n")
        for frame in reading.decode(video=0):
            file.write(b"FRAME\n" + frame.reformat(format="yuv420p").to_ndarray().tobytes())
    return raw


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[PhoneShow]:
    with phone_show(tmp_path, monkeypatch, phone_folder()) as running:
        yield running


class CameraPage:
    """The camera page in a browser; keeps what it sends and asks for."""

    def __init__(self, opened: Any, device: dict[str, Any], link: str, **settings: Any) -> None:
        context = opened.new_context(**{**device, **settings}, ignore_https_errors=True)
        with contextlib.suppress(Exception):  # an older browser has no such name
            context.grant_permissions(["camera"])
        self.page = context.new_page()
        self.sent: list[str | bytes] = []
        self.requests: list[Any] = []
        self.problems: list[str] = []
        self.page.on("websocket", lambda ws: ws.on("framesent", lambda data: self.sent.append(data)))
        self.page.on("request", lambda request: self.requests.append(request))
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", lambda message: message.type == "error" and self.problems.append(message.text))
        self.page.goto(link)

    def wait_while(self, missing: Any, seconds: float, why: str) -> None:
        """Let the page run until something is not missing any more."""
        for _ in range(int(seconds / 0.2)):
            if not missing():
                return
            self.page.wait_for_timeout(200)
        raise AssertionError(f"{why}: {self.page.locator('#word').inner_text()}; {self.problems}")


def people(show: PhoneShow) -> list[Landmarks]:
    """The people seen so far."""
    found = (decode_landmarks(packet).landmarks for _, _, packet, _ in show.heard)
    return [each for each in found if each is not None]


@pytest.mark.long
def test_phone_sends_joints_of_a_dancer_and_no_picture(film: Path, show: PhoneShow) -> None:
    video = ("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream")
    with browser(*video, f"--use-file-for-fake-video-capture={film}") as (opened, device):
        phone = CameraPage(opened, device, show.link)
        page = phone.page
        page.get_by_text("No picture is sent", exact=False).wait_for()
        assert "key" not in page.url, "the key leaves the address bar"
        page.get_by_label("Model").select_option("quick")
        page.get_by_label("Who is seen").select_option("anna")
        assert page.get_by_text("camera closed").is_visible()
        page.get_by_role("button", name="Start the camera").click()
        page.get_by_text("camera open").wait_for()
        phone.wait_while(lambda: len(people(show)) < 5, 240.0, "no dancer was seen")
        drawn = "document.querySelector('#bones').getContext('2d').getImageData(0, 0, 320, 240).data"
        assert page.evaluate(f"[...{drawn}].some(value => value)"), "her skeleton is drawn"

        # What left the phone: joints, pings and the performer's name, by one WebSocket; requests had no body.
        packets = [each for each in phone.sent if isinstance(each, bytes)]
        texts = [each for each in phone.sent if isinstance(each, str)]
        assert packets
        assert {len(each) for each in packets} <= {15, PACKET_BYTES}
        assert all(each.startswith(('{"ping":', '{"performer":')) and len(each) < 100 for each in texts)
        assert all(request.method == "GET" and request.post_data_buffer is None for request in phone.requests)
        assert all(request.url.startswith(show.at) or request.url.startswith(("data:", "blob:https://127.0.0.1"))
                   for request in phone.requests)  # fmt: skip

        seen = people(show)[-1]
        assert {performer for _, performer, _, _ in show.heard} == {"anna"}
        assert seen.aspect == pytest.approx(4.0 / 3.0, abs=0.01)
        assert np.abs(seen.picture[:, 0] - 0.5).max() < 0.4, "she dances in the middle"
        assert seen.picture[HEAD, 1] < seen.picture[LEFT, 1] < seen.picture[LEFT_ANKLE, 1], "upright"
        assert seen.picture[LEFT, 0] > seen.picture[RIGHT, 0], "not mirrored: she faces the camera"
        assert np.linalg.norm(seen.body[LEFT] - seen.body[RIGHT]) < 2.0
        assert all(-0.1 <= arrival - decode_landmarks(packet).time <= 5.0 for _, _, packet, arrival in show.heard)

        page.get_by_role("button", name="Stop the camera").click()
        page.get_by_text("camera closed").wait_for()
        assert page.evaluate("document.querySelector('video').srcObject === null")
        assert phone.problems == []


def test_page_without_key_asks_and_connects_again_by_itself(show: PhoneShow) -> None:
    with browser("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream") as (opened, device):
        phone = CameraPage(opened, device, f"{show.at}/camera")
        page = phone.page
        page.get_by_label("This page needs the link").fill("wrong-key")
        page.get_by_role("button", name="Open").click()
        page.get_by_text("this key is not (or no more) the show's").wait_for()
        page.get_by_label("This page needs the link").fill(show.link)
        page.get_by_role("button", name="Open").click()
        page.get_by_label("This page needs the link").wait_for(state="hidden")
        page.get_by_label("Who is seen").select_option("ben")
        assert wait_for(lambda: [each["performer"] for each in show.facts.get("open", [])] == ["ben"], 20.0)
        show.web._helper.restart()  # the show's web server dies, and is started again
        phone.wait_while(lambda: page.locator("#word").inner_text() == "ready", 60.0, "not noticed")
        phone.wait_while(lambda: page.locator("#word").inner_text() != "ready", 120.0, "not connected again")
        assert page.get_by_label("Who is seen").input_value() == "ben"
        assert wait_for(lambda: [each["performer"] for each in show.facts.get("open", [])] == ["ben"], 20.0)


@pytest.mark.long
@pytest.mark.parametrize("size", [(390, 780), (780, 390)])
def test_page_fits_upright_and_sideways_and_is_used_by_keyboard(show: PhoneShow, size: tuple[int, int]) -> None:
    viewport = {"width": size[0], "height": size[1]}
    with browser("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream") as (opened, device):
        phone = CameraPage(opened, device, show.link, viewport=viewport, screen=viewport)
        page = phone.page
        page.get_by_label("Who is seen").wait_for()
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        view, button = page.locator("#view").bounding_box(), page.locator("#go").bounding_box()
        assert view is not None
        assert button is not None
        assert min(view["width"], view["height"]) > 120.0
        assert button["y"] + button["height"] <= size[1]
        page.get_by_label("Who is seen").select_option("anna")
        page.locator("#go").focus()
        page.keyboard.press("Enter")
        page.get_by_text("camera open").wait_for()
        assert page.get_by_role("button", name="Stop the camera").get_attribute("aria-pressed") == "true"
        assert page.title().startswith("●")
        page.keyboard.press("Enter")
        page.get_by_text("camera closed").wait_for()
        assert phone.problems == []
