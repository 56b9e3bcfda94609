"""Files that are shown behind the dancers: what is wrong with one is said before the show.

A video behind the dancers: decoded ahead by a thread, never waited for in a show; in a film, picture by picture.
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

IMAGES: Final = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff")
VIDEOS: Final = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v")
MOST_PIXELS: Final = 100_000_000
"""Of an image: larger ones are refused before they are unpacked."""
LARGEST: Final = 2048
"""Longer side [pixels] to which images and videos are brought down."""

_ANEW: Final = "copy it again, or make a new one: ffmpeg -i OLD -pix_fmt yuv420p NEW.mp4"


def is_video(path: Path) -> bool:
    """Whether a file is one, by its name."""
    return path.suffix.lower() in VIDEOS


def check_background(path: Path) -> None:
    """PersonError if nothing can be shown of a file: its first picture is read."""
    kinds = ", ".join((*IMAGES, *VIDEOS))
    if path.suffix.lower() not in (*IMAGES, *VIDEOS):
        raise PersonError(f"{path.name!r} is neither an image nor a video by its name", f"one of {kinds}")
    if is_video(path):
        open_video(path).close()
    else:
        read_image(path)


def read_image(path: Path) -> Picture:
    """The pixels of an image as shown, (H, W, 3), the upper row first; PersonError if it cannot be read."""
    from PIL import Image, ImageOps

    try:
        with Image.open(path) as image:
            width, height = image.size
            if width * height > MOST_PIXELS:
                raise PersonError(
                    f"the image {path.name!r} has {width} x {height} pixels: {MOST_PIXELS / 1e6:g} million at most",
                    f"make it smaller; {LARGEST} pixels are enough",
                )
            image.draft("RGB", (LARGEST, LARGEST))
            upright = ImageOps.exif_transpose(image).convert("RGB")
            upright.thumbnail((LARGEST, LARGEST))
            return np.asarray(upright, np.uint8)
    except PersonError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise PersonError(
            f"the image {path.name!r} cannot be read: {_words(error)}", "save it anew as PNG or JPEG"
        ) from None


def open_video(path: Path) -> Any:
    """A video, as an open container of PyAV, of which one picture was decoded; PersonError if none can be."""
    import av

    try:
        container = av.open(str(path))
    except (OSError, ValueError, av.FFmpegError) as error:
        raise PersonError(f"the video {path.name!r} cannot be opened: {_words(error)}", _ANEW) from None
    try:
        if not container.streams.video:
            raise PersonError(f"{path.name!r} has no picture", _ANEW)
        container.streams.video[0].thread_type = "AUTO"
        next(container.decode(video=0))
        container.seek(0)
    except PersonError:
        container.close()
        raise
    except (OSError, ValueError, StopIteration, av.FFmpegError) as error:
        container.close()
        words = f"no picture of the video {path.name!r} can be decoded: {_words(error)}"
        raise PersonError(words, _ANEW) from None
    return container


def _words(error: Exception) -> str:
    """What is wrong, without the file's whole path."""
    known = getattr(error, "strerror", None)
    return str(known or error).partition(": '")[0].partition(" '/")[0] or type(error).__name__


AHEAD: Final = 6
"""Pictures that are decoded ahead."""
LEAP: Final = 1.0
"""A place so much [s] beyond what is decoded, or before it, is sought instead of reached picture by picture."""


