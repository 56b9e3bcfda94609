"""Pictures of one camera: a device, a film or a network stream, read by PyAV in a thread that keeps only the newest.

A camera that is pulled out, a stream that breaks off and a film that ends are opened again, for as long as it takes.
"""

import contextlib
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import av
import numpy as np

from live.base.arrays import UInt8
from live.base.system.features import capture_device
from live.control.camera.camera_plan import CameraAddress
from live.control.worker_thread import WorkerThread

MOST_EDGE: Final = 960
"""Longer edge [pixels] to which larger pictures are reduced: the model looks at 256."""
RATE: Final = 30.0
"""Pictures per second that are used; a faster camera's others are dropped."""
OPEN_AGAIN_S: Final = 1.0
"""Wait [s] before a lost camera is opened again."""
SILENT_S: Final = 2.0
"""A camera without a picture for this long [s] counts as gone."""
_STAMP_TRUST_S: Final = 0.5
"""A driver's time stamp that lies at most this [s] before the arrival is taken as the capture time."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One picture."""

    picture: UInt8
    """(H, W, 3), red, green, blue."""
    time: float
    """Capture time on the clock of `time.perf_counter` [s]; for a film the time at which it is due."""
    number: int
    """Number among the pictures that were used."""


class FrameSource:
    """Reads one camera. Thread: its own reads; `newest` is for one other."""

    def __init__(self, address: CameraAddress, *, loop: bool = True, rate: float = RATE, edge: int = MOST_EDGE,
                 now: Callable[[], float] = time.perf_counter) -> None:  # fmt: skip
        """`loop`: whether a film begins again at its end. `rate` [1/s]: the most pictures that are used. `edge`
        [pixels]: the longer edge to which larger pictures are reduced."""
        self.address = address
        self.problem = ""
        """Why there are no pictures; empty while there are."""
        self.size = (0, 0)
        """Width and height that the camera delivers [pixels]."""
        self.read = 0
        """Pictures that were used."""
        self.skipped = 0
        """Pictures that came faster than `rate`."""
        self.opened = 0
        """How often it was opened."""
        self.is_over = False
        """Whether a film that does not loop has ended."""
        self._loop, self._interval, self._edge, self._now = loop, 1.0 / rate, edge, now
        self._changed = threading.Condition()
        self._frame: Frame | None = None
        self._last = -math.inf
        self._worker = WorkerThread(f"camera {address.label}", self._read_all, part=f"the camera {address.label}")

    def start(self) -> None:
        """Start to read."""
        self._worker.start()

    def stop(self) -> None:
        """Stop reading; a camera that hangs is left behind."""
        self._worker.stop()

    def newest(self, after: int, timeout: float) -> Frame | None:
        """Return the newest picture with a number above `after`; wait at most `timeout` [s] for it."""
        with self._changed:
            self._changed.wait_for(lambda: self.is_over or self._is_after(after), timeout)
            return self._frame if self._is_after(after) else None

    def _is_after(self, number: int) -> bool:
        return self._frame is not None and self._frame.number > number

    @property
    def is_silent(self) -> bool:
        """Whether no picture has come for long."""
        return self._now() - self._last > SILENT_S

    def status(self) -> dict[str, Any]:
        """Return facts for the status."""
        return {
            "camera": self.address.label, "size": "x".join(map(str, self.size)), "pictures": self.read,
            "skipped": self.skipped, "opened": self.opened,
            "problem": self.problem or ("it sends no pictures" if self.is_silent else ""),
        }  # fmt: skip

    # -- reading: the source's own thread ------------------------------------------------------------------------------

    def _read_all(self) -> None:
        stopping = self._worker.stopping
        while not stopping.is_set() and not self.is_over:
            try:
                self._read_once(stopping)
            except (av.FFmpegError, OSError, ValueError, StopIteration) as error:
                self.problem = _words(error)
                stopping.wait(OPEN_AGAIN_S)

    def _read_once(self, stopping: threading.Event) -> None:
        """Open the camera and read until it ends."""
        is_film = self.address.kind == "film"
        with _opened(self.address) as container:
            stream = container.streams.video[0]
            stream.thread_count = 1
            self.opened += 1
            begin: float | None = None
            due = -math.inf
            for picture in container.decode(stream):
                if stopping.is_set():
                    return
                now = self._now()
                stamp = 0.0 if picture.time is None else float(picture.time)
                if is_film:  # played at its own speed; what is late is dropped, as a camera's would be
                    begin = now - stamp if begin is None else begin
                    when = begin + stamp
                    if when < due - 0.25 * self._interval:
                        self.skipped += 1
                        continue
                    if when > now and stopping.wait(when - now):
                        return
                else:
                    when = stamp if 0.0 <= now - stamp <= _STAMP_TRUST_S else now
                    if when < due - 0.25 * self._interval:
                        self.skipped += 1
                        continue
                due = max(due + self._interval, when + 0.5 * self._interval)
                self._take(picture, when)
        if is_film and not self._loop:
            with self._changed:
                self.is_over = True
                self._changed.notify_all()
        elif is_film:
            stopping.wait(self._interval)  # for as long as its last picture stands; a still one is not read without end
        else:
            self.problem = "it sends no pictures any more"
            stopping.wait(OPEN_AGAIN_S)

    def _take(self, picture: Any, when: float) -> None:
        """Keep a decoded picture as the newest."""
        self.size = (picture.width, picture.height)
        factor = min(1.0, self._edge / max(picture.width, picture.height))
        width, height = max(round(picture.width * factor), 16), max(round(picture.height * factor), 16)
        pixels = picture.to_ndarray(format="rgb24", width=width, height=height, interpolation="AREA")
        turned = np.ascontiguousarray(np.rot90(pixels, round(getattr(picture, "rotation", 0) / 90)))
        with self._changed:
            self.read += 1
            self.problem, self._last = "", self._now()
            self._frame = Frame(turned, when, self.read)
            self._changed.notify_all()


def _opened(address: CameraAddress) -> Any:
    """Open a camera for reading; one of PyAV's errors or OSError if that fails."""
    if address.kind == "device":
        form, name = capture_device(address.place)
        with contextlib.suppress(av.FFmpegError):
            return av.open(name, format=form, options={"framerate": f"{RATE:g}", "video_size": "1280x720"})
        return av.open(name, format=form)  # a camera without that size or rate gives what it has
    if address.kind == "film":
        return av.open(address.place)
    options = {"rtsp_transport": "tcp", "fflags": "nobuffer", "flags": "low_delay"}
    return av.open(address.place, options=options, timeout=(5.0, SILENT_S))


def _words(error: Exception) -> str:
    """Return why a camera has no pictures, in a few words."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return str(text)[:120]
