"""Image and video files for the background: checked before the show; videos are decoded by a thread.

A show never waits for the decoder; an offline film does, for each picture.
"""

import contextlib
import threading
from collections import deque
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError

Picture = npt.NDArray[np.uint8]

IMAGE_SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff")
VIDEO_SUFFIXES: Final = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v")
MAX_PIXELS: Final = 100_000_000
"""Images with more pixels are refused before they are decoded."""
MAX_SIDE: Final = 2048
"""Longer side [pixels] to which images and videos are reduced."""

_CONVERT_HINT: Final = "copy it again, or convert it: ffmpeg -i OLD -pix_fmt yuv420p NEW.mp4"


def is_video(path: Path) -> bool:
    """Whether a file is a video, judged by its name."""
    return path.suffix.lower() in VIDEO_SUFFIXES


def check_background(path: Path) -> None:
    """Raise PersonError if a file cannot be shown; reads its first picture."""
    kinds = ", ".join((*IMAGE_SUFFIXES, *VIDEO_SUFFIXES))
    if path.suffix.lower() not in (*IMAGE_SUFFIXES, *VIDEO_SUFFIXES):
        raise PersonError(f"{path.name!r} is neither an image nor a video by its name", f"one of {kinds}")
    if is_video(path):
        open_video(path).close()
    else:
        read_image(path)


def read_image(path: Path) -> Picture:
    """Return the pixels of an image, upright, (H, W, 3), top row first; PersonError if it cannot be read."""
    from PIL import Image, ImageOps

    try:
        with Image.open(path) as image:
            width, height = image.size
            if width * height > MAX_PIXELS:
                raise PersonError(
                    f"the image {path.name!r} has {width} x {height} pixels: {MAX_PIXELS / 1e6:g} million at most",
                    f"make it smaller; {MAX_SIDE} pixels are enough",
                )
            image.draft("RGB", (MAX_SIDE, MAX_SIDE))
            upright = ImageOps.exif_transpose(image).convert("RGB")
            upright.thumbnail((MAX_SIDE, MAX_SIDE))
            return np.asarray(upright, np.uint8)
    except PersonError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise PersonError(
            f"the image {path.name!r} cannot be read: {_error_text(error)}", "save it again as PNG or JPEG"
        ) from None


def open_video(path: Path) -> Any:
    """Return a video as an open PyAV container; PersonError if its first picture cannot be decoded."""
    import av

    try:
        container = av.open(str(path))
    except (OSError, ValueError, av.FFmpegError) as error:
        raise PersonError(f"the video {path.name!r} cannot be opened: {_error_text(error)}", _CONVERT_HINT) from None
    try:
        if not container.streams.video:
            raise PersonError(f"{path.name!r} has no picture", _CONVERT_HINT)
        container.streams.video[0].thread_type = "AUTO"
        next(container.decode(video=0))
        container.seek(0)
    except PersonError:
        container.close()
        raise
    except (OSError, ValueError, StopIteration, av.FFmpegError) as error:
        container.close()
        words = f"no picture of the video {path.name!r} can be decoded: {_error_text(error)}"
        raise PersonError(words, _CONVERT_HINT) from None
    return container


def _error_text(error: Exception) -> str:
    """Return the error's text without the file's whole path."""
    known = getattr(error, "strerror", None)
    return str(known or error).partition(": '")[0].partition(" '/")[0] or type(error).__name__


QUEUE_LENGTH: Final = 6
"""Number of pictures decoded ahead."""
SEEK_DISTANCE_S: Final = 1.0
"""A jump of more than this [s] seeks instead of decoding the pictures between."""