class Video:
    """Pictures of one file by their time. `patient`: `at` waits until the right one is decoded, as for a film.

    Thread: `at` and `close` from one; a thread of its own decodes.
    """

    def __init__(self, path: Path, *, patient: bool = False) -> None:
        """PersonError if nothing can be decoded."""
        self._container = open_video(path)
        stream = self._container.streams.video[0]
        rate = float(stream.average_rate or 25.0)
        frames = stream.frames or 0
        seconds = float(stream.duration * stream.time_base) if stream.duration else frames / rate
        if not seconds and self._container.duration:
            seconds = self._container.duration / 1e6
        self.seconds = max(seconds, 1.0 / rate)
        """How long it is."""
        shrunk = min(1.0, LARGEST / max(stream.width, stream.height))
        self.size = max(round(stream.width * shrunk), 1), max(round(stream.height * shrunk), 1)
        """Width and height of its pictures [pixels]."""
        self.problem = ""
        """Why there are no new pictures any more, if there are none; the last one stays."""
        self._patient, self._period = patient, 1.0 / rate
        self._ready: deque[tuple[float, Picture]] = deque()
        self._wanted = 0.0
        self._seek = True
        self._shown = -1.0
        self._change = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="background video", daemon=True)
        self._thread.start()

    def at(self, seconds: float) -> Picture | None:
        """The picture at this time of the video, (H, W, 3), if it is another one than was given last."""
        seconds = min(max(seconds, 0.0), self.seconds)
        with self._change:
            self._aim(seconds)
            if self._patient:
                self._change.wait_for(lambda: self.problem or self._reached(seconds), timeout=20.0)
            found = None
            while self._ready and self._ready[0][0] <= seconds + 1e-6:
                found = self._ready.popleft()
            self._change.notify_all()
        if found is None or found[0] == self._shown:
            return None
        self._shown = found[0]
        return found[1]

    def _aim(self, seconds: float) -> None:
        """Say what is wanted; a place far from what is decoded is sought."""
        first = self._ready[0][0] if self._ready else self._wanted
        if seconds < min(first, self._wanted) - self._period or seconds > self._wanted + LEAP:
            self._seek = True
            self._ready.clear()
            self._shown = -1.0
        self._wanted = seconds
        self._change.notify_all()

    def _reached(self, seconds: float) -> bool:
        """Whether the picture at this time is among the decoded ones."""
        if self._seek or not self._ready:
            return False
        return self._ready[-1][0] > seconds or self._ready[-1][0] + 1.5 * self._period >= self.seconds

    def _run(self) -> None:
        try:
            while not self._closing:
                self._decode()
        except Exception as error:  # a damaged file must not end a show: the last picture stays
            with self._change:
                self.problem = str(error) or type(error).__name__
                self._change.notify_all()

    def _decode(self) -> None:
        """From the place that is wanted to the end, or to the next place that is sought."""
        with self._change:
            self._change.wait_for(lambda: self._closing or self._seek)
            self._seek = False
            wanted = self._wanted
        if self._closing:
            return
        stream = self._container.streams.video[0]
        self._container.seek(max(int(wanted / stream.time_base), 0), stream=stream)
        kept: tuple[float, Any] | None = None
        for frame in self._container.decode(stream):
            time = float(frame.pts * frame.time_base) if frame.pts is not None else wanted
            if time < wanted - 1e-6:
                kept = time, frame  # the last one before it is what is seen there
                continue
            for one in (kept, (time, frame)) if kept is not None else ((time, frame),):
                if not self._put(*one):
                    return
            kept = None
        if kept is not None:
            self._put(*kept)

    def _put(self, time: float, frame: Any) -> bool:
        """Hand a picture over; False if another place is sought meanwhile."""
        picture = frame.reformat(width=self.size[0], height=self.size[1], format="rgb24").to_ndarray()
        with self._change:
            self._change.wait_for(lambda: self._closing or self._seek or self._wants())
            if self._closing or self._seek:
                return False
            self._ready.append((time, np.ascontiguousarray(picture)))
            self._change.notify_all()
        return True

    def _wants(self) -> bool:
        """Whether there is room; a patient one needs pictures up to what is wanted, however many."""
        return len(self._ready) < AHEAD or self._ready[-1][0] <= self._wanted

    def close(self) -> None:
        """End the thread and close the file."""
        with self._change:
            self._closing = True
            self._change.notify_all()
        self._thread.join(timeout=5.0)
        with contextlib.suppress(PersonError, OSError):
            self._container.close()
