"""Network streams of the picture, sent over loopback and decoded again; no write ever blocks."""

import socket
import threading
from time import monotonic
from typing import Any

import av
import numpy as np
import pytest

from live.render.film.network_stream import SLOTS, NetworkStream
from live.render.film.streams import FilmSound
from tests.render.film.test_film import tone

SIZE = (96, 64)


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as there:
        there.bind(("127.0.0.1", 0))
        port: int = there.getsockname()[1]
        return port


def colour_quadrants(level: int) -> np.ndarray:
    """Four quadrants of colour, of which one changes."""
    picture = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    picture[:32, :48], picture[:32, 48:] = (200, 40, 40), (40, 190, 60)
    picture[32:, :48], picture[32:, 48:] = (50, 60, 220), (level, level, level)
    return picture


class Receiver:
    """Decodes the stream at a URL in a separate thread."""

    def __init__(self, url: str) -> None:
        self.pictures: list[np.ndarray] = []
        self.times: list[float] = []
        self.streams: set[str] = set()
        self._url, self._done = url, threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            options = {"probesize": "200000", "analyzeduration": "500000"}
            with av.open(self._url, "r", timeout=30.0, options=options) as container:
                video: Any = container.streams.video[0]
                self.streams = {stream.codec.name for stream in container.streams}
                for frame in container.decode(video):
                    self.times.append(frame.time)
                    self.pictures.append(frame.to_ndarray(format="rgb24"))
                    if self._done.is_set():
                        return
        except av.error.FFmpegError:
            pass

    def close(self) -> None:
        self._done.set()
        self._thread.join(10.0)


def send_until(stream: NetworkStream, receiver: Receiver, count: int) -> int:
    """Send pictures of rising brightness until `count` have arrived; returns the number of frames sent."""
    deadline, waiting = monotonic() + 60.0, threading.Event()
    frame = 0
    while len(receiver.pictures) < count:
        assert monotonic() < deadline, (stream.error, stream.sent, len(receiver.pictures))
        stream.write(colour_quadrants(frame % 50 * 4 + 20), frame)
        frame += 1
        waiting.wait(0.02)
    return frame


@pytest.mark.long
@pytest.mark.parametrize("sound", [False, True])
def test_received_pictures_match_sent_pictures(sound: bool) -> None:
    url = f"udp://127.0.0.1:{free_port()}"
    receiver = Receiver(url)
    heard = FilmSound.from_samples(tone(48000, 5.0), 48000, loop=True) if sound else None
    stream = NetworkStream(url, size=SIZE, fps=50, sound=heard)
    send_until(stream, receiver, 12)
    stream.close()
    receiver.close()
    assert receiver.streams == ({"h264", "aac"} if sound else {"h264"})
    picture = receiver.pictures[5].astype(int)
    assert picture.shape == (64, 96, 3)
    for row, column, colour in ((16, 24, (200, 40, 40)), (16, 72, (40, 190, 60)), (48, 24, (50, 60, 220))):
        there = picture[row - 6 : row + 6, column - 10 : column + 10].mean(axis=(0, 1))
        assert there == pytest.approx(colour, abs=14)
    levels = [float(one[40:56, 56:88].mean()) for one in receiver.pictures]
    steps = np.diff(levels)
    apart = np.diff(receiver.times)
    assert apart.min() > 0.0
    rising = steps > 0
    assert rising.mean() > 0.8
    # each frame is 4 brighter than the one before: times say how many frames lie between two pictures
    assert steps[rising] == pytest.approx(4.0 * np.round(apart[rising] * 50), abs=4)


def test_missing_receiver_does_not_block_writes() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        stream = NetworkStream(f"tcp://127.0.0.1:{taken.getsockname()[1]}", size=SIZE, fps=50)
        begin = monotonic()
        for frame in range(200):
            stream.write(colour_quadrants(0), frame)
        assert monotonic() - begin < 2.0
        assert stream.dropped >= 200 - SLOTS - 3, "and each time that it is tried one is lost"
        deadline, waiting = monotonic() + 30.0, threading.Event()
        while not stream.error:
            assert monotonic() < deadline
            waiting.wait(0.01)
        assert "refused" in stream.error
        stream.close()
        assert stream.sent == 0


def test_reconnected_receiver_gets_stream_again() -> None:
    def send(stream: NetworkStream, frame: int) -> None:
        stream.write(np.random.default_rng(frame).integers(0, 255, (64, 96, 3), np.uint8), frame)

    with socket.create_server(("127.0.0.1", 0)) as server:
        stream = NetworkStream(f"tcp://127.0.0.1:{server.getsockname()[1]}", size=SIZE, fps=50)
        frame, deadline = 0, monotonic() + 60.0
        for turn in range(2):
            connection, received = None, b""
            server.settimeout(0.02)
            while len(received) < 188 * 10:
                assert monotonic() < deadline, (turn, stream.error)
                send(stream, frame := frame + 1)
                try:
                    if connection is None:
                        connection, _ = server.accept()
                        connection.settimeout(0.02)
                    received += connection.recv(65536)
                except TimeoutError:
                    continue
            assert received[0] == received[188] == 0x47, "packets of a transport stream"
            assert connection is not None
            connection.close()
        assert stream.opened == 2
        stream.close()


def test_invalid_addresses_are_refused() -> None:
    for url in ("http://127.0.0.1:1", "127.0.0.1:5000", "file.ts"):
        with pytest.raises(ValueError, match="udp://"):
            NetworkStream(url, size=SIZE, fps=50)
