"""Pictures of films and streams: rate, size, ends, damage, a stream that is pulled and comes back."""

import socket
import threading
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.system import features
from live.base.system.features import video_devices
from live.control.camera import frame_source
from live.control.camera.camera_plan import CameraAddress, parse_camera
from live.control.camera.frame_source import MOST_EDGE, FrameSource

DEADLINE_S = 30.0


def write_film(path: Path, *, frames: int = 30, rate: int = 30, size: tuple[int, int] = (64, 48)) -> Path:
    """Write a film whose pictures get brighter and brighter."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=rate)
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        stream.options = {"preset": "ultrafast"}
        for number in range(frames):
            pixels = np.full((size[1], size[0], 3), 40 + 150 * number // frames, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, "rgb24")))
        container.mux(stream.encode())
    return path


def read_all(source: FrameSource) -> list[frame_source.Frame]:
    """Read a film that does not loop; pictures may be missed, as the newest counts."""
    found: list[frame_source.Frame] = []
    source.start()
    try:
        while not source.is_over:
            frame = source.newest(found[-1].number if found else 0, DEADLINE_S)
            if frame is not None:
                found.append(frame)
    finally:
        source.stop()
    return found


@pytest.mark.long
def test_a_film_is_played_at_its_own_speed(tmp_path: Path) -> None:
    found = read_all(FrameSource(parse_camera(str(write_film(tmp_path / "a.mp4"))), loop=False))
    times = np.array([each.time for each in found])
    numbers = np.array([each.number for each in found])
    assert found[0].picture.shape == (48, 64, 3)
    assert np.diff(times) == pytest.approx(np.diff(numbers) / 30.0, abs=1e-6)
    assert found[-1].picture.mean() > found[0].picture.mean() + 50


@pytest.mark.long
def test_a_camera_of_120_pictures_a_second_is_thinned_to_30(tmp_path: Path) -> None:
    source = FrameSource(CameraAddress("film", str(write_film(tmp_path / "a.mp4", frames=120, rate=120))), loop=False)
    read_all(source)
    assert 28 <= source.read <= 31
    assert source.read + source.skipped == 120


def test_a_4k_picture_is_reduced(tmp_path: Path) -> None:
    film = write_film(tmp_path / "a.mp4", frames=2, size=(3840, 2160))
    source = FrameSource(CameraAddress("film", str(film)), loop=False)
    (*_, last) = read_all(source)
    assert last.picture.shape == (540, MOST_EDGE, 3)
    assert source.size == (3840, 2160)


def test_a_film_begins_again_at_its_end(tmp_path: Path) -> None:
    source = FrameSource(CameraAddress("film", str(write_film(tmp_path / "a.mp4", frames=5))))
    source.start()
    number, last = 0, -1.0
    try:
        while number < 12:
            frame = source.newest(number, DEADLINE_S)
            assert frame is not None
            assert frame.time > last
            number, last = frame.number, frame.time
    finally:
        source.stop()
    assert source.opened >= 2


@pytest.mark.parametrize("content", [b"", b"no film at all", bytes(range(256)) * 40])
def test_a_damaged_film_is_tried_again_and_the_reason_is_told(
    tmp_path: Path, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame_source, "OPEN_AGAIN_S", 0.01)
    film = tmp_path / "a.mp4"
    film.write_bytes(content)
    source = FrameSource(CameraAddress("film", str(film)))
    source.start()
    try:
        assert source.newest(0, 0.3) is None
        assert source.status()["problem"]
        write_film(film)  # it is there at last
        assert source.newest(0, DEADLINE_S) is not None
        assert source.problem == ""
    finally:
        source.stop()


def _send_stream(port: int, stop: threading.Event) -> None:
    with av.open(f"udp://127.0.0.1:{port}?pkt_size=1316", "w", format="mpegts") as container:
        stream = container.add_stream("mpeg2video", rate=25)
        stream.width, stream.height, stream.pix_fmt, stream.gop_size = 64, 48, "yuv420p", 5
        number = 0
        while not stop.wait(0.02):
            pixels = np.full((48, 64, 3), number % 200, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, "rgb24")))
            number += 1


def _wait(until: Callable[[], bool]) -> None:
    event, deadline = threading.Event(), DEADLINE_S
    while not until():
        assert deadline > 0.0
        event.wait(0.05)
        deadline -= 0.05


@pytest.mark.long
def test_a_stream_that_is_pulled_out_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_source, "OPEN_AGAIN_S", 0.05)
    monkeypatch.setattr(frame_source, "SILENT_S", 0.5)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    source = FrameSource(parse_camera(f"udp://127.0.0.1:{port}"))
    source.start()
    try:
        for _ in range(2):
            before, stop = source.read, threading.Event()
            sender = threading.Thread(target=_send_stream, args=(port, stop))
            sender.start()
            _wait(lambda before=before: source.read > before + 3)  # type: ignore[misc]
            assert source.status()["problem"] == ""
            stop.set()
            sender.join(DEADLINE_S)
            _wait(lambda: bool(source.status()["problem"]))
    finally:
        source.stop()
    assert source.opened >= 2


def test_a_camera_that_is_not_there_is_refused_with_those_that_are(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for number, name in enumerate(("Integrated Webcam", "HDMI grabber")):
        (tmp_path / f"video{2 * number}").mkdir()
        (tmp_path / f"video{2 * number}" / "name").write_text(name + "\n")
        (tmp_path / f"video{2 * number}" / "index").write_text("0\n")
        (tmp_path / f"video{2 * number + 1}").mkdir()
        (tmp_path / f"video{2 * number + 1}" / "name").write_text(name + "\n")
        (tmp_path / f"video{2 * number + 1}" / "index").write_text("1\n")
    monkeypatch.setattr(features, "_VIDEO_CLASS", tmp_path)
    monkeypatch.setattr(features.sys, "platform", "linux")
    assert video_devices() == [("/dev/video0", "Integrated Webcam"), ("/dev/video2", "HDMI grabber")]
    assert parse_camera("").place == "/dev/video0"
    assert parse_camera("2").place == "/dev/video2"
    assert parse_camera("hdmi").place == "/dev/video2"
    with pytest.raises(PersonError, match="no camera is called 'beamer'") as refused:
        parse_camera("beamer")
    assert "HDMI grabber (/dev/video2)" in str(refused.value)


def test_a_password_in_an_address_is_not_shown() -> None:
    assert parse_camera("rtsp://anna:secret@10.0.0.7/stage").label == "rtsp://10.0.0.7/stage"
