"""Video file writer: encodes frames and sound in a thread, without blocking the frame loop."""

import contextlib
import threading
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from queue import SimpleQueue
from types import TracebackType
from typing import Any, NamedTuple, Protocol, Self

import av
import numpy as np
import numpy.typing as npt

from live.base.system.process_control import yield_thread_priority
from live.render.film.container_formats import VideoFormat, encoder_options, format_of, segment_length
from live.render.film.streams import ENCODER_THREADS, FilmEncoder, FilmSound

Picture = npt.NDArray[np.uint8]

_FAILED = -1
"""Queued in place of a free slot when the encoder has ended, so that `write` does not wait for ever."""
ENCODER_NICE = 5
"""How much lower the priority of a live film's threads is than the show's."""


class FilmError(RuntimeError):
    """The film cannot be written; the text names the file and the reason."""


class _Job(NamedTuple):
    slot: int | None
    """The frame to encode; None at the end of the film."""
    repeats: int
    """How often the previous frame is repeated first, in place of dropped frames."""


class PictureEncoder(Protocol):
    """Encodes pictures in order, in the thread of a `FilmWriter`."""

    def encode(self, source: Any) -> None:
        """Encode a new frame."""

    def repeat(self) -> None:
        """Encode the last frame again."""

    def finish(self) -> None:
        """Flush the encoders."""


