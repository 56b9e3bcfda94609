"""The streams of an open film: pictures of a constant rate, and the sound beside them."""

from fractions import Fraction
from typing import Any

from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc, VideoReformatter

from live.render.film.container_formats import FilmKind
from live.render.film.film_sound import FilmSound, SoundTrack


class FilmEncoder:
    """Encodes into an open container. Thread: the encoder's alone."""

    def __init__(
        self,
        container: Any,
        size: tuple[int, int],
        fps: Fraction,
        kind: FilmKind,
        options: dict[str, str],
        sound: FilmSound | None,
        *,
        alpha: bool = False,
    ) -> None:
        """`options` of the encoder go before those of the kind; `alpha`: pictures are RGBA."""
        self._container, self._kind = container, kind
        self._fps = fps
        self._pixels = kind.pixels if not alpha or kind.alpha_pixels is None else kind.alpha_pixels
        self._stream = container.add_stream(kind.video, rate=fps)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = self._pixels
        self._stream.time_base = 1 / fps
        self._stream.options = {**dict(kind.alpha_options if alpha else kind.options), **options}
        codec = self._stream.codec_context
        if not kind.rgb:
            codec.colorspace, codec.color_primaries = Colorspace.ITU709, ColorPrimaries.BT709
            codec.color_trc, codec.color_range = ColorTrc.BT709, ColorRange.MPEG
        if kind.video == "libx264":
            codec.gop_size = max(1, round(kind.seconds_whole * fps))
        self._reformatter = VideoReformatter()
        self._track = SoundTrack(container, sound, kind.audio) if sound else None
        self._last: Any = None
        self.count = 0
        """Frames so far."""

    def picture(self, source: Any) -> None:
        """Encode a new picture."""
        if self._kind.rgb:
            self._last = self._reformatter.reformat(source, format=self._pixels)
        else:
            self._last = self._reformatter.reformat(
                source, format=self._pixels, dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
            )
        self.repeat()

    def repeat(self) -> None:
        """Encode the last picture (once more), and the sound beside it."""
        self._last.pts, self._last.time_base, self._last.duration = self.count, 1 / self._fps, 1
        self._container.mux(self._stream.encode(self._last))
        self.count += 1
        if self._track:
            self._track.follow(self.count / self._fps)

    def skip(self, frames: int) -> None:
        """Leave out so many frames: the picture before them stays."""
        self.count += frames

    def finish(self) -> None:
        """Bring out what the encoders still hold."""
        self._container.mux(self._stream.encode(None))
        if self._track:
            self._track.follow(self.count / self._fps, last=True)
