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
    """Writes frames like `FilmWriter`, as PNG in sRGB, numbered as the frames of the whole show.

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
        first: int = 0,
    ) -> None:
        """`first`: number of the first frame, from 0."""
        self._first = first
        self.path, self.size = path, size
        self.fps = Fraction(fps).limit_denominator(1001)
        self.notes: tuple[str, ...] = ()
        self.frames = self.dropped = 0
        self._shape = (size[1], size[0], 4 if alpha else 3)
        self._closed = False
        self._info = PngInfo()
        self._info.add(b"sRGB", b"\x00")
        try:
            path.parent.mkdir(exist_ok=True)
            self._wave = None if sound is None else WaveFile(path.parent / SOUND_FILE, sound)
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
        number = self._first + self.frames
        self.frames += 1
        self._jobs.append(self._pool.submit(self._save, np.ascontiguousarray(picture).copy(), number))
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
        if self._wave is not None:
            try:
                self._wave.write_until(self.frames / self.fps)
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


class WaveFile:
    """The sound of a film as a WAV file of 16 bits. Thread: one."""

    def __init__(self, path: Path, sound: FilmSound) -> None:
        """OSError if the file cannot be created."""
        self._sound, self._written = sound, 0
        self._file = wave.open(str(path), "wb")  # noqa: SIM115 (closed with the last frame)
        self._file.setnchannels(sound.channels)
        self._file.setsampwidth(2)
        self._file.setframerate(sound.rate)

    def write_until(self, seconds: Fraction) -> None:
        """Write the sound up to this length of the video [s]; missing samples are silence. OSError if it fails."""
        due = round(seconds * self._sound.rate)
        piece = np.zeros((due - self._written, self._sound.channels), np.float32)
        read = self._sound.read(self._written, due - self._written)[: len(piece)]
        piece[: len(read)] = read
        self._written = due
        whole = np.round(np.clip(np.nan_to_num(piece), -1.0, 1.0) * 32767.0).astype("<i2")
        self._file.writeframesraw(whole.tobytes())

    def close(self) -> None:
        """Complete the file."""
        self._file.close()
