"""Images, videos and numbered image sequences for the scenography: checked before the show, decoded by a thread.

A show never waits for the decoder; an offline film does, for each picture. A picture that cannot be decoded is left out
and told; the one before it stays.
"""

import contextlib
import re
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError

Picture = npt.NDArray[np.uint8]
TimedPicture = tuple[float, Callable[[], Picture]]
"""Time in the video [s], and a function that makes the picture's pixels."""

IMAGE_SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff")
VIDEO_SUFFIXES: Final = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v")
MAX_PIXELS: Final = 100_000_000
"""Images with more pixels are refused before they are decoded."""
MAX_SIDE: Final = 2048
"""Longer side [pixels] to which images and videos are reduced."""
MAX_SEQUENCE: Final = 100_000
"""Maximum number of images of a sequence."""
NUMBER_SIGN: Final = "#"
"""Stands for the digits of the number in the name of an image sequence."""

_CONVERT_HINT: Final = "copy it again, or convert it: ffmpeg -i OLD -pix_fmt yuv420p NEW.mp4"


def is_video(path: Path) -> bool:
    """Whether a file is a video, judged by its name."""
    return path.suffix.lower() in VIDEO_SUFFIXES


def is_sequence(path: Path) -> bool:
    """Whether a name stands for a sequence of numbered images, as `rain_####.png`."""
    return NUMBER_SIGN in path.name


def check_media(path: Path) -> None:
    """Raise PersonError if a file cannot be shown; reads its first picture."""
    kinds = ", ".join((*IMAGE_SUFFIXES, *VIDEO_SUFFIXES))
    if path.suffix.lower() not in (*IMAGE_SUFFIXES, *VIDEO_SUFFIXES):
        raise PersonError(f"{path.name!r} is neither an image nor a video by its name", f"one of {kinds}")
    if is_sequence(path):
        read_image(sequence_files(path)[0][1])
    elif is_video(path):
        open_video(path).close()
    else:
        read_image(path)


def read_image(path: Path) -> Picture:
    """Return the pixels of an image, upright, (H, W, 3), or (H, W, 4) if parts of it are transparent; top row first.
    PersonError if it cannot be read."""
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
            see_through = image.has_transparency_data
            upright = ImageOps.exif_transpose(image).convert("RGBA" if see_through else "RGB")
            upright.thumbnail((MAX_SIDE, MAX_SIDE))
            return np.asarray(upright, np.uint8)
    except PersonError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise PersonError(
            f"the image {path.name!r} cannot be read: {_error_text(error)}", "save it again as PNG or JPEG"
        ) from None


def sequence_files(path: Path) -> list[tuple[int, Path]]:
    """Return the numbers and files of an image sequence named as `rain_####.png`, in order; PersonError if there are
    none. One sign stands for any number of digits, several for as many."""
    signs = re.fullmatch(r"([^#]*)(#+)([^#]*)", path.name)
    if signs is None:
        raise PersonError(f"{path.name!r}: the signs # stand together", "as in rain_####.png")
    digits = "[0-9]{1,9}" if len(signs[2]) == 1 else f"[0-9]{{{len(signs[2])}}}"
    name = re.compile(f"{re.escape(signs[1])}({digits}){re.escape(signs[3])}")
    try:
        found = [(int(match[1]), each) for each in path.parent.iterdir() if (match := name.fullmatch(each.name))]
    except OSError as error:
        raise PersonError(f"the folder of {path.name!r} cannot be read: {error.strerror}") from None
    if not found:
        raise PersonError(f"there is no image {path.name!r}", "# stands for a digit: rain_0001.png, rain_0002.png, …")
    if len(found) > MAX_SEQUENCE:
        raise PersonError(f"{path.name!r}: {len(found)} images; {MAX_SEQUENCE} at most", "make a video of them")
    return sorted(found)


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
BLOCKING_TIMEOUT_S: Final = 20.0
"""An offline film waits for a picture so long [s]."""


