"""Image sequence writer: a folder of PNG files, one per frame, with the sound as a WAV file."""

import wave
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from live.render.film.film_writer import FilmError
from live.render.film.streams import FilmSound

Picture = npt.NDArray[np.uint8]

SOUND_FILE: Final = "sound.wav"
_THREADS: Final = 2
"""Frames that are compressed at the same time."""
_MAX_PENDING: Final = 4
"""Frames that may be queued for compression; beyond that `write` waits."""
_COMPRESSION: Final = 3
"""zlib level: twice as fast as the default, files a tenth larger."""


class ImageSequenceWriter:
    """Writes frames like `FilmWriter`, as PNG in sRGB, numbered from 1.

    `path`: the file name with a printf number, `frames/%05d.png`; the folder is created if its parent exists.
    `size`: width and height [pixels]. `alpha`: frames are RGBA with straight alpha. Existing files are overwritten.
    Raises `FilmError`: at once if the folder cannot be created; later, once, for a full disk.
    Thread: one; two others compress.
    """

    def __init__(
        self,
        path: Path,
        *,
        size: tuple[int, int],
        fps: float | Fraction,
        sound: FilmSound | None = None,
        alpha: bool = False,
    ) -> None:
        self.path, self.size = path, size
        self.fps = Fraction(fps).limit_denominator(1001)
        self.notes: tuple[str, ...] = ()
        self.frames = self.dropped = 0
        self._shape = (size[1], size[0], 4 if alpha else 3)
        self._sound, self._samples_written = sound, 0
        self._closed = False
        self._info = PngInfo()
        self._info.add(b"sRGB", b"\x00")
        try:
            path.parent.mkdir(exist_ok=True)
            self._wave = None if sound is None else _wave_file(path.parent / SOUND_FILE, sound)
        except OSError as error:
            raise self._error(error) from error
        self._pool = ThreadPoolExecutor(_THREADS, "pictures")
        self._jobs: deque[Future[None]] = deque()

    def write(self, picture: Picture) -> None:
        """Add one picture, uint8 of shape (height, width, 3 or 4), top row first; it is copied."""
        if picture.shape != self._shape or picture.dtype != np.uint8:
            raise ValueError(f"a picture of shape {picture.shape}, {picture.dtype}: {self._shape}, uint8 is needed")
        if self._closed:
            return
        self.frames += 1
        self._jobs.append(self._pool.submit(self._save, np.ascontiguousarray(picture).copy(), self.frames))
        self._wait_for_jobs(_MAX_PENDING)
        self._write_sound()

    def _save(self, picture: Picture, number: int) -> None:
        file = Path(str(self.path) % number)
        Image.fromarray(picture).save(file, format="png", compress_level=_COMPRESSION, pnginfo=self._info)

    def _wait_for_jobs(self, max_pending: int) -> None:
        """Wait until at most `max_pending` jobs remain."""
        while len(self._jobs) > max_pending:
            try:
                self._jobs.popleft().result()
            except OSError as error:
                self._closed = True
                self._pool.shutdown(cancel_futures=True)
                raise self._error(error) from error

    def _write_sound(self) -> None:
        """Write the sound up to the length of the video; missing samples are silence."""
        if self._wave is None or self._sound is None:
            return
        due = round(self.frames / self.fps * self._sound.rate)
        piece = np.zeros((due - self._samples_written, self._sound.channels), np.float32)
        read = self._sound.read(self._samples_written, due - self._samples_written)[: len(piece)]
        piece[: len(read)] = read
        self._samples_written = due
        whole = np.round(np.clip(np.nan_to_num(piece), -1.0, 1.0) * 32767.0).astype("<i2")
        try:
            self._wave.writeframesraw(whole.tobytes())
        except OSError as error:
            self._closed = True
            raise self._error(error) from error

    def _error(self, error: OSError) -> FilmError:
        return FilmError(f"{self.path}: the pictures cannot be written: {error.strerror or error}")

    def close(self) -> None:
        """Wait for the last frame and complete the sound; a second call does nothing."""
        if self._closed:
            return
        try:
            self._wait_for_jobs(0)
            if self._wave is not None:
                self._wave.close()
        except OSError as error:
            raise self._error(error) from error
        finally:
            self._closed = True
            self._pool.shutdown()

    def __enter__(self) -> "ImageSequenceWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            self.close()
        except FilmError:
            if error is None:  # the first error is reported
                raise


def _wave_file(path: Path, sound: FilmSound) -> wave.Wave_write:
    written = wave.open(str(path), "wb")  # noqa: SIM115 (closed with the last frame)
    written.setnchannels(sound.channels)
    written.setsampwidth(2)
    written.setframerate(sound.rate)
    return written
