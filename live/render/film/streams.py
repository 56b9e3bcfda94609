"""Encoders for the video and audio streams of an open film, and the source of its sound."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np
import numpy.typing as npt
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
    ) -> None:
        """`options` of the encoder override those of `kind`; `alpha`: frames are RGBA."""
        self._container, self._kind = container, kind
        self._fps = fps
        self._pixels = kind.pixels if not alpha or kind.alpha_pixels is None else kind.alpha_pixels
        self._stream = container.add_stream(kind.video, rate=fps)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = self._pixels
        self._stream.time_base = 1 / fps
        self._stream.options = {**dict(kind.alpha_options if alpha else kind.options), **options}
        codec = self._stream.codec_context
        if not kind.is_rgb:
            codec.colorspace, codec.color_primaries = Colorspace.ITU709, ColorPrimaries.BT709
            codec.color_trc, codec.color_range = ColorTrc.BT709, ColorRange.MPEG
        if kind.video == "libx264":
            codec.gop_size = max(1, round(kind.key_frame_interval * fps))
        self._reformatter = VideoReformatter()
        self._audio = AudioStream(container, sound, kind.audio) if sound else None
        self._last: Any = None
        self.count = 0
        """Frames so far."""

    def encode(self, source: Any) -> None:
        """Encode a new frame."""
        if self._kind.is_rgb:
            self._last = self._reformatter.reformat(source, format=self._pixels)
        else:
            self._last = self._reformatter.reformat(
                source, format=self._pixels, dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
            )
        self.repeat()

    def repeat(self) -> None:
        """Encode the last frame (again), and the sound up to its end."""
        self._last.pts, self._last.time_base, self._last.duration = self.count, 1 / self._fps, 1
        self._container.mux(self._stream.encode(self._last))
        self.count += 1
        if self._audio:
            self._audio.encode_until(self.count / self._fps)

    def skip(self, frames: int) -> None:
        """Leave out `frames` frames: the previous frame is shown longer."""
        self.count += frames

    def finish(self) -> None:
        """Flush the encoders."""
        self._container.mux(self._stream.encode(None))
        if self._audio:
            self._audio.encode_until(self.count / self._fps, last=True)