class PictureStream(ABC):
    """Pictures by time, decoded ahead by a thread. `blocking`: `picture_at` waits until the right one is decoded, as
    for an offline film.

    Thread: `picture_at` and `close` from one thread; a separate thread decodes.
    """

    seconds: float
    """Duration [s]."""
    size: tuple[int, int]
    """Width and height of the pictures [pixels]."""
    components: int
    """3: red, green, blue; 4: with opacity."""

    def __init__(self, period: float, *, blocking: bool) -> None:
        """`period`: time between two pictures [s]. Starts the thread, so call it last."""
        self.problem = ""
        """Why a picture could not be decoded, or empty; the last one before it stays."""
        self._blocking, self._period = blocking, period
        self._ready: deque[tuple[float, Picture]] = deque()
        self._target_time = 0.0
        self._seek = True
        self._exhausted = False
        self._shown = -1.0
        self._condition = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="scenery video", daemon=True)
        self._thread.start()

    @abstractmethod
    def _pictures_from(self, seconds: float) -> Iterator[TimedPicture]:
        """Yield the pictures from a time on, beginning with one at or before it if there is one."""

    @abstractmethod
    def _close_source(self) -> None:
        """Close the file."""

    @property
    def aspect(self) -> float:
        """Width by height of the picture."""
        return self.size[0] / self.size[1]

    def picture_at(self, seconds: float) -> Picture | None:
        """Return the picture at this time of the video, (H, W, 3 or 4), or None if it is the one returned last."""
        seconds = min(max(seconds, 0.0), self.seconds)
        with self._condition:
            self._request(seconds)
            if self._blocking:
                self._condition.wait_for(lambda: self._is_decoded(seconds), timeout=BLOCKING_TIMEOUT_S)
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
            self._seek, self._exhausted = True, False
            self._ready.clear()
            self._shown = -1.0
        self._target_time = seconds
        self._condition.notify_all()

    def _is_decoded(self, seconds: float) -> bool:
        """Whether the picture at this time is decoded, or will never be."""
        if self._seek:
            return False
        return self._exhausted or (bool(self._ready) and self._ready[-1][0] > seconds)

    def _run(self) -> None:
        while not self._closing:
            try:
                self._decode()
            except Exception as error:  # a damaged file must not end a show: the last picture stays
                self._tell(error)
            with self._condition:
                self._exhausted = not self._seek
                self._condition.notify_all()
        self._close_source()

    def _tell(self, error: Exception) -> None:
        self.problem = _error_text(error)

    def _decode(self) -> None:
        """Decode from the wanted time to the end, or to the next seek."""
        with self._condition:
            self._condition.wait_for(lambda: self._closing or self._seek)
            self._seek = False
            wanted = self._target_time
        if self._closing:
            return
        kept: TimedPicture | None = None
        last = -1.0
        try:
            for time, make in self._pictures_from(wanted):
                last = time
                if time < wanted - 1e-6:
                    kept = time, make  # the last picture before the wanted time is visible at that time
                    continue
                for one in (kept, (time, make)) if kept is not None else ((time, make),):
                    if not self._enqueue(*one):
                        return
                kept = None
        finally:
            if kept is not None:
                self._enqueue(*kept)
        if 0.0 <= last < self.seconds - 2.0 * self._period - 0.1:
            self._tell(OSError(f"it ends after {last:.1f} of {self.seconds:.1f} s; the last picture stays"))

    def _enqueue(self, time: float, make: Callable[[], Picture]) -> bool:
        """Queue a picture; False if a seek came in between."""
        try:
            picture = make()
        except Exception as error:  # one damaged picture is left out
            self._tell(error)
            return True
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
        """End the thread, which closes the file; waits at most 5 s for it."""
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        self._thread.join(timeout=5.0)


class Video(PictureStream):
    """Pictures of a video file; with opacity if its format has it (ProRes 4444, QuickTime Animation, PNG)."""

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
        shrunk = min(1.0, MAX_SIDE / max(stream.width, stream.height))
        self.size = max(round(stream.width * shrunk), 1), max(round(stream.height * shrunk), 1)
        layout = stream.codec_context.format
        self.components = 4 if layout is not None and any(part.is_alpha for part in layout.components) else 3
        super().__init__(1.0 / rate, blocking=blocking)

    def _pictures_from(self, seconds: float) -> Iterator[TimedPicture]:
        import av

        stream = self._container.streams.video[0]
        self._container.seek(max(int(seconds / stream.time_base), 0), stream=stream)
        for packet in self._container.demux(stream):
            try:
                frames = packet.decode()
            except av.FFmpegError as error:  # the pictures after a damaged one may be whole
                self._tell(error)
                continue
            for frame in frames:
                time = float(frame.pts * frame.time_base) if frame.pts is not None else seconds
                yield time, partial(self._pixels, frame)

    def _pixels(self, frame: Any) -> Picture:
        layout = "rgb24" if self.components == 3 else "rgba"
        return np.asarray(frame.reformat(width=self.size[0], height=self.size[1], format=layout).to_ndarray(), np.uint8)

    def _close_source(self) -> None:
        with contextlib.suppress(PersonError, OSError):
            self._container.close()


class ImageSequence(PictureStream):
    """Numbered images, `rate` a second: missing numbers and damaged images keep the picture before them."""

    def __init__(self, path: Path, rate: float, *, blocking: bool = False) -> None:
        """Raises PersonError if there are no images, or the first one cannot be read."""
        self._files, self._rate = sequence_files(path), rate
        first = read_image(self._files[0][1])
        self.size, self.components = (first.shape[1], first.shape[0]), first.shape[2]
        self._first_number = self._files[0][0]
        self.seconds = (self._files[-1][0] - self._first_number + 1) / rate
        super().__init__(1.0 / rate, blocking=blocking)

    def _pictures_from(self, seconds: float) -> Iterator[TimedPicture]:
        times = [(number - self._first_number) / self._rate for number, _ in self._files]
        begin = max(int(np.searchsorted(times, seconds, side="right")) - 1, 0)
        for time, (_, file) in zip(times[begin:], self._files[begin:], strict=True):
            yield time, partial(self._pixels, file)

    def _pixels(self, file: Path) -> Picture:
        picture = read_image(file)
        height, width = picture.shape[:2]
        if (width, height) != self.size or picture.shape[2] != self.components:
            from PIL import Image

            image = Image.fromarray(picture).convert("RGB" if self.components == 3 else "RGBA")
            picture = np.asarray(image.resize(self.size), np.uint8)
        return picture

    def _close_source(self) -> None:
        """Each file is closed as soon as it is read."""
