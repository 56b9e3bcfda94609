"""Kinds of films by the ending of their name: to be shown, to be cut and graded, to be kept without loss."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final


@dataclass(frozen=True, slots=True)
class FilmKind:
    """How pictures and sound of a film are kept."""

    container: str
    """Name of the format."""
    video: str
    """Name of the encoder of the pictures ..."""
    pixels: str
    """... its layout of pixels ..."""
    alpha_pixels: str | None
    """... and that with alpha; None: it has none."""
    audio: str
    """Name of the encoder of the sound."""
    words: str
    """What it is, for people."""
    options: tuple[tuple[str, str], ...] = ()
    """Options of the encoder of the pictures ..."""
    alpha_options: tuple[tuple[str, str], ...] = ()
    """... and others with alpha."""
    seconds_whole: float = 2.0
    """So often there is a picture that needs no other (H.264): as much is lost of an unfinished live film at most."""

    @property
    def rgb(self) -> bool:
        """Whether pictures stay as they are drawn, without another space of colours."""
        return not self.pixels.startswith("yuv")


KINDS: Final = {
    ".mp4": FilmKind("mp4", "libx264", "yuv420p", None, "aac", "H.264, to be shown"),
    ".mov": FilmKind(
        "mov", "prores_ks", "yuv422p10le", "yuva444p10le", "pcm_s16le",
        "ProRes 422 HQ, with alpha ProRes 4444, to be cut and graded",
        (("profile", "hq"), ("vendor", "apl0")), (("profile", "4444"), ("vendor", "apl0"), ("alpha_bits", "16")),
    ),
    ".mkv": FilmKind(
        "matroska", "ffv1", "bgr0", "bgra", "pcm_s16le", "FFV1, without any loss",
        (("level", "3"), ("slicecrc", "1")), (("level", "3"), ("slicecrc", "1")),
    ),
}  # fmt: skip
"""By the ending of the file's name."""


def kind_of(path: Path) -> FilmKind:
    """The kind of a film with this name; ValueError that lists those there are."""
    kind = KINDS.get(path.suffix.lower())
    if kind is None:
        raise ValueError(f"{path}: a film's name ends in {', '.join(KINDS)}")
    return kind
