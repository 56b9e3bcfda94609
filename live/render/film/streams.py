"""Encoders for the video and audio streams of an open film, and the source of its sound."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

import av
import numpy as np
import numpy.typing as npt
from av.codec.context import Flags
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc, VideoReformatter

from live.render.film.container_formats import VideoFormat

Samples = npt.NDArray[np.float32]

AAC_RATES = (8000, 11025, 12000, 16000, 22050, 24000, 32000, 44100, 48000, 64000, 88200, 96000)
"""Sample rates of AAC [Hz]; sound of any other rate is resampled to 48,000."""


@dataclass(frozen=True, slots=True, eq=False)
class FilmSound:
    """Sound of one or two channels at `rate` [Hz], read in order, piece by piece, as the film grows.

    `read(first, count)` returns the samples of the film from number `first` on, float32 of shape (count, channels),
    -1 to 1. It returns fewer than `count` if the rest is not available yet (a live input lags behind the video): they
    are requested again with the next frame. Samples missing at the end are silence.
    Thread: `read` is called by the encoder's thread.
    """

    rate: int
    channels: int
    read: Callable[[int, int], Samples]

    @staticmethod
    def from_samples(samples: Samples, rate: int, *, start: float = 0.0, loop: bool = False) -> "FilmSound":
        """Return sound from an array, shape (n,) or (n, channels); of more than two channels the first two are used.

        The film begins at `start` [s] of the array (before 0: silence first). After the end of the array there is
        silence, or with `loop` the array again. Raises ValueError for an array of another shape.
        """
        if samples.ndim not in (1, 2) or (samples.ndim == 2 and samples.shape[1] == 0):
            raise ValueError(f"sound of shape {samples.shape}: (n,) or (n, channels) is needed")
        heard = samples[:, None] if samples.ndim == 1 else samples[:, :2]
        length, offset = len(heard), round(start * rate)

        def read(first: int, count: int) -> Samples:
            index = np.arange(offset + first, offset + first + count)
            inside = (index >= 0) & (length > 0)
            if loop and length:
                index %= length
            else:
                inside &= index < length
            piece = np.zeros((count, heard.shape[1]), np.float32)
            piece[inside] = heard[index[inside]]
            return piece

        return FilmSound(rate, heard.shape[1], read)


class AudioStream:
    """The audio stream of an open film, kept as long as the video."""

    def __init__(self, container: Any, sound: FilmSound, codec: str = "aac") -> None:
        if sound.channels not in (1, 2) or sound.rate < 1:
            raise ValueError(f"sound of {sound.channels} channels at {sound.rate} Hz: one or two are possible")
        self._container = container
        self._sound = sound
        self._layout = "mono" if sound.channels == 1 else "stereo"
        aac = codec == "aac"
        rate = sound.rate if not aac or sound.rate in AAC_RATES else 48000
        self._stream = container.add_stream(codec, rate=rate)
        self._stream.layout = self._layout
        if aac:
            self._stream.bit_rate = 96_000 * sound.channels
        self._resampler = av.AudioResampler(
            format="fltp" if aac else "s16", layout=self._layout, rate=rate, frame_size=1024
        )
        self._count = 0

    def encode_until(self, seconds: Fraction, *, last: bool = False) -> None:
        """Encode the sound up to the length of the video [s]; with `last` pad with silence and finish."""
        missing = round(seconds * self._sound.rate) - self._count
        if missing > 0:
            self._encode(self._sound.read(self._count, missing)[:missing])
        if last:
            missing = round(seconds * self._sound.rate) - self._count
            if missing > 0:
                self._encode(np.zeros((missing, self._sound.channels), np.float32))
            self._mux(None)
            self._container.mux(self._stream.encode(None))

    def _encode(self, piece: Samples) -> None:
        if len(piece) == 0:
            return
        # a NaN or an overdriven input must not end the film: the encoder rejects such samples
        planes = np.ascontiguousarray(np.clip(np.nan_to_num(piece.T), -1.0, 1.0), np.float32)
        frame = av.AudioFrame.from_ndarray(planes, format="fltp", layout=self._layout)
        frame.sample_rate = self._sound.rate
        frame.pts, frame.time_base = self._count, Fraction(1, self._sound.rate)
        self._count += len(piece)
        self._mux(frame)

    def _mux(self, frame: Any) -> None:
        for whole in self._resampler.resample(frame):
            self._container.mux(self._stream.encode(whole))


ENCODER_THREADS: Final = 4
"""Threads of an encoder: H.264 of another number has other bits, so it does not depend on the machine."""


class VideoEncoder:
    """Encodes the pictures of a film. Thread: the encoder's only.

    In segments (`segment` frames, on the grid of the show's frames, of which the film's first one is number `first`)
    each segment has an encoder of its own and depends on no picture before. So a film that is encoded in parts has the
    same packets as one encoded in one go. `segment` 0: all in one.
    """

    def __init__(
        self,
        size: tuple[int, int],
        fps: Fraction,
        kind: VideoFormat,
        options: dict[str, str],
        *,
        alpha: bool = False,
        first: int = 0,
        segment: int = 0,
        threads: int = ENCODER_THREADS,
        context: Any = None,
    ) -> None:
        """`options` of the encoder override those of `kind`; `alpha`: frames are RGBA. `context`: the codec context of
        a container's stream, for the first segment."""
        self._size, self._fps, self._kind, self._alpha = size, fps, kind, alpha
        self._options, self._threads = options, threads
        self._pixels = kind.pixels if not alpha or kind.alpha_pixels is None else kind.alpha_pixels
        self._reformatter = VideoReformatter()
        self._first, self._segment, self._begin = first, segment, 0
        self._context = self._new_context() if context is None else context
        self._configure(self._context)
        self._last: Any = None
        self.count = 0
        """Frames so far."""

    def _new_context(self) -> Any:
        context = av.CodecContext.create(self._kind.video, "w")
        context.flags |= Flags.global_header  # as all containers of films want it
        return context

    def _configure(self, codec: Any) -> None:
        codec.width, codec.height = self._size
        codec.pix_fmt = self._pixels
        codec.framerate, codec.time_base = self._fps, 1 / self._fps
        codec.options = {
            **dict(self._kind.alpha_options if self._alpha else self._kind.options), **self._options,
        }  # fmt: skip
        if not self._kind.is_rgb:
            codec.colorspace, codec.color_primaries = Colorspace.ITU709, ColorPrimaries.BT709
            codec.color_trc, codec.color_range = ColorTrc.BT709, ColorRange.MPEG
        if self._segment:
            codec.thread_count = self._threads
        if self._kind.video == "libx264":
            codec.gop_size = max(1, round(self._kind.key_frame_interval * self._fps))

    @property
    def stream_data(self) -> bytes:
        """What a container needs to know of the whole stream; there once something was encoded."""
        return bytes(self._context.extradata or b"")

    def encode(self, source: Any) -> list[Any]:
        """Encode a new frame; return the packets that are ready, with times in frames of the film."""
        if self._kind.is_rgb:
            self._last = self._reformatter.reformat(source, format=self._pixels)
        else:
            self._last = self._reformatter.reformat(
                source, format=self._pixels, dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
            )
        return self.repeat()

    def repeat(self) -> list[Any]:
        """Encode the last frame (again)."""
        done: list[Any] = []
        if self._segment and self.count and (self._first + self.count) % self._segment == 0:
            done = self.finish()
            self._context, self._begin = self._new_context(), self.count
            self._configure(self._context)
        self._last.pts, self._last.time_base, self._last.duration = self.count - self._begin, 1 / self._fps, 1
        done += self._timed(self._context.encode(self._last))
        self.count += 1
        return done

    def finish(self) -> list[Any]:
        """Flush the encoder; return the last packets."""
        return self._timed(self._context.encode(None))

    def _timed(self, packets: list[Any]) -> list[Any]:
        for packet in packets if self._begin else ():
            packet.pts += self._begin
            packet.dts += self._begin
        return packets


