"""Files of a film: MP4 without sound, its poster, and an animated WebP where a page cannot play films."""

import io
import math
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import av
import numpy as np
import numpy.typing as npt
from PIL import Image

Picture = npt.NDArray[np.uint8]
"""RGB, (height, width, 3), top row first."""

SIZE: Final = (640, 360)
"""Width and height of a film [pixels]."""
FPS: Final = 25
POSTER_BYTES: Final = 40_000
BEST: Final = 25
WORST: Final = 42
"""Constant rate factors of x264 for films: the best that is needed, and the worst that may be shown."""


class FilmTooLarge(RuntimeError):
    """A film does not fit its size even at the lowest quality."""


def write_film(pictures: Sequence[Picture], path: Path, max_bytes: int) -> None:
    """Write an H.264 film in the best quality that fits `max_bytes`; FilmTooLarge if none does."""
    quality, data = BEST, b""
    while quality <= WORST:
        data = encode(pictures, quality)
        if len(data) <= max_bytes:
            path.write_bytes(data)
            return
        quality += max(1, math.ceil(5.0 * math.log2(len(data) / max_bytes)))  # five steps halve a film
    raise FilmTooLarge(f"{path.name}: {len(data)} bytes, at most {max_bytes} are allowed; make it shorter or calmer")


def encode(pictures: Sequence[Picture], quality: int) -> bytes:
    """Return a film for web pages: yuv420p, its index first, without date and version."""
    options = {"movflags": "faststart", "fflags": "+bitexact", "movie_timescale": str(FPS)}
    with tempfile.TemporaryDirectory() as folder:  # the index can only be moved to the front of a file
        path = Path(folder) / "film.mp4"
        _encode_into(path, options, pictures, quality)
        return path.read_bytes()


def _encode_into(path: Path, options: dict[str, str], pictures: Sequence[Picture], quality: int) -> None:
    with av.open(str(path), "w", options=options) as container:
        stream = container.add_stream("libx264", rate=FPS)
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        stream.codec_context.thread_count = 1
        stream.options = {
            "preset": "slow", "crf": str(quality), "tune": "animation", "flags": "+bitexact",
            "x264-params": "cpu-independent=1",  # without it bytes differ from run to run
        }  # fmt: skip
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode(None))


def write_poster(picture: Picture, path: Path) -> None:
    """Write a still picture as JPEG, in the best quality that fits."""
    for quality in range(88, 30, -6):
        data = io.BytesIO()
        Image.fromarray(picture).save(data, "JPEG", quality=quality, optimize=True, progressive=True)
        if data.tell() <= POSTER_BYTES:
            path.write_bytes(data.getvalue())
            return
    raise FilmTooLarge(f"{path.name}: a poster has at most {POSTER_BYTES} bytes")


def write_webp(pictures: Sequence[Picture], path: Path, max_bytes: int, width: int) -> None:
    """Write every other picture, `width` pixels wide, as an animated WebP that loops."""
    size = (width, width * SIZE[1] // SIZE[0])
    frames = [Image.fromarray(each).resize(size, Image.Resampling.LANCZOS) for each in pictures[::2]]
    for quality in range(70, 10, -10):
        data = io.BytesIO()
        frames[0].save(
            data, "WEBP", save_all=True, append_images=frames[1:], duration=2000 // FPS, loop=0, quality=quality,
            method=4,
        )  # fmt: skip
        if data.tell() <= max_bytes:
            path.write_bytes(data.getvalue())
            return
    raise FilmTooLarge(f"{path.name}: more than {max_bytes} bytes")
