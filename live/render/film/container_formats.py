"""Video container formats and codecs, chosen by file name extension: for playback, for editing, lossless."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Final


@dataclass(frozen=True, slots=True)
class VideoFormat:
    """Container, codecs and options of one video format."""

    container: str
    """FFmpeg's name of the container format."""
    video: str
    """Name of the video encoder."""
    pixels: str
    """Pixel format without alpha."""
    alpha_pixels: str | None
    """Pixel format with alpha; None: not supported."""
    audio: str
    """Name of the audio encoder."""
    description: str
    """Description for people."""
    options: tuple[tuple[str, str], ...] = ()
    """Options of the video encoder without alpha."""
    alpha_options: tuple[tuple[str, str], ...] = ()
    """Options of the video encoder with alpha."""
    key_frame_interval: float = 2.0
    """Key frame interval [s] (H.264): at most this much of an unfinished live film is lost."""

    @property
    def is_rgb(self) -> bool:
        """Whether frames stay in RGB, without conversion to YUV."""
        return not self.pixels.startswith("yuv")


FORMATS: Final = {
    ".mp4": VideoFormat("mp4", "libx264", "yuv420p", None, "aac", "H.264, for playback"),
    ".mov": VideoFormat(
        "mov", "prores_ks", "yuv422p10le", "yuva444p10le", "pcm_s16le",
        "ProRes 422 HQ, with alpha ProRes 4444, for editing and grading",
        (("profile", "hq"), ("vendor", "apl0")), (("profile", "4444"), ("vendor", "apl0"), ("alpha_bits", "16")),
    ),
    ".mkv": VideoFormat(
        "matroska", "ffv1", "bgr0", "bgra", "pcm_s16le", "FFV1, lossless",
        (("level", "3"), ("slicecrc", "1")), (("level", "3"), ("slicecrc", "1")),
    ),
}  # fmt: skip
"""By file name extension."""


def format_of(path: Path) -> VideoFormat:
    """Return the format for this file name. Raises ValueError that lists the known extensions."""
    kind = FORMATS.get(path.suffix.lower())
    if kind is None:
        raise ValueError(f"{path}: a film's name ends in {', '.join(FORMATS)}")
    return kind


def encoder_options(kind: VideoFormat, *, live: bool = False) -> dict[str, str]:
    """Return what the encoder is told beside the options of the format; a `live` film is encoded faster."""
    return {"preset": "ultrafast" if live else "veryfast", "crf": "20"} if kind.video == "libx264" else {}


def segment_length(fps: Fraction, kind: VideoFormat) -> int:
    """Return the length of the segments in which a film is encoded [frames]: as far as key frames are apart."""
    return max(1, round(kind.key_frame_interval * fps))