class PictureWriter(Protocol):
    """A sink for the frames of a film, in order."""

    def write(self, picture: Picture) -> None:
        """Add one picture."""

    def close(self) -> None:
        """Complete the film."""

    def __enter__(self) -> Self: ...

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Close it."""


class FilmWriter:
    """Writes one film with a constant frame rate, in the format of its file name extension (`container_formats.py`).

    Encodes in its own thread behind a few preallocated frames.
    `size`: width and height of the incoming frames [pixels]; an odd size loses its last column or row, which is
    reported in `notes`. `sound`: see `FilmSound`; it is cut or padded to the length of the video.
    `alpha`: frames are RGBA with straight alpha, as `AlphaPass` draws them.
    `first`: number of the first frame in the whole show: on this grid the film is encoded in segments
    (`VideoEncoder`), by so many `threads`, unless it is live.
    `live`: when the encoder is behind, a frame is dropped and counted in `dropped`, and the previous frame is repeated,
    so that the film keeps time and the show is never delayed; otherwise `write` waits. A live film is written in
    fragments (mp4): after a power failure, the part written so far can be played.

    Raises ValueError for an invalid name, size or rate, and for alpha where the format has none; `FilmError` at once
    when the file cannot be opened (missing folder, no write permission, no codec). Later failures (a full disk) are
    raised once, by the next `write` or by `close`; further frames are then ignored.
    Thread: `write` and `close` from one thread.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        size: tuple[int, int],
        fps: float | Fraction,
        sound: FilmSound | None = None,
        live: bool = False,
        depth: int = 8,
        alpha: bool = False,
        first: int = 0,
        threads: int = ENCODER_THREADS,
    ) -> None:
        width, height = size
        if width < 2 or height < 2:
            raise ValueError(f"a film of {width}x{height} pixels: at least 2 each way are needed")
        self.path = Path(path)
        self._kind, self._alpha = format_of(self.path), alpha
        if alpha and self._kind.alpha_pixels is None:
            raise ValueError(f"{path}: a film of this kind has no alpha")
        self.size = (width - width % 2, height - height % 2)
        self.fps = Fraction(fps).limit_denominator(1001)
        if not 1 <= self.fps <= 1000:
            raise ValueError(f"a film of {float(fps):g} frames/s: 1 to 1000 are possible")
        self.notes: tuple[str, ...] = ()
        if self.size != size:
            self.notes = (f"{self.path}: {width}x{height} is odd; the film is {self.size[0]}x{self.size[1]}",)
        self.frames = 0
        self.dropped = 0
        self._input_shape = (height, width, 4 if alpha else 3)
        self._live = live
        self._first, self._segment, self._threads = first, 0 if live else segment_length(self.fps, self._kind), threads
        self._sound = sound
        self._options = encoder_options(self._kind, live=live)
        self._sources = [av.VideoFrame(*self.size, "rgba" if alpha else "rgb24") for _ in range(depth)]
        self._pixels = [frame_pixels(source, 4 if alpha else 3) for source in self._sources]
        self._free: SimpleQueue[int] = SimpleQueue()
        self._jobs: SimpleQueue[_Job] = SimpleQueue()
        self._repeats = 0
        self._failure: BaseException | None = None
        self._reported = False
        self._closed = False
        for slot in range(depth):
            self._free.put(slot)
        ready = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(ready,), name="film", daemon=True)
        self._thread.start()
        ready.wait()
        self._check()

    def write(self, picture: Picture, count: int = 1) -> None:
        """Add one picture, uint8 RGB (RGBA) of shape (height, width, 3 or 4), top row first; it is copied.

        It is shown for `count` frames; repeated frames cost hardly more.
        """
        if picture.shape != self._input_shape or picture.dtype != np.uint8:
            raise ValueError(
                f"a picture of shape {picture.shape}, {picture.dtype}: {self._input_shape}, uint8 is needed"
            )
        self._check()
        if self._closed or self._failure is not None:
            return
        self.frames += count
        if self._live and self._free.empty():
            self.dropped += 1
            self._repeats += count
            return
        slot = self._free.get()
        if slot == _FAILED:
            self._check()
            return
        width, height = self.size
        np.copyto(self._pixels[slot], picture[:height, :width])
        self._jobs.put(_Job(slot, self._repeats))
        self._repeats = count - 1

    def close(self) -> None:
        """Wait for the encoder and complete the file; a second call does nothing."""
        if not self._closed:
            self._closed = True
            self._jobs.put(_Job(None, self._repeats))
            self._thread.join()
            self._check()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            self.close()
        except FilmError:
            if error is None:  # the first error is reported
                raise

    def _check(self) -> None:
        if self._failure is not None and not self._reported:
            self._reported = True
            error = self._failure
            reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
            raise FilmError(f"{self.path}: the film cannot be written: {reason}") from error

    def _run(self, ready: threading.Event) -> None:
        """Open the file, encode all frames and close it, in the encoder's thread."""
        try:
            if self._live:
                yield_thread_priority(ENCODER_NICE)
            with self._open() as encoder:
                ready.set()
                self._encode_all(encoder)
        except BaseException as error:  # raised again in the thread that calls `write`
            self._failure = error
        finally:
            self._free.put(_FAILED)
            ready.set()

    @contextlib.contextmanager
    def _open(self) -> Iterator[PictureEncoder]:
        """Open the file."""
        with open_container(self.path, self._kind, live=self._live) as container:
            encoder = FilmEncoder(
                container, self.size, self.fps, self._kind, self._options, self._sound, alpha=self._alpha,
                first=self._first, segment=self._segment, threads=self._threads,
            )  # fmt: skip
            container.start_encoding()
            yield encoder

    def _encode_all(self, encoder: PictureEncoder) -> None:
        while True:
            job = self._jobs.get()
            for _ in range(job.repeats):
                encoder.repeat()
            if job.slot is None:
                encoder.finish()
                return
            encoder.encode(self._sources[job.slot])
            self._free.put(job.slot)


def open_container(path: Path, kind: VideoFormat, *, live: bool = False) -> Any:
    """Open a film's file for writing."""
    flags = "hybrid_fragmented+delay_moov" if live else "faststart"
    options = {"movflags": flags, "movie_timescale": "90000"}  # lengths in ms would cut the last picture short
    options = options if kind.container in ("mp4", "mov") else {}
    return av.open(str(path), "w", format=kind.container, options=options)


def frame_pixels(source: Any, channels: int) -> Picture:
    """Return the pixels of an RGB or RGBA frame as an array (height, width, channels) that shares its memory."""
    plane = source.planes[0]
    rows = np.frombuffer(plane, np.uint8)[: source.height * plane.line_size].reshape(source.height, plane.line_size)
    return rows[:, : source.width * channels].reshape(source.height, source.width, channels)
