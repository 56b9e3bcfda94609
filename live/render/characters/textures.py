"""A character's images as the layers of one texture: checked before they are unpacked, made equal in size."""

import io
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from live.motion.formats.file_error import MotionFileError

UInt8 = npt.NDArray[np.uint8]

SIDE_LIMIT: Final = 8192
"""Pixels along a side of an image at most."""
PIXEL_LIMIT: Final = 150_000_000
"""Pixels of all images of a character at most."""
_SIDE: Final = 1024
_ROOM: Final = 24 << 20
"""Texels of all layers together."""
WHOLE: Final = _ROOM // (_SIDE * _SIDE) - 1
"""So many images keep their size."""
_SMALLER: Final = "export the character with images of 1024 or 2048 pixels"

_LINEAR: Final = np.arange(256) / 255.0
_LINEAR_OF: Final = np.where(_LINEAR <= 0.04045, _LINEAR / 12.92, ((_LINEAR + 0.055) / 1.055) ** 2.4)
_ROOTS: Final = np.rint(np.sqrt(_LINEAR_OF) * 255.0).astype(np.uint8)
"""Square roots of linear light, as all colours of dancers are kept, of sRGB bytes (IEC 61966-2-1)."""


def read_layers(images: list[bytes], file: str, numbers: frozenset[int] = frozenset()) -> UInt8:
    """Layers (L, S, S, 4) of an image each, after a white one: square roots of linear RGB, and opacity. Those whose
    place in `images` is in `numbers` hold no colours, and stay as they are.

    MotionFileError for what is no PNG, JPEG or WebP, is broken, or would take too much room.
    """
    opened = [_open(data, number, file) for number, data in enumerate(images)]
    if sum(image.width * image.height for image in opened) > PIXEL_LIMIT:
        raise MotionFileError(file, None, f"images of more than {PIXEL_LIMIT // 10**6} megapixels", _SMALLER)
    side = 4
    longest = max((max(image.size) for image in opened), default=1)
    while side < min(longest, _SIDE) and (2 * side) ** 2 * (len(opened) + 1) <= _ROOM:
        side *= 2
    layers = np.full((len(opened) + 1, side, side, 4), 255, np.uint8)
    for number, image in enumerate(opened):
        layers[number + 1] = _pixels(image, side, number, file)
    for number in range(len(layers)):
        if number - 1 not in numbers:
            layers[number, ..., :3] = _ROOTS[layers[number, ..., :3]]
    return layers


def _open(data: bytes, number: int, file: str) -> Image.Image:
    try:
        image = Image.open(io.BytesIO(data), formats=("PNG", "JPEG", "WEBP"))
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        raise MotionFileError(file, None, f"image {number} is no PNG, JPEG or WebP", "export it again") from None
    if max(image.size) > SIDE_LIMIT:
        words = f"image {number} has {image.width} x {image.height} pixels"
        raise MotionFileError(file, None, words, f"{SIDE_LIMIT} at most: {_SMALLER}")
    return image


def _pixels(image: Image.Image, side: int, number: int, file: str) -> UInt8:
    try:
        image.draft("RGB", (side, side))
        whole = image.convert("RGBA")
        return np.asarray(
            whole.resize((side, side), Image.Resampling.BOX if side < whole.width else Image.Resampling.BILINEAR)
        )
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        words = f"image {number} is broken: {' '.join(str(error).split())[:80]}"
        raise MotionFileError(file, None, words, "export it again") from None
