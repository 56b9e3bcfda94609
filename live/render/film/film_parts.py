"""Films in parts: pictures that are encoded by several processes, joined to one film without encoding them again.

A part is a file of packets as they come from the encoder. It begins where a segment of the film begins
(`VideoEncoder`), so the joined film has the packets of a film that was encoded in one go.
"""

import contextlib
import struct
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO, Final

import av

from live.render.film.container_formats import encoder_options, format_of, segment_length
from live.render.film.film_writer import FilmError, FilmWriter, open_container
from live.render.film.image_sequence import SOUND_FILE, WaveFile
from live.render.film.streams import AudioStream, FilmSound, VideoEncoder

_PACKET: Final = struct.Struct("<qqqBI")
"""Presentation and decoding time and length [frames], whether it is a key frame, bytes."""
_MAX_PACKET: Final = 1 << 30
_HEADER: Final = -1
"""Length of the first record, which holds the encoder's data for the whole stream."""


class PartWriter(FilmWriter):
    """Writes a part of a film, without sound, to a file of packets; the name of the whole film selects the format."""

    def __init__(
        self,
        path: Path,
        film: Path,
        *,
        size: tuple[int, int],
        fps: float | Fraction,
        first: int,
        threads: int,
        alpha: bool = False,
    ) -> None:
        """`first`: number of its first frame in the whole show. Raises as `FilmWriter`."""
        self._part = path
        super().__init__(film, size=size, fps=fps, alpha=alpha, first=first, threads=threads)

    @contextlib.contextmanager
    def _open(self) -> Iterator["_PartEncoder"]:
        video = VideoEncoder(
            self.size, self.fps, self._kind, self._options, alpha=self._alpha, first=self._first,
            segment=self._segment, threads=self._threads,
        )  # fmt: skip
        with self._part.open("wb") as file:
            yield _PartEncoder(file, video)


class _PartEncoder:
    def __init__(self, file: BinaryIO, video: VideoEncoder) -> None:
        self._file, self._video, self._begun = file, video, False

    def encode(self, source: Any) -> None:
        """Encode a new frame."""
        self._write(self._video.encode(source))

    def repeat(self) -> None:
        """Encode the last frame again."""
        self._write(self._video.repeat())

    def finish(self) -> None:
        """Flush the encoder."""
        self._write(self._video.finish())

    def _write(self, packets: list[Any]) -> None:
        for packet in packets:
            if not self._begun:
                self._begun = True
                self._record(self._video.stream_data, (0, 0, _HEADER, False))
            self._record(bytes(packet), (packet.pts, packet.dts, packet.duration or 1, packet.is_keyframe))

    def _record(self, data: bytes, times: tuple[int, int, int, bool]) -> None:
        self._file.write(_PACKET.pack(*times, len(data)))
        self._file.write(data)


def join_parts(
    path: Path,
    parts: Sequence[tuple[Path, int]],
    *,
    size: tuple[int, int],
    fps: float | Fraction,
    sound: FilmSound | None,
    alpha: bool = False,
) -> None:
    """Write the film of all parts, each with its number of frames, in order, and its sound.

    FilmError if a part is damaged or was made by another encoder, or the film cannot be written.
    """
    kind, rate = format_of(path), Fraction(fps).limit_denominator(1001)
    try:
        with open_container(path, kind) as container:
            stream = container.add_stream(kind.video, rate=rate)
            stream.time_base = 1 / rate
            VideoEncoder(
                (size[0] - size[0] % 2, size[1] - size[1] % 2), rate, kind, encoder_options(kind), alpha=alpha,
                segment=segment_length(rate, kind), context=stream.codec_context,
            )  # fmt: skip
            audio = AudioStream(container, sound, kind.audio) if sound is not None else None
            container.start_encoding()
            done = 0
            for part, frames in parts:
                count = 0
                for packet in _read(part, bytes(stream.codec_context.extradata or b"")):
                    count += 1
                    packet.stream, packet.time_base = stream, 1 / rate
                    packet.pts, packet.dts = packet.pts + done, packet.dts + done
                    container.mux(packet)
                    if audio is not None:
                        audio.encode_until((done + min(count, frames)) / rate)
                if count != frames:
                    raise FilmError(f"{part}: the part has {count} pictures instead of {frames}")
                done += frames
            if audio is not None:
                audio.encode_until(done / rate, last=True)
    except (OSError, av.FFmpegError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FilmError(f"{path}: the film cannot be written: {reason}") from error


def _read(part: Path, expected: bytes) -> Iterator[Any]:
    """Yield the packets of a part; `expected`: the encoder's data for the whole stream."""
    with part.open("rb") as file:
        while head := file.read(_PACKET.size):
            if len(head) < _PACKET.size:
                raise FilmError(f"{part}: the part is cut off")
            pts, dts, length, key, size = _PACKET.unpack(head)
            data = file.read(size) if size <= _MAX_PACKET else b""
            if len(data) < size or size > _MAX_PACKET:
                raise FilmError(f"{part}: the part is damaged")
            if length == _HEADER:
                if data != expected:
                    raise FilmError(f"{part}: the part was made by another version of the encoder")
                continue
            packet = av.Packet(data)
            packet.pts, packet.dts, packet.duration, packet.is_keyframe = pts, dts, length, bool(key)
            yield packet


def write_sound(path: Path, sound: FilmSound, frames: int, fps: float | Fraction) -> None:
    """Write the sound of a folder of pictures, `path` with the pictures' name; FilmError if it fails."""
    rate = Fraction(fps).limit_denominator(1001)
    try:
        file = WaveFile(path.parent / SOUND_FILE, sound)
        with contextlib.closing(file):
            for frame in range(1, frames + 1):
                file.write_until(frame / rate)
    except OSError as error:
        raise FilmError(f"{path}: the sound cannot be written: {error.strerror or error}") from error