class FilmEncoder:
    """Encodes video and audio into an open container. Thread: the encoder's only."""

    def __init__(
        self,
        container: Any,
        size: tuple[int, int],
        fps: Fraction,
        kind: VideoFormat,
        options: dict[str, str],
        sound: FilmSound | None,
        *,
        alpha: bool = False,
        first: int = 0,
        segment: int = 0,
        threads: int = ENCODER_THREADS,
    ) -> None:
        """See `VideoEncoder`."""
        self._container = container
        self._fps = fps
        self._stream = container.add_stream(kind.video, rate=fps)
        self._stream.time_base = 1 / fps
        self._video = VideoEncoder(
            size, fps, kind, options, alpha=alpha, first=first, segment=segment, threads=threads,
            context=self._stream.codec_context,
        )  # fmt: skip
        self._audio = AudioStream(container, sound, kind.audio) if sound else None

    @property
    def count(self) -> int:
        """Frames so far."""
        return self._video.count

    def encode(self, source: Any) -> None:
        """Encode a new frame, and the sound up to its end."""
        self._mux(self._video.encode(source))

    def repeat(self) -> None:
        """Encode the last frame (again), and the sound up to its end."""
        self._mux(self._video.repeat())

    def _mux(self, packets: list[Any]) -> None:
        for packet in packets:
            packet.stream = self._stream
        self._container.mux(packets)
        if self._audio:
            self._audio.encode_until(self.count / self._fps)

    def skip(self, frames: int) -> None:
        """Leave out `frames` frames: the previous frame is shown longer."""
        self._video.count += frames

    def finish(self) -> None:
        """Flush the encoders."""
        self._mux(self._video.finish())
        if self._audio:
            self._audio.encode_until(self.count / self._fps, last=True)
