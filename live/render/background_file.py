"""Files that are shown behind the dancers: what is wrong with one is said before the show."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError

Picture = npt.NDArray[np.uint8]

IMAGES: Final = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff")
VIDEOS: Final = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v")
MOST_PIXELS: Final = 100_000_000
"""Of an image: larger ones are refused before they are unpacked."""
LARGEST: Final = 2048
"""Longer side [pixels] to which images and videos are brought down."""

_ANEW: Final = "copy it again, or make a new one: ffmpeg -i OLD -pix_fmt yuv420p NEW.mp4"


def is_video(path: Path) -> bool:
    """Whether a file is one, by its name."""
    return path.suffix.lower() in VIDEOS


def check_background(path: Path) -> None:
    """PersonError if nothing can be shown of a file: its first picture is read."""
    kinds = ", ".join((*IMAGES, *VIDEOS))
    if path.suffix.lower() not in (*IMAGES, *VIDEOS):
        raise PersonError(f"{path.name!r} is neither an image nor a video by its name", f"one of {kinds}")
    if is_video(path):
        open_video(path).close()
    else:
        read_image(path)


def read_image(path: Path) -> Picture:
    """The pixels of an image as shown, (H, W, 3), the upper row first; PersonError if it cannot be read."""
    from PIL import Image, ImageOps

    try:
        with Image.open(path) as image:
            width, height = image.size
            if width * height > MOST_PIXELS:
                raise PersonError(
                    f"the image {path.name!r} has {width} x {height} pixels: {MOST_PIXELS / 1e6:g} million at most",
                    f"make it smaller; {LARGEST} pixels are enough",
                )
            image.draft("RGB", (LARGEST, LARGEST))
            upright = ImageOps.exif_transpose(image).convert("RGB")
            upright.thumbnail((LARGEST, LARGEST))
            return np.asarray(upright, np.uint8)
    except PersonError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise PersonError(
            f"the image {path.name!r} cannot be read: {_words(error)}", "save it anew as PNG or JPEG"
        ) from None


def open_video(path: Path) -> Any:
    """A video, as an open container of PyAV, of which one picture was decoded; PersonError if none can be."""
    import av

    try:
        container = av.open(str(path))
    except (OSError, ValueError, av.FFmpegError) as error:
        raise PersonError(f"the video {path.name!r} cannot be opened: {_words(error)}", _ANEW) from None
    try:
        if not container.streams.video:
            raise PersonError(f"{path.name!r} has no picture", _ANEW)
        container.streams.video[0].thread_type = "AUTO"
        next(container.decode(video=0))
        container.seek(0)
    except PersonError:
        container.close()
        raise
    except (OSError, ValueError, StopIteration, av.FFmpegError) as error:
        container.close()
        words = f"no picture of the video {path.name!r} can be decoded: {_words(error)}"
        raise PersonError(words, _ANEW) from None
    return container


def _words(error: Exception) -> str:
    """What is wrong, without the file's whole path."""
    known = getattr(error, "strerror", None)
    return str(known or error).partition(": '")[0].partition(" '/")[0] or type(error).__name__
