"""Live pictures for the scenography: a capture device, a stream from the network, or another program's shared memory.

A thread opens the input, keeps its newest picture and opens it again every second while there is none: nothing waits
for it. An input that is unplugged keeps its last picture.
"""

import threading
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from live.base.stage_snapshot import parse_input
from live.base.system.features import capture_device
from live.base.system.picture_ring import FrameRingReader
from live.render.media.media_files import Picture

INPUT_SIZE: Final = (1280, 720)
"""Every live picture is scaled to this width and height [pixels]; the plane that shows it has its own aspect."""
RETRY_DELAY_S: Final = 1.0
"""From a failure until the input is opened again [s]."""
SILENCE_S: Final = 5.0
"""An input without a picture for so long [s] is opened again."""
_POLL_S: Final = 0.005
"""Interval at which shared memory is looked at [s]."""


class LiveInput:
    """The newest picture of a live input. Thread: `picture_at` and `close` from one; a separate thread reads.

    Raises PersonError for a text that names no input; an input that is not there is told in `problem` and tried again.
    """

    size, components = INPUT_SIZE, 3
    seconds = float("inf")

    def __init__(self, text: str) -> None:
        self.kind, self._name = parse_input(text)
        self.problem = "no picture yet"
        """Why there is no new picture; empty while pictures arrive."""
        self.aspect = INPUT_SIZE[0] / INPUT_SIZE[1]
        """Width by height of the input's pictures."""
        self.received = 0
        """Number of pictures that have arrived."""
        self._lock = threading.Lock()
        self._newest: Picture | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="live input", daemon=True)
        self._thread.start()

    def picture_at(self, seconds: float) -> Picture | None:
        """Return the newest picture, (720, 1280, 3), or None if it was returned before; it does not depend on time."""
        with self._lock:
            newest, self._newest = self._newest, None
        return newest

    def close(self) -> None:
        """End the thread; waits at most 2 s for a hung connection."""
        self._closing.set()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                for frame in self._memory_frames() if self.kind == "shm" else self._decoded_frames():
                    self._keep(frame)
                    if self._closing.is_set():
                        return
                self.problem = "it has ended; the last picture stays"
            except Exception as error:  # an unplugged cable must not end a show
                known = getattr(error, "strerror", None) or str(error) or type(error).__name__
                self.problem = f"no picture ({known}); tried again every second"
            self._closing.wait(RETRY_DELAY_S)

    def _keep(self, frame: Any) -> None:
        """Keep the newest picture, scaled."""
        width, height = INPUT_SIZE
        picture = np.ascontiguousarray(frame.reformat(width=width, height=height, format="rgb24").to_ndarray())
        self.aspect = frame.width / frame.height
        with self._lock:
            self._newest = picture
        self.received += 1
        self.problem = ""

    def _decoded_frames(self) -> Iterator[Any]:
        """Yield the pictures of a capture device or a stream."""
        import av

        url, form = self._name, None
        if self.kind == "camera":
            form, url = capture_device(self._name)
        options = {"fflags": "nobuffer", "flags": "low_delay"}
        with av.open(url, format=form, options=options, timeout=(SILENCE_S, SILENCE_S)) as container:
            if not container.streams.video:
                raise OSError("it has no picture")
            for packet in container.demux(container.streams.video[0]):
                try:
                    frames = packet.decode()
                except av.FFmpegError:  # packets are lost on a network
                    continue
                yield from frames

    def _memory_frames(self) -> Iterator[Any]:
        """Yield the frames of a ring buffer until its writer ends or falls silent."""
        import av

        reader = FrameRingReader(self._name)
        try:
            silent = 0.0
            while not self._closing.is_set():
                is_open = reader.is_open
                picture = reader.read()
                if picture is None and not is_open:  # after its end the last picture was read, too
                    return
                silent = 0.0 if picture is not None else silent + _POLL_S
                if picture is not None:
                    yield av.VideoFrame.from_ndarray(picture, format="rgb24")
                elif silent > SILENCE_S:
                    self.problem = "it stands still; the last picture stays"
                self._closing.wait(_POLL_S)
        finally:
            reader.close()
