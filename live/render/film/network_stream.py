"""Network video stream: an MPEG transport stream with low-latency H.264 for other programs and machines."""

import threading
from fractions import Fraction
from queue import Empty, SimpleQueue
from typing import Any, Final

import av
import numpy as np
import numpy.typing as npt

from live.base.system.process_control import yield_thread_priority
from live.render.film.container_formats import VideoFormat
from live.render.film.film_writer import ENCODER_NICE, frame_pixels
from live.render.film.streams import FilmEncoder, FilmSound

Picture = npt.NDArray[np.uint8]

SCHEMES: Final = ("udp", "rtp", "tcp", "srt")
"""Supported protocols; SRT only where PyAV was built with it."""
STREAM_FORMAT: Final = VideoFormat(
    "mpegts", "libx264", "yuv420p", None, "aac", "MPEG-TS",
    (("preset", "ultrafast"), ("tune", "zerolatency"), ("crf", "23")), key_frame_interval=0.5,
)  # fmt: skip
SLOTS: Final = 3
"""Maximum number of frames that wait for the encoder."""
PACKET_OPTION: Final = "?pkt_size=1316"
"""Seven transport stream packets in each datagram: more would be fragmented on the network."""
RETRY_DELAY: Final = 1.0
"""Seconds from a failure until the stream is opened again."""


def is_srt_supported() -> bool:
    """Whether this build of PyAV supports SRT."""
    try:
        with av.open("srt://127.0.0.1:1?connect_timeout=1&timeout=1", "r", timeout=0.2):
            return True
    except av.error.ProtocolNotFoundError:
        return False
    except (av.error.FFmpegError, OSError):
        return True


class NetworkStream:
    """Sends frames of one size to `url` (`udp://HOST:PORT`, `rtp://`, `tcp://`, `srt://`).

    A thread encodes and sends. A frame that arrives while `SLOTS` others wait is dropped and counted in `dropped`, and
    so are frames while no receiver is connected (TCP, SRT): the stream is opened again every second. `sound`: sent with
    the video. Raises ValueError for any other url. Thread: `write` and `close` from one.
    """

    def __init__(
        self, url: str, *, size: tuple[int, int], fps: float | Fraction, sound: FilmSound | None = None
    ) -> None:
        if url.partition("://")[0] not in SCHEMES:
            raise ValueError(f"{url}: {', '.join(f'{scheme}://' for scheme in SCHEMES)} expected")
        self.url, self.fps = url, Fraction(fps).limit_denominator(1001)
        self.size = (size[0] - size[0] % 2, size[1] - size[1] % 2)
        self.sent = self.dropped = self.opened = 0
        """Frames sent, frames dropped, number of times the stream was opened."""
        self.error = ""
        """Why nothing is sent now; empty while the stream works."""
        self._sound = sound
        self._sources = [av.VideoFrame(*self.size, "rgb24") for _ in range(SLOTS)]
        self._pixels = [frame_pixels(source, 3) for source in self._sources]
        self._free: SimpleQueue[int] = SimpleQueue()
        self._jobs: SimpleQueue[tuple[int, int] | None] = SimpleQueue()
        for slot in range(SLOTS):
            self._free.put(slot)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="share", daemon=True)
        self._thread.start()

    def write(self, picture: Picture, frame: int) -> None:
        """Send one picture, uint8 RGB (height, width, 3), as number `frame` of the show's frames at this rate."""
        try:
            slot = self._free.get_nowait()
        except Empty:
            self.dropped += 1
            return
        width, height = self.size
        np.copyto(self._pixels[slot], picture[:height, :width])
        self._jobs.put((slot, frame))

    def close(self) -> None:
        """End the stream; waits at most 2 s for a hung connection."""
        self._closing.set()
        self._jobs.put(None)
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        yield_thread_priority(ENCODER_NICE)
        while not self._closing.is_set():
            try:
                self._send_all()
            except Exception as error:  # the show must not stop: report the error and try again
                self.error = getattr(error, "strerror", None) or str(error) or type(error).__name__
            if self._closing.wait(RETRY_DELAY):
                return

    def _send_all(self) -> None:
        whole = "" if not self.url.startswith("udp") or "pkt_size" in self.url else PACKET_OPTION
        url = self.url + (whole if not whole or "?" not in self.url else whole.replace("?", "&"))
        form = "rtp_mpegts" if self.url.startswith("rtp") else STREAM_FORMAT.container
        with av.open(url, "w", format=form, timeout=5.0) as container:
            encoder: FilmEncoder | None = None
            first = 0
            while (job := self._jobs.get()) is not None:
                slot, frame = job
                try:
                    if encoder is None:
                        first = frame
                        encoder = _encoder(container, self, frame)
                        self.opened, self.error = self.opened + 1, ""
                    encoder.skip(max(frame - first - encoder.count, 0))
                    encoder.encode(self._sources[slot])
                    self.sent += 1
                finally:
                    self._free.put(slot)
            if encoder is not None:
                encoder.finish()


def _encoder(container: Any, stream: NetworkStream, frame: int) -> FilmEncoder:
    sound = stream._sound
    if sound is not None:
        begin, whole = round(frame / stream.fps * sound.rate), sound
        sound = FilmSound(whole.rate, whole.channels, lambda first, count: whole.read(begin + first, count))
    encoder = FilmEncoder(container, stream.size, stream.fps, STREAM_FORMAT, {}, sound)
    container.start_encoding()
    return encoder