class Video:
    """Pictures of a video file by time. `blocking`: `at` waits until the right one is decoded, as for an offline film.

    Thread: `at` and `close` from one thread; a separate thread decodes.
    """

    def __init__(self, path: Path, *, blocking: bool = False) -> None:
        """Raises PersonError if no picture can be decoded."""
        self._container = open_video(path)
        stream = self._container.streams.video[0]
        rate = float(stream.average_rate or 25.0)
        frames = stream.frames or 0
        seconds = float(stream.duration * stream.time_base) if stream.duration else frames / rate
        if not seconds and self._container.duration:
            seconds = self._container.duration / 1e6
        self.seconds = max(seconds, 1.0 / rate)
        """Duration [s]."""
        shrunk = min(1.0, MAX_SIDE / max(stream.width, stream.height))
        self.size = max(round(stream.width * shrunk), 1), max(round(stream.height * shrunk), 1)
        """Width and height of the pictures [pixels]."""
        self.problem = ""
        """Why decoding has stopped, or empty; the last picture stays."""
        self._blocking, self._period = blocking, 1.0 / rate
        self._ready: deque[tuple[float, Picture]] = deque()
        self._target_time = 0.0
        self._seek = True
        self._shown = -1.0
        self._condition = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="background video", daemon=True)
        self._thread.start()

    def picture_at(self, seconds: float) -> Picture | None:
        """Return the picture at this time of the video, (H, W, 3), or None if it is the one returned last."""
        seconds = min(max(seconds, 0.0), self.seconds)
        with self._condition:
            self._request(seconds)
            if self._blocking:
                self._condition.wait_for(lambda: self.problem or self._is_decoded(seconds), timeout=20.0)
            found = None
            while self._ready and self._ready[0][0] <= seconds + 1e-6:
                found = self._ready.popleft()
            self._condition.notify_all()
        if found is None or found[0] == self._shown:
            return None
        self._shown = found[0]
        return found[1]

    def _request(self, seconds: float) -> None:
        """Set the wanted time; one far from the decoded pictures causes a seek."""
        first = self._ready[0][0] if self._ready else self._target_time
        if seconds < min(first, self._target_time) - self._period or seconds > self._target_time + SEEK_DISTANCE_S:
            self._seek = True
            self._ready.clear()
            self._shown = -1.0
        self._target_time = seconds
        self._condition.notify_all()

    def _is_decoded(self, seconds: float) -> bool:
        """Whether the picture at this time is decoded."""
        if self._seek or not self._ready:
            return False
        return self._ready[-1][0] > seconds or self._ready[-1][0] + 1.5 * self._period >= self.seconds

    def _run(self) -> None:
        try:
            while not self._closing:
                self._decode()
        except Exception as error:  # a damaged file must not end a show: the last picture stays
            with self._condition:
                self.problem = str(error) or type(error).__name__
                self._condition.notify_all()

    def _decode(self) -> None:
        """Decode from the wanted time to the end, or to the next seek."""
        with self._condition:
            self._condition.wait_for(lambda: self._closing or self._seek)
            self._seek = False
            wanted = self._target_time
        if self._closing:
            return
        stream = self._container.streams.video[0]
        self._container.seek(max(int(wanted / stream.time_base), 0), stream=stream)
        kept: tuple[float, Any] | None = None
        for frame in self._container.decode(stream):
            time = float(frame.pts * frame.time_base) if frame.pts is not None else wanted
            if time < wanted - 1e-6:
                kept = time, frame  # the last picture before the wanted time is visible at that time
                continue
            for one in (kept, (time, frame)) if kept is not None else ((time, frame),):
                if not self._enqueue(*one):
                    return
            kept = None
        if kept is not None:
            self._enqueue(*kept)

    def _enqueue(self, time: float, frame: Any) -> bool:
        """Queue a picture; False if a seek came in between."""
        picture = frame.reformat(width=self.size[0], height=self.size[1], format="rgb24").to_ndarray()
        with self._condition:
            self._condition.wait_for(lambda: self._closing or self._seek or self._has_room())
            if self._closing or self._seek:
                return False
            self._ready.append((time, np.ascontiguousarray(picture)))
            self._condition.notify_all()
        return True

    def _has_room(self) -> bool:
        """Whether the queue has room; it always takes pictures up to the wanted time."""
        return len(self._ready) < QUEUE_LENGTH or self._ready[-1][0] <= self._target_time

    def close(self) -> None:
        """End the thread and close the file."""
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        self._thread.join(timeout=5.0)
        with contextlib.suppress(PersonError, OSError):
            self._container.close()
